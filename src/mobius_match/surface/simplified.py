"""The user's own mesh beside another that is computed on: a simplified one, or an envelope."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from .._core.display import one_line
from ..errors import MeshError
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

    def lifted(self, simple: Mesh, points: SurfacePoints) -> SurfacePoints:
        """Points of the simplified mesh (q,) as points of the user's, next to them."""
        # The box keeps squares far from overflow, whatever the units of the file.
        both = unit_box(np.concatenate([self.mesh.vertices, points.values(simple.vertices)]))
        n = len(self.mesh.vertices)
        return closest_points(both[:n], self.mesh.faces, both[n:], self.kept[points.nearest])


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
    places = closest_points(ours, simple.faces, theirs, cKDTree(ours).query(theirs)[1])
    kept = cKDTree(theirs).query(ours)[1]
    return Detail(mesh, kept.astype(np.int32), places.faces.astype(np.int32), places.barycentric.astype("f4"))
