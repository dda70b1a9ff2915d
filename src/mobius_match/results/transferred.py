"""Points, values and labels transferred along a dense map: the work of the methods of :class:`.SurfaceMap`."""

from __future__ import annotations

import numpy as np

from ..errors import SettingsError
from ..geometry.points import SurfacePoints, closest_points
from ..mesh import Mesh


def transferred_values(
    source: Mesh, target: Mesh, source_points: SurfacePoints, mapped: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """See :meth:`.SurfaceMap.transfer`."""
    values = _rows(values, source.n_file_vertices, "vertices", source).astype(np.float64)
    at_vertices = source_points.values(values[source.vertex_ids])
    at_vertices[~mapped] = np.nan
    transferred = np.full((target.n_file_vertices, *values.shape[1:]), np.nan)
    # Backwards, so that of several vertices with one number in the file the first decides.
    transferred[target.vertex_ids[::-1]] = at_vertices[::-1]
    return transferred


def transferred_labels(
    source: Mesh, target: Mesh, images: SurfacePoints, mapped: np.ndarray, labels: np.ndarray
) -> np.ndarray:
    """See :meth:`.SurfaceMap.transfer_labels`: by the images on the source of the centres of the target's faces."""
    labels = _rows(labels, source.n_file_faces, "faces", source)
    if not np.issubdtype(labels.dtype, np.integer):
        raise SettingsError(f"{source.name}: labels are to be whole numbers, and are {labels.dtype}")
    carried = np.full(target.n_file_faces, -1, np.int64)
    # Backwards, so that of the triangles of one polygon the first decides.
    order = np.flatnonzero(mapped)[::-1]
    carried[target.face_ids[order]] = labels[source.face_ids[images.faces[order]]]
    return carried


def mapped_points(
    mapped: np.ndarray, target: Mesh, images: SurfacePoints, points: SurfacePoints
) -> tuple[SurfacePoints, np.ndarray]:
    """See :meth:`.SurfaceMap.map_points`: by the images (n1,) of the source's vertices."""
    size = float(np.ptp(target.vertices, axis=0).max())
    places = np.einsum("qc,qcd->qd", points.barycentric, images.values(target.vertices)[points.corners])
    near = images.nearest[points.nearest]
    found = closest_points(target.vertices / size, target.faces, places / size, near)
    # A vertex goes exactly where its image is, whatever a search among the faces around would round to.
    exact = np.flatnonzero(points.barycentric.max(axis=1) == 1.0)
    found = found.replaced(exact, images[points.nearest[exact]])
    return found, (mapped[points.corners] | (points.barycentric == 0)).all(axis=1)


def _rows(values: np.ndarray, number: int, what: str, mesh: Mesh) -> np.ndarray:
    values = np.asarray(values)
    if values.ndim == 0 or len(values) != number:
        length = 0 if values.ndim == 0 else len(values)
        raise SettingsError(f"{mesh.name} has {number} {what}, and {length} values were given: one is needed for each")
    return values
