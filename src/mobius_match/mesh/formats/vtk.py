"""Legacy VTK files (.vtk), text or binary."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Ints
from .raw import RawMesh
from .text import promised

TYPES = {
    "float": "f4", "double": "f8", "int": "i4", "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8",
    "short": "i2", "unsigned_short": "u2", "char": "i1", "unsigned_char": "u1",
    "vtktypeint64": "i8", "vtkidtype": "i4",
}  # fmt: skip
SURFACE_CELLS = {5: 3, 7: 0, 9: 4}  # triangle, polygon (any size), quadrilateral
POINTS_AND_LINES = (1, 2, 3, 4)


class Cursor:
    """Moves through a legacy file, line by line and array by array."""

    def __init__(self, data: bytes, binary: bool, at: int) -> None:
        self.data, self.binary, self.at = data, binary, at

    def words(self) -> list[str]:
        """The next line that is not empty; [] at the end."""
        while self.at < len(self.data):
            end = self.data.find(b"\n", self.at)
            end = len(self.data) if end < 0 else end
            line = self.data[self.at : end].decode("latin-1").split()
            self.at = end + 1
            if line:
                return line
        return []

    def array(self, count: int, kind: str) -> NDArray:
        """The next `count` numbers."""
        if kind.lower() not in TYPES:
            raise FormatError(f"numbers of type {kind[:40]!r} cannot be read.")
        dtype = np.dtype(">" + TYPES[kind.lower()])
        left = len(self.data) - self.at
        if self.binary:
            promised(count * dtype.itemsize, "bytes of numbers", left, "bytes")
            out = np.frombuffer(self.data, dtype, count, self.at)
            self.at += count * dtype.itemsize
            return out.astype(np.float64 if dtype.kind == "f" else np.int64)
        promised(count, "numbers", left // 2 + 1, "at most")
        stop = re.compile(rb"\n\s*(?!nan|inf)[A-Za-z]", re.IGNORECASE).search(self.data, self.at - 1)
        end = stop.start() if stop else len(self.data)
        words = self.data[self.at : end].split()
        promised(count, "numbers", len(words), "numbers")
        self.at = end
        return np.array(words[:count], dtype=bytes).astype(np.float64 if dtype.kind == "f" else np.int64)


def read_vtk(data: bytes) -> RawMesh:
    """Read the polygons of a POLYDATA or UNSTRUCTURED_GRID file, versions 1 to 5."""
    head = re.match(
        rb"# vtk DataFile Version (\d+)[^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s*\n", data, re.IGNORECASE
    )
    if head is None:
        raise FormatError(
            "not a legacy VTK file: its first lines must be '# vtk DataFile Version', a title and a kind."
        )
    cursor = Cursor(data, head[2].upper() == b"BINARY", head.end())
    dataset = cursor.words()
    if len(dataset) != 2 or dataset[1].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
        raise FormatError(f"{' '.join(dataset)[:60]!r} is not a surface; save it as PolyData.")
    points = np.zeros((0, 3))
    cells: tuple[Ints, Ints] = np.zeros(0, np.int64), np.zeros(0, np.int64)
    kinds: Ints | None = None
    while words := cursor.words():
        match [words[0].upper(), *words[1:]]:
            case ["POINTS", count, kind]:
                points = cursor.array(3 * _count(count), kind).astype(np.float64).reshape(-1, 3)
            case ["POLYGONS" | "CELLS", count, size]:
                cells = _cells(cursor, _count(count), _count(size))
            case ["VERTICES" | "LINES", count, size]:
                _cells(cursor, _count(count), _count(size))
            case ["CELL_TYPES", count]:
                kinds = cursor.array(_count(count), "int")
            case ["TRIANGLE_STRIPS", *_]:
                raise FormatError("triangle strips are not read: apply a triangle filter and save again.")
            case ["FIELD", _, count]:
                for _ in range(min(_count(count), len(data))):
                    match cursor.words():
                        case [_, width, length, kind]:
                            cursor.array(_count(width) * _count(length), kind)
                        case _:
                            raise FormatError("a FIELD array without name, sizes and type.")
            case ["METADATA"]:
                end = data.find(b"\n\n", cursor.at - 1)
                cursor.at = len(data) if end < 0 else end + 2
            case ["POINT_DATA" | "CELL_DATA", *_]:
                break
            case _:
                raise FormatError(f"{' '.join(words)[:60]!r} is not understood in a legacy VTK file.")
    return surface(points, *cells, kinds)


def _count(word: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 16):
        raise FormatError(f"expected a count, found {word[:40]!r}.")
    return int(word)


def _cells(cursor: Cursor, count: int, size: int) -> tuple[Ints, Ints]:
    """Sizes and corners of cells: before version 5 rows k i1 ... ik, since then offsets and numbers."""
    mark = cursor.at
    words = cursor.words()
    if words and words[0].upper() == "OFFSETS" and len(words) == 2:
        offsets = cursor.array(count, words[1])
        words = cursor.words()
        if len(words) != 2 or words[0].upper() != "CONNECTIVITY":
            raise FormatError(
                "OFFSETS without CONNECTIVITY. The file is damaged or was cut short: export it again."
            )
        corners = cursor.array(size, words[1])
        sizes = np.diff(offsets)
        if len(offsets) and (offsets[0] != 0 or offsets[-1] != size or (sizes < 0).any()):
            raise FormatError("OFFSETS do not fit CONNECTIVITY. The file is damaged: export it again.")
        return sizes, corners
    cursor.at = mark
    flat = cursor.array(size, "int")
    promised(count, "cells", size, "numbers")
    starts = np.zeros(count, dtype=np.int64)
    at = 0
    if count and size == 4 * count and (flat[::4] == 3).all():
        starts = np.arange(count) * 4
    else:
        for row in range(count):
            if at >= size or flat[at] < 0 or at + flat[at] >= size:
                raise FormatError(
                    f"cell {row} (counting from 0) does not fit. The file is damaged: export it again."
                )
            starts[row] = at
            at += int(flat[at]) + 1
    inside = np.ones(size, dtype=bool)
    inside[starts] = False
    return flat[starts], flat[inside]


def surface(points: NDArray, sizes: Ints, corners: Ints, kinds: Ints | None) -> RawMesh:
    """The polygons among cells of the given VTK types: points and lines are left out, solid cells refused."""
    if kinds is None:
        return RawMesh(points, sizes, corners)
    if len(kinds) != len(sizes):
        raise FormatError(
            f"{len(sizes)} cells but {len(kinds)} cell types. The file is damaged: export it again."
        )
    wrong = ~np.isin(kinds, [*SURFACE_CELLS, *POINTS_AND_LINES])
    if wrong.any():
        raise FormatError(
            f"{wrong.sum()} cell(s) are neither triangles, quadrilaterals nor polygons (the first is cell "
            f"{np.flatnonzero(wrong)[0]}, VTK type {kinds[wrong][0]}). Extract the surface and save it "
            "as PolyData."
        )
    low = np.isin(kinds, POINTS_AND_LINES)
    notes = (
        [f"{low.sum()} point or line cell(s) kept in the numbering, but without a face."] if low.any() else []
    )
    # Faces keep the number of their cell: a cell without a surface becomes a face without corners.
    return RawMesh(points, np.where(low, 0, sizes), corners[~np.repeat(low, sizes)], notes)
