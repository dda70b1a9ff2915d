"""PLY, text and binary, with any further elements and properties."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Floats, Ints
from .raw import RawMesh
from .text import Lines, content_lines, decode, polygon_corners, promised, table, whole_numbers

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8",
    "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
INDEX_NAMES = ("vertex_indices", "vertex_index")


@dataclass
class Element:
    """One block of rows: each property is (name, type, type of the count or "" where it is no list)."""

    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)

    def column(self, name: str) -> int:
        """Place of a property in a row of text; lists may stand only behind it."""
        place = [known for known, _, _ in self.properties].index(name)
        if any(count for _, _, count in self.properties[:place]):
            raise FormatError(
                f"property {name} stands behind a list; export with plain vertices and faces only."
            )
        return place


def read_ply(data: bytes) -> RawMesh:
    """Read the vertex and face elements, skip all others."""
    end = re.search(rb"\bend_header[ \t]*(\r\n|\n|\r)", data)
    if not data.startswith(b"ply") or end is None:
        raise FormatError(
            "not a PLY file, or cut short within its header (no end_header line). Export it again."
        )
    order, elements = _header(decode(data[: end.start()]))
    names = [element.name for element in elements]
    for name, wanted in (("vertex", {"x", "y", "z"}), ("face", set(INDEX_NAMES))):
        if name not in names:
            raise FormatError(
                f"the header has no {name} element; a surface with vertices and faces is needed."
            )
        found = wanted & {known for known, _, _ in elements[names.index(name)].properties}
        if not found or (name == "vertex" and found != wanted):
            raise FormatError(f"the {name} element lacks its properties {' '.join(sorted(wanted))}.")
    return _text(data, end.end(), elements) if not order else _binary(data, end.end(), elements, order)


def _header(lines: list[str]) -> tuple[str, list[Element]]:
    order = None
    elements: list[Element] = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        match words:
            case ["format", kind, _] if kind in ORDERS:
                order = ORDERS[kind]
            case ["element", name, count]:
                elements.append(Element(name, whole_numbers(count, number, "a count")[0]))
            case ["property", kind, name] if kind in TYPES and elements:
                elements[-1].properties.append((name, TYPES[kind], ""))
            case ["property", "list", count, kind, name] if {count, kind} <= set(TYPES) and elements:
                elements[-1].properties.append((name, TYPES[kind], TYPES[count]))
            case [] | ["ply" | "comment" | "obj_info", *_]:
                pass
            case _:
                raise FormatError(
                    f"line {number}: {line[:60]!r} is not understood in the header of a PLY file."
                )
    if order is None:
        raise FormatError("the header has no format line (ascii, binary_little_endian or binary_big_endian).")
    return order, elements


def _text(data: bytes, start: int, elements: list[Element]) -> RawMesh:
    skipped = len(decode(data[:start])) - 1
    body = content_lines(data[start:])
    body.numbers = [number + skipped for number in body.numbers]
    promised(sum(element.count for element in elements), "rows", len(body), "lines")
    vertices, sizes, corners = np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64)
    at = 0
    for element in elements:
        rows = body.take(at, at + element.count)
        at += element.count
        if element.name == "vertex":
            places = [element.column(axis) for axis in "xyz"]
            vertices = table(rows, places, np.float64, "vertex")
        elif element.name == "face":
            sizes, corners = _text_faces(rows, element)
    return RawMesh(vertices, sizes, corners)


def _text_faces(rows: Lines, element: Element) -> tuple[Ints, Ints]:
    name = next(known for known, _, _ in element.properties if known in INDEX_NAMES)
    place = element.column(name)
    sizes: Ints = table(rows, [place], np.int64, "face")[:, 0]
    return sizes, polygon_corners(rows, sizes, place + 1)


def _binary(data: bytes, at: int, elements: list[Element], order: str) -> RawMesh:
    vertices, sizes, corners = np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64)
    for element in elements:
        least = sum(np.dtype(count or kind).itemsize for _, kind, count in element.properties)
        promised(element.count * least, f"bytes of {element.name} data at least", len(data) - at, "bytes")
        rows, at = _uniform(data, at, element, order)
        if rows is not None:
            if element.name == "vertex":
                vertices = _columns(rows)
            elif element.name == "face":
                name = next(known for known in rows.dtype.names or () if known in INDEX_NAMES)
                index = rows[name]
                sizes = np.full(len(rows), index.shape[1], dtype=np.int64)
                corners = index.astype(np.int64).ravel()
            continue
        found, at = _walk(data, at, element, order)
        if element.name == "face":
            sizes = np.array([len(row) for row in found], dtype=np.int64)
            corners = np.concatenate([*found, np.zeros(0, dtype=np.int64)]).astype(np.int64)
        elif element.name == "vertex":
            raise FormatError("vertices with lists of varying length cannot be read; export plain vertices.")
    return RawMesh(vertices, sizes, corners)


def _columns(rows: NDArray[np.void]) -> Floats:
    return np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)


def _uniform(data: bytes, at: int, element: Element, order: str) -> tuple[NDArray[np.void] | None, int]:
    """All rows at once if the lists of every row are as long as those of the first; else None, and `at`."""
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    place = at
    for name, kind, count in element.properties:
        if count:
            if not element.count:
                length = 0
            else:
                length = int(_number(data, place, order + count))
            place += np.dtype(count).itemsize + max(length, 0) * np.dtype(kind).itemsize
            if length < 0 or place > len(data):
                return None, at
            fields += [(f"count of {name}", order + count), (name, order + kind, (length,))]
        else:
            place += np.dtype(kind).itemsize
            fields.append((name, order + kind))
    dtype = np.dtype(fields)
    stop = at + dtype.itemsize * element.count
    if stop > len(data):
        return None, at
    if not dtype.itemsize:
        return np.zeros(0, dtype), at
    rows = np.frombuffer(data, dtype, element.count, at)
    for name, _, count in element.properties:
        if count and (rows[f"count of {name}"] != rows[name].shape[1]).any():
            return None, at
    return rows, stop


def _walk(data: bytes, at: int, element: Element, order: str) -> tuple[list[NDArray], int]:
    """Row by row, for lists of different lengths: the vertex numbers of each row, and where the rows end."""
    found = []
    for row in range(element.count):
        for name, kind, count in element.properties:
            length, width = 1, np.dtype(kind).itemsize
            if count:
                length = int(_number(data, at, order + count))
                at += np.dtype(count).itemsize
            if length < 0 or at + length * width > len(data):
                raise FormatError(
                    f"{element.name} {row} (counting from 0): a list of {length} reaches beyond the end "
                    "of the file. "
                    "It is damaged or was cut short: export it again."
                )
            if name in INDEX_NAMES:
                found.append(np.frombuffer(data, order + kind, length, at))
            at += length * width
    return found, at


def _number(data: bytes, at: int, kind: str) -> float:
    if at + np.dtype(kind).itemsize > len(data):
        raise FormatError("the data end within a list. The file was cut short: export it again.")
    return np.frombuffer(data, kind, 1, at)[0].item()
