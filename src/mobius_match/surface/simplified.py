"""The user's own mesh beside another that is computed on: a simplified one, or an envelope."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from .._core.display import one_line
from ..errors import MeshError
from ..geometry.normals import vertex_normals
from ..geometry.points import SurfacePoints, closest_points
from ..mesh import Mesh, require_matchable
from ..mesh.measure import unit_box
from ..mesh.simplify import simplify


@dataclass(frozen=True, eq=False)
class Detail:
    """What a simplified mesh, or an envelope, has left out.

    Parameters
    ----------
    mesh
        The user's mesh, repaired.
    kept
        (k,) int32: of each vertex of the simplified mesh the number in ``mesh``; of an envelope's the closest one.
    faces, barycentric
        (n,) int32 and (n, 3) float32: for each vertex of ``mesh`` a face of the simplified one, and the place in it.
    """

    mesh: Mesh
    kept: np.ndarray
    faces: np.ndarray
    barycentric: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)

    def places(self, simple: Mesh) -> SurfacePoints:
        """Where the user's vertices (n,) lie on the simplified mesh: ``places(simple).values(x)`` carries x to them."""
        return SurfacePoints(self.faces, simple.faces[self.faces], self.barycentric)

    def lifted(self, simple: Mesh, points: SurfacePoints, heights: np.ndarray | None = None) -> SurfacePoints:
        """Points of the simplified mesh (q,) as points of the user's, next to them, or at a height (q,) above them."""
        positions = points.values(simple.vertices)
        if heights is not None:
            positions = positions + heights[:, None] * _unit_normals(simple, points)
        # The box keeps squares far from overflow, whatever the units of the file.
        both = unit_box(np.concatenate([self.mesh.vertices, positions]))
        n = len(self.mesh.vertices)
        near = self.kept[points.nearest] if heights is None else scipy.spatial.cKDTree(both[:n]).query(both[n:])[1]
        return closest_points(both[:n], self.mesh.faces, both[n:], near)

    def heights(self, simple: Mesh) -> np.ndarray:
        """How far the user's vertices (n,) lie outside of an envelope, in the units of the mesh; mostly negative."""
        places = self.places(simple)
        arms = self.mesh.vertices - places.values(simple.vertices)
        return np.asarray((arms * _unit_normals(simple, places)).sum(axis=1))


def _unit_normals(mesh: Mesh, points: SurfacePoints) -> np.ndarray:
    normals = points.values(vertex_normals(unit_box(mesh.vertices), mesh.faces))
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)


def simplified(mesh: Mesh, count: int, ratio: float) -> tuple[Mesh, Detail | None]:
    """A mesh of about ``count`` vertices that stands for a larger one, and how the two belong together.

    Parameters
    ----------
    mesh
        A repaired mesh that can be matched; a small one comes back as it is, without detail.
    count
        Number of vertices.
    ratio
        Meshes of no more than so many times the count stay as they are.

    Returns
    -------
    simple
        Its vertices are some of the given; ``vertex_ids`` has the user's numbers, ``face_ids`` is -1 throughout.
    detail
        The given mesh, and where each of its vertices lies on the simple one.
    """
    if len(mesh.vertices) <= ratio * count:
        return mesh, None
    unit = unit_box(mesh.vertices)
    kept, faces, home = simplify(unit, mesh.faces, count)
    simple = replace(
        mesh,
        vertices=mesh.vertices[kept],
        faces=faces,
        vertex_ids=mesh.vertex_ids[kept],
        face_ids=np.full(len(faces), -1),
        others=None,
    )
    try:
        require_matchable(simple)
    except MeshError:  # too few vertices could be spared; the whole mesh was fine
        return mesh, None
    places = closest_points(unit[kept], faces, unit, home)
    return simple, Detail(mesh, kept.astype(np.int32), places.faces.astype(np.int32), places.barycentric.astype("f4"))


def beside_envelope(simple: Mesh, mesh: Mesh) -> Detail:
    """How the user's mesh lies on an envelope, or on what simplification and cuts have made of it."""
    unit = unit_box(np.concatenate([mesh.vertices, simple.vertices]))
    theirs, ours = unit[: len(mesh.vertices)], unit[len(mesh.vertices) :]
    places = closest_points(ours, simple.faces, theirs, scipy.spatial.cKDTree(ours).query(theirs)[1])
    kept = scipy.spatial.cKDTree(theirs).query(ours)[1]
    return Detail(mesh, kept.astype(np.int32), places.faces.astype(np.int32), places.barycentric.astype("f4"))
