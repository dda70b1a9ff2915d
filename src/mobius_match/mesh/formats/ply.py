"""PLY, text and binary, read by trimesh with a header that contains only coordinates and corners.

trimesh splits vertices by texture coordinates, expects the format on the second line, and reads binary faces of
different lengths as if they were equal: such faces are read here, one by one.
"""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np

from ...errors import FormatError
from ..mesh import Ints
from .raw import HOW_TO_MESH, RawMesh, from_polygons, promised

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
CORNERS = "vertex_indices"
Properties = list[tuple[str, str, str]]  # name, type, type of the count ("" where it is no list)


def read_ply(data: bytes) -> RawMesh:
    """Read the vertex and face elements."""
    head = re.match(rb"ply[ \t]*\r?\n.*?\bend_header[ \t]*\r?\n", data, re.DOTALL)
    if head is None:
        raise FormatError("not a PLY file, or cut short: no end_header line. Export it again.")
    kind, elements = _header(head[0].decode("latin-1").splitlines())
    body = data[head.end() :]
    for name, wanted in (("vertex", {"x", "y", "z"}), ("face", {CORNERS})):
        if not wanted <= {known for known, _, _ in elements.get(name, (0, []))[1]}:
            cloud = f" {HOW_TO_MESH}" if name == "face" and name not in elements else ""
            raise FormatError(f"the header lacks a {name} element with {' '.join(sorted(wanted))}.{cloud}")
    column = [known for known, _, _ in elements["face"][1]].index(CORNERS)
    if any(count for _, _, count in elements["face"][1][:column]):
        raise FormatError("the corners of faces follow another list; export plain vertices and faces.")
    if kind == "ascii":
        return _text([row for row in body.splitlines() if row.strip()], elements, column)
    least = sum(
        length * sum(np.dtype(count or TYPES[kind]).itemsize for _, kind, count in properties)
        for length, properties in elements.values()
    )
    promised(least, "bytes at least", len(body), "bytes")
    try:
        found = _load(kind, elements, body)
        faces = found["face"]["data"][CORNERS]
        if (faces["f0"] == faces["f1"].shape[1]).all():
            return _polygons(found, faces["f1"])
    except (ValueError, KeyError, TypeError, IndexError):  # lists of different lengths, or bytes at the end
        if list(elements)[:2] != ["vertex", "face"] or any(count for _, _, count in elements["vertex"][1]):
            raise
    rest = dict(list(elements.items())[:1])
    width = sum(np.dtype(TYPES[kind]).itemsize for _, kind, _ in elements["vertex"][1])
    start = width * elements["vertex"][0]
    return _polygons(_load(kind, rest, body[:start]), _walk(body, start, kind, *elements["face"]))


def _header(lines: list[str]) -> tuple[str, dict[str, tuple[int, Properties]]]:
    kind, elements, name = "", dict[str, tuple[int, Properties]](), ""
    for number, line in enumerate(lines[1:-1], 2):
        match line.split():
            case ["format", "ascii" | "binary_little_endian" | "binary_big_endian" as kind, _]:
                pass
            case ["element", name, count] if count.isdigit() and len(count) < 16 and name not in elements:
                elements[name] = (int(count), list[tuple[str, str, str]]())
            case ["property", *counts, value, known] if name and {value, *counts[1:]} <= set(TYPES):
                known = CORNERS if known == "vertex_index" else known
                elements[name][1].append((known, value, TYPES[counts[1]] if len(counts) == 2 else ""))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise FormatError(f"line {number}: {line[:60]!r} is not understood in the header.")
    if not kind:
        raise FormatError("the header has no format line (ascii, binary_little_endian or binary_big_endian).")
    return kind, elements


def _load(kind: str, elements: dict[str, tuple[int, Properties]], body: bytes) -> Any:
    """What trimesh makes of the elements, those that are not needed under names without meaning."""
    from trimesh.exchange.ply import load_ply

    lines = ["ply", f"format {kind} 1.0"]
    names = {value: key for key, value in TYPES.items()}
    for k, (element, (length, properties)) in enumerate(elements.items()):
        lines.append(f"element {element if element in ('vertex', 'face') else f'other{k}'} {length}")
        for j, (name, value, count) in enumerate(properties):
            keep = name in (("x", "y", "z") if element == "vertex" else (CORNERS,))
            lines.append(f"property {f'list {names[count]} ' if count else ''}{value} {name if keep else f'other{j}'}")
    header = "\n".join([*lines, "end_header\n"]).encode()
    loaded = load_ply(io.BytesIO(header + body), fix_texture=False, skip_materials=True)
    return {**loaded["metadata"]["_ply_raw"], "vertices": loaded.get("vertices", np.zeros((0, 3)))}


def _text(rows: list[bytes], elements: dict[str, tuple[int, Properties]], column: int) -> RawMesh:
    promised(sum(count for count, _ in elements.values()), "rows", len(rows), "rows")
    first, parts = 0, {}
    for name, (count, _) in elements.items():
        parts[name] = rows[first : first + count]
        first += count
    faces = [row.split()[column:] for row in parts["face"]]
    for number, face in enumerate(faces):
        _complete(number, int(face[0]), min(int(face[0]), len(face) - 1))
    # Rows end with the corners, as trimesh confuses what stands behind them where there is one row alone.
    body = b"\n".join([*parts["vertex"], *(b" ".join(face[: int(face[0]) + 1]) for face in faces)])
    corners = elements["face"][1][column]
    found = _load("ascii", {"vertex": elements["vertex"], "face": (len(faces), [corners])}, body)
    return _polygons(found, found["face"]["data"][CORNERS] if faces else [])


def _polygons(found: Any, faces: Any) -> RawMesh:
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        sizes, corners = np.full(len(faces), faces.shape[1]), faces.ravel()
    else:
        sizes = np.array([len(face) for face in faces], dtype=np.int64)
        corners = np.concatenate([np.zeros(0, dtype=np.int64), *faces])
    return from_polygons(found["vertices"], sizes, corners.astype(np.int64))


def _complete(face: int, wanted: int, found: int) -> None:
    if wanted != found:
        raise FormatError(
            f"face {face} (counting from 0) should have {wanted} corners, but {found} follow before the end "
            "of its row or of the file. It is damaged or was cut short: export it again."
        )


def _walk(body: bytes, at: int, kind: str, length: int, properties: Properties) -> list[Ints]:
    """The corners of binary faces, row by row."""
    order = "<" if "little" in kind else ">"
    faces = []
    for face in range(length):
        for name, value, count in properties:
            dtype, size = np.dtype(order + TYPES[value]), 1
            if count:
                size = int.from_bytes(body[at : at + int(count[1])], "little" if order == "<" else "big", signed=False)
                at += int(count[1])
            left = max(len(body) - at, 0) // dtype.itemsize
            _complete(face, size, min(size, left))
            if name == CORNERS:
                faces.append(np.frombuffer(body, dtype, size, at))
            at += size * dtype.itemsize
    return faces
