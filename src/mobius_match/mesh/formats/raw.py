"""What every reader returns, and how its polygons become triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Floats, Ints


@dataclass
class RawMesh:
    """Vertices and polygons in the order of the file, nothing checked yet.

    `sizes` (F,) holds the number of corners of each polygon, `corners` (sum of sizes,) all vertex numbers
    in a row.
    """

    vertices: Floats
    sizes: Ints
    corners: Ints
    notes: list[str] = field(default_factory=list)


def equal_polygons(vertices: NDArray[Any], faces: NDArray[Any], notes: list[str] | None = None) -> RawMesh:
    """A `RawMesh` from a plain (m, k) array of faces."""
    sizes = np.full(len(faces), faces.shape[1], dtype=np.int64)
    corners = np.ascontiguousarray(faces, dtype=np.int64).ravel()
    return RawMesh(np.asarray(vertices, dtype=np.float64), sizes, corners, notes or [])


def check_corners(raw: RawMesh) -> None:
    """Refuse polygons with vertex numbers out of range, by the file's own face number."""
    n = len(raw.vertices)
    bad = np.flatnonzero((raw.corners < 0) | (raw.corners >= n))
    if len(bad):
        owner = np.repeat(np.arange(len(raw.sizes)), raw.sizes)[bad]
        raise FormatError(
            f"face {owner[0]} (counting from 0) names vertex {raw.corners[bad[0]]}, but there are {n} "
            "vertices, "
            f"numbered 0 to {n - 1}; {len(np.unique(owner))} of {len(raw.sizes)} faces are wrong in this "
            "way. "
            "The file is damaged or was cut short: export it again."
        )


def triangulate(raw: RawMesh) -> tuple[Ints, Ints, list[str]]:
    """Cut polygons into fans around their first corner: triangles, the polygon of each, and notes.

    A fan depends on the numbering alone, so that two poses of one mesh get the same triangles.
    """
    notes = []
    lines = int(np.count_nonzero(raw.sizes < 3))
    if lines:
        notes.append(f"{lines} face(s) with fewer than 3 corners left out.")
    polygons = int(np.count_nonzero(raw.sizes > 3))
    pieces = np.maximum(raw.sizes - 2, 0)
    face_ids = np.repeat(np.arange(len(raw.sizes)), pieces)
    start = np.cumsum(raw.sizes) - raw.sizes
    step = np.arange(len(face_ids)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = start[face_ids]
    faces = raw.corners[np.stack([first, first + step + 1, first + step + 2], axis=1)]
    if polygons:
        cut = int(pieces[raw.sizes > 3].sum())
        notes.append(f"{polygons} polygon(s) with more than 3 corners cut into {cut} triangles.")
    return faces, face_ids, notes
