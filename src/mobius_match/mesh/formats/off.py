"""OFF, with the prefixes that add colours, normals or texture coordinates after x y z."""

from __future__ import annotations

import re

import numpy as np

from ...errors import FormatError
from .raw import RawMesh
from .text import content_lines, polygon_rows, promised, table, whole_numbers


def read_off(data: bytes) -> RawMesh:
    """Read the text form of OFF; the binary and the four-dimensional forms are refused."""
    lines = content_lines(data)
    header = re.match(r"\s*(ST)?C?N?(4?n?)OFF\b\s*(.*)", lines.text[0]) if len(lines) else None
    if header is None:
        raise FormatError("the first line of an OFF file must begin with OFF.")
    if header[2] or header[3].upper().startswith("BINARY"):
        raise FormatError("only text OFF files in three dimensions can be read: export it as plain OFF.")
    counts, row = (header[3], 0) if header[3] else (lines.text[1] if len(lines) > 1 else "", 1)
    number = lines.numbers[min(row, len(lines) - 1)]
    numbers = whole_numbers(counts, number, "the numbers of vertices, faces and edges")
    if len(numbers) < 2:
        raise FormatError(f"line {number}: expected the numbers of vertices, faces and edges.")
    n, m = numbers[:2]
    body = lines.take(row + 1, len(lines))
    promised(n + m, f"rows ({n} vertices and {m} faces)", len(body), "lines")
    vertices = table(body.take(0, n), range(3), np.float64, "vertex")
    sizes, corners = polygon_rows(body.take(n, n + m))
    extra = len(body) - n - m
    notes = [f"{extra} line(s) after the last face ignored."] if extra else []
    return RawMesh(vertices, sizes, corners, notes)
