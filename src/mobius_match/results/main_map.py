"""The part of a dense map that is between the two main pieces."""

from __future__ import annotations

import numpy as np

from ..geometry.points import SurfacePoints
from ..mesh import Mesh
from ..mesh.pieces import part_of_mesh
from ..mesh.topology import components
from .surface_map import SurfaceMap


def main_map(surface_map: SurfaceMap) -> tuple[SurfaceMap, np.ndarray, np.ndarray]:
    """The map between the largest matched piece of the source and the piece that it is matched with.

    Returns
    -------
    SurfaceMap
        The map of these two; the same object where both meshes have one piece.
    vertices, faces
        (n,) and (m,) bool: which of the source's vertices and faces are in it.
    """
    source, target = surface_map.source, surface_map.target
    (n_here, here), (n_there, there) = components(source.faces), components(target.faces)
    if max(n_here, n_there) < 2:
        return surface_map, np.ones(len(source.vertices), bool), np.ones(len(source.faces), bool)
    carried = surface_map.source_carried
    riding = np.zeros(len(source.vertices), bool) if carried is None else ~np.isnan(carried).any(axis=1)
    matched = (surface_map.source_mapped & ~riding)[source.faces].all(axis=1)
    faces1 = here == np.bincount(here, matched, n_here).argmax()
    images = surface_map.target_points.faces[source.faces[faces1 & matched, 0]]
    faces2 = there == np.bincount(there[images], minlength=n_there).argmax()
    vertices1, vertices2 = (_used(mesh, faces) for mesh, faces in ((source, faces1), (target, faces2)))
    points, mapped = _restricted(surface_map, vertices1, vertices2, faces2)
    back, back_mapped = _restricted(surface_map.inverse, vertices2, vertices1, faces1)
    meshes = part_of_mesh(source, vertices1, faces1), part_of_mesh(target, vertices2, faces2)
    main = SurfaceMap(*meshes, points, back, mapped, back_mapped, reflected=surface_map.reflected)
    return main, vertices1, faces1


def _used(mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    """Which vertices (n,) bool some of the faces use."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces[faces]] = True
    return used


def _restricted(
    surface_map: SurfaceMap, here: np.ndarray, there: np.ndarray, faces: np.ndarray
) -> tuple[SurfacePoints, np.ndarray]:
    """The images of some of the source's vertices on a piece of the target, and which of them lie there."""
    points = surface_map.target_points[np.flatnonzero(here)]
    mapped = surface_map.source_mapped[here] & faces[points.faces]
    vertex, face = np.cumsum(there) - 1, np.cumsum(faces) - 1
    first = np.flatnonzero(faces)[0]
    on_piece = np.where(faces[points.faces], points.faces, first)
    corners = vertex[surface_map.target.faces[on_piece]]
    return SurfacePoints(face[on_piece], corners, points.barycentric), mapped
