"""OBJ, read here: only ``v`` and ``f`` lines are used, so texture seams and groups split no vertices; names are kept.

trimesh splits vertices at texture seams and drops unused ones; meshio refuses files with more texture points than
vertices, and reads negative vertex numbers wrongly.
"""

from __future__ import annotations

import re
from itertools import chain

import numpy as np

from ...errors import FormatError
from ..mesh import Floats, Ints
from .raw import RawMesh, from_polygons, named

Line = tuple[int, str]  # number of the line, from 1, and its text


def read_obj(data: bytes) -> RawMesh:
    """Read vertices in the order of the file and faces of any size; negative numbers count backwards."""
    text = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
    text = re.sub(r"#.*", "", re.sub(r"\\[ \t]*\n", " ", text))  # continued lines; comments
    lines = [(number, line.lstrip()) for number, line in enumerate(text.split("\n"), 1)]
    points = [line for line in lines if line[1].startswith(("v ", "v\t"))]
    faces = [line for line in lines if line[1].startswith(("f ", "f\t"))]
    try:
        rows = [line for _, line in points]
        vertices: Floats = np.loadtxt(rows, usecols=(1, 2, 3), ndmin=2) if rows else np.zeros((0, 3))
    except ValueError as error:
        raise _first_bad(points, r"v(\s+[-+.\deE]+){3}.*", "a vertex needs 3 numbers") from error
    # "7/3/2" names vertex 7, texture point 3, normal 2.
    words = [re.sub(r"/\S*", "", line).split()[1:] for _, line in faces]
    sizes = np.array([len(row) for row in words], dtype=np.int64)
    try:
        corners: Ints = np.array([int(word) for word in chain.from_iterable(words)], dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise _first_bad(faces, r"f(\s+-?\d{1,18}(/\S*)?)*\s*", "a face needs whole numbers") from error
    if (corners == 0).any():
        raise _first_bad(faces, r"f(\s+-?0*[1-9]\S*)*\s*", "a face names vertex 0, but OBJ counts from 1")
    before = np.searchsorted([number for number, _ in points], [number for number, _ in faces])
    corners = np.where(corners < 0, np.repeat(before, sizes) + corners, corners - 1)
    raw = from_polygons(vertices, sizes, corners)
    raw.names = _names(lines, [number for number, _ in faces])
    return raw


def _names(lines: list[Line], faces: list[int]) -> dict[str, Ints]:
    """The faces of each object, group and material, from the lines and the numbers of the lines of faces."""
    runs = []
    for kind in ("o", "g", "usemtl"):
        begun = [(number, line.split()[1:]) for number, line in lines if line.split(maxsplit=1)[:1] == [kind]]
        starts = [*np.searchsorted(faces, [number for number, _ in begun]).tolist(), len(faces)]
        for (_, words), start, end in zip(begun, starts, starts[1:], strict=False):
            # A face is in all of several groups; the name of an object or a material may have spaces.
            runs += [(name, start, end) for name in (words if kind == "g" else [" ".join(words)])]
    return named(runs)


def _first_bad(lines: list[Line], good: str, what: str) -> FormatError:
    number, line = next((line for line in lines if not re.fullmatch(good, line[1])), lines[0])
    return FormatError(f"line {number}: {what}, found {line.strip()[:40]!r}. The file is damaged: export it again.")
