"""XML VTK files: PolyData (.vtp) and UnstructuredGrid (.vtu), in text, base64 or raw appended form."""

from __future__ import annotations

import base64
import re
import zlib
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Ints
from .raw import RawMesh
from .text import promised
from .vtk import surface

TYPES = {"Float": "f", "Int": "i", "UInt": "u"}
BLOCK_GROWTH = 1100  # zlib cannot shrink further, so more is a damaged header


@dataclass
class Encoding:
    """How the binary arrays of one file are written."""

    order: str
    header: np.dtype
    compressed: bool
    appended: bytes  # "" where there is no such section
    base64: bool  # of the appended section


def read_vtkxml(data: bytes) -> RawMesh:
    """Read the polygons of all pieces, one after the other."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise FormatError("document types and entities have no place in a VTK file.")
    text, appended, in_base64 = data, b"", False
    if section := re.search(rb"<AppendedData[^>]*>\s*_", data):
        stop = data.rfind(b"</AppendedData>")
        if stop < section.end():
            raise FormatError(
                "the AppendedData section does not end. The file was cut short: export it again."
            )
        appended, in_base64 = data[section.end() : stop], b"base64" in section[0]
        text = data[: section.end()] + data[stop:]
    root = ElementTree.fromstring(text)
    kind = root.get("type", "")
    if root.tag != "VTKFile" or kind not in ("PolyData", "UnstructuredGrid"):
        raise FormatError(f"{root.tag[:40]} {kind[:40]} is not a surface; save it as PolyData.")
    if root.get("compressor") not in (None, "", "vtkZLibDataCompressor"):
        raise FormatError(f"compressor {root.get('compressor')} cannot be read; save without compression.")
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    header = np.dtype(order + ("u8" if root.get("header_type") == "UInt64" else "u4"))
    encoding = Encoding(order, header, bool(root.get("compressor")), appended, in_base64)
    points, sizes, corners, kinds = [np.zeros((0, 3))], [_none()], [_none()], [_none()]
    for piece in root.iter("Piece"):
        start = sum(map(len, points))
        points.append(_array(piece, "Points", None, encoding).astype(np.float64).reshape(-1, 3))
        promised(int(piece.get("NumberOfPoints", "0")), "points", len(points[-1]), "points")
        if kind == "PolyData" and len(_array(piece, "Strips", "connectivity", encoding)):
            raise FormatError("triangle strips are not read: apply a triangle filter and save again.")
        cells = "Polys" if kind == "PolyData" else "Cells"
        names = _array(piece, cells, "connectivity", encoding).astype(np.int64)
        offsets = _array(piece, cells, "offsets", encoding).astype(np.int64)
        number = int(piece.get("NumberOfPolys" if kind == "PolyData" else "NumberOfCells", "0"))
        promised(number, "faces", len(offsets), "faces")
        size = np.diff(offsets, prepend=0)
        if (size < 0).any() or (offsets[-1] if len(offsets) else 0) != len(names):
            raise FormatError("offsets do not fit connectivity. The file is damaged: export it again.")
        sizes.append(size)
        corners.append(names + start)
        if kind == "UnstructuredGrid":
            kinds.append(_array(piece, cells, "types", encoding).astype(np.int64))
    parts = np.concatenate(points), np.concatenate(sizes), np.concatenate(corners)
    return surface(*parts, np.concatenate(kinds) if kind == "UnstructuredGrid" else None)


def _none() -> Ints:
    return np.zeros(0, dtype=np.int64)


def _array(piece: ElementTree.Element, group: str, name: str | None, encoding: Encoding) -> NDArray:
    """The named array of a group, empty where there is none."""
    node = next((n for n in piece.findall(f"{group}/DataArray") if name in (None, n.get("Name"))), None)
    if node is None:
        return _none()
    word = re.fullmatch(r"(Float|U?Int)(8|16|32|64)", node.get("type", ""))
    if word is None:
        raise FormatError(f"an array of type {node.get('type', '')[:40]!r} cannot be read.")
    dtype = np.dtype(f"{encoding.order}{TYPES[word[1]]}{int(word[2]) // 8}")
    form = node.get("format", "ascii")
    text = (node.text or "").strip()
    if form == "ascii":
        return np.array(text.split(), dtype=bytes).astype(dtype) if text else _none()
    if form == "appended":
        blob = encoding.appended[int(node.get("offset", "0")) :]
        return np.frombuffer(_bytes(blob, encoding, encoding.base64), dtype)
    return np.frombuffer(_bytes(text.encode("ascii"), encoding, True), dtype) if text else _none()


def _bytes(blob: bytes, encoding: Encoding, in_base64: bool) -> bytes:
    """What `blob` begins with: a header with sizes, then the data or their compressed blocks."""
    width = encoding.header.itemsize

    def take(start: int, count: int) -> bytes:
        stop = start + (-(-count // 3) * 4 if in_base64 else count)
        promised(stop, "bytes of an array", len(blob), "bytes")
        return base64.b64decode(blob[start:stop])[:count] if in_base64 else blob[start:stop]

    first = int(np.frombuffer(take(0, width), encoding.header)[0])
    if not encoding.compressed:
        if in_base64 and blob[: -(-width // 3) * 4].endswith(b"="):  # header and data encoded one by one
            return take(-(-width // 3) * 4, first)
        return take(0, width + first)[width:]
    if not first:
        return b""
    head = take(0, (3 + first) * width)
    lengths = np.frombuffer(head, encoding.header)[3:].astype(np.int64)
    start = -(-len(head) // 3) * 4 if in_base64 else len(head)
    promised(int(lengths.max()), "bytes in a block", len(blob), "bytes")
    packed = take(start, int(lengths.sum()))
    out, at = [], 0
    for length in lengths.tolist():
        block = zlib.decompressobj()
        out.append(block.decompress(packed[at : at + length], BLOCK_GROWTH * length + 64))
        if not block.eof:
            raise FormatError("a compressed block does not end. The file is damaged: export it again.")
        at += length
    return b"".join(out)
