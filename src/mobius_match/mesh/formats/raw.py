"""The result of every reader, the division of polygons into triangles, and the check of counts in headers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...errors import FormatError
from ..mesh import Floats, Ints

DAMAGED = "The file is damaged or was cut short: export it again."
HOW_TO_MESH = (
    "A point cloud must be meshed first, for example by screened Poisson reconstruction in MeshLab, CloudCompare or "
    "Open3D."
)


@dataclass
class RawMesh:
    """Vertices in the order of the file and triangles, each with the number of its face in the file."""

    vertices: Floats
    faces: Ints
    face_ids: Ints
    n_faces: int
    notes: list[str] = field(default_factory=list)
    names: dict[str, Ints] = field(default_factory=dict)  # numbers of the faces of each group, object, material or part


def named(runs: list[tuple[str, int, int]]) -> dict[str, Ints]:
    """The faces of each name, from runs of faces: their name, the first, and the one after the last."""
    found: dict[str, list[Ints]] = {}
    for name, start, end in runs:
        if name and end > start:
            found.setdefault(name, []).append(np.arange(start, end))
    return {name: np.unique(np.concatenate(faces)) for name, faces in found.items()}


def from_triangles(
    vertices: ArrayLike,
    faces: ArrayLike,
    sizes: Ints | None = None,
    notes: list[str] | None = None,
    *,
    remedy: str = DAMAGED,
) -> RawMesh:
    """Triangles that are the fans of polygons with `sizes` corners (F,), or the file's own faces if None."""
    faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    sizes, notes = np.full(len(faces), 3) if sizes is None else sizes, notes or []
    lines, polygons = int(np.count_nonzero(sizes < 3)), sizes[sizes > 3]
    if lines:
        notes.append(f"{lines} face(s) with fewer than 3 corners left out.")
    if len(polygons):
        cut = int((polygons - 2).sum())
        notes.append(f"{len(polygons)} polygon(s) with more than 3 corners cut into {cut} triangles.")
    face_ids = np.repeat(np.arange(len(sizes)), np.maximum(sizes - 2, 0))
    raw = RawMesh(np.asarray(vertices, dtype=np.float64), faces, face_ids, len(sizes), notes)
    bad = np.flatnonzero(((faces < 0) | (faces >= len(raw.vertices))).any(axis=1))
    if len(bad):
        wrong = faces[bad[0]][(faces[bad[0]] < 0) | (faces[bad[0]] >= len(raw.vertices))][0]
        raise FormatError(
            f"face {face_ids[bad[0]]} (counting from 0) names vertex {wrong}, but there are "
            f"{len(raw.vertices)} vertices, numbered 0 to {len(raw.vertices) - 1}; "
            f"{len(np.unique(face_ids[bad]))} of {len(sizes)} faces are wrong in this way. {remedy}"
        )
    return raw


def from_polygons(
    vertices: ArrayLike, sizes: Ints, corners: Ints, notes: list[str] | None = None, *, remedy: str = DAMAGED
) -> RawMesh:
    """Polygons with `sizes` corners (F,), whose vertex numbers are concatenated in `corners`, cut into fans.

    A fan depends on the numbering only, so two poses of one mesh get the same triangles.
    """
    pieces = np.maximum(sizes - 2, 0)
    first = np.repeat(np.cumsum(sizes) - sizes, pieces)
    step = np.arange(len(first)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    faces = corners[np.stack([first, first + step + 1, first + step + 2], axis=1)]
    return from_triangles(vertices, faces, sizes, notes, remedy=remedy)


def promised(count: int, what: str, found: int, unit: str) -> None:
    """Refuse a header that promises more than the file can contain, before memory is allocated."""
    if count > found:
        raise FormatError(f"the header promises {count} {what}, but only {found} {unit} follow. {DAMAGED}")
