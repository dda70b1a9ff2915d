"""OBJ: only ``v`` and ``f`` lines are looked at, so texture seams and material groups split nothing."""

from __future__ import annotations

import re

import numpy as np

from ...errors import FormatError
from .raw import RawMesh
from .text import Lines, content_lines, polygon_corners, table


def read_obj(data: bytes) -> RawMesh:
    """Read vertices in the order of the file and faces of any size; negative numbers count backwards."""
    if b"\\" in data:
        data = re.sub(rb"\\[ \t]*\r?\n", b" ", data)  # a line that goes on in the next
    lines = content_lines(data)
    lines.text = [line.lstrip() for line in lines.text]
    points, rows = _starting(lines, "v"), _starting(lines, "f")
    vertices = table(points, range(1, 4), np.float64, "vertex")
    if len(rows):
        # "7/3/2" names vertex 7, texture point 3, normal 2.
        rows.text = re.sub(r"/[^\s]*", "", "\n".join(rows.text)).split("\n")
    sizes = np.array([len(line.split()) - 1 for line in rows.text], dtype=np.int64)
    corners = polygon_corners(rows, sizes, 1)
    owner = np.repeat(np.arange(len(sizes)), sizes)
    zero = np.flatnonzero(corners == 0)
    if len(zero):
        raise FormatError(
            f"line {rows.numbers[owner[zero[0]]]}: a face names vertex 0, but OBJ counts from 1. "
            "Correct the program that wrote the file."
        )
    if (corners < 0).any():
        before = np.searchsorted(points.numbers, rows.numbers)[owner]
        corners = np.where(corners < 0, before + corners, corners - 1)
    else:
        corners = corners - 1
    return RawMesh(vertices, sizes, corners)


def _starting(lines: Lines, key: str) -> Lines:
    starts = (key + " ", key + "\t")
    return lines.pick(np.flatnonzero([line.startswith(starts) for line in lines.text]))
