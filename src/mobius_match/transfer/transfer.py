"""What belongs to one surface, carried to another along a dense map: values, colours, labels, textures, landmarks.

Everything counts as the user's own files do, with vertices and faces that repair has joined or cut.
"""

from __future__ import annotations

import numpy as np

from ..errors import SettingsError
from ..geometry.points import SurfacePoints, closest_points
from ..landmarks.tables import Landmarks
from ..mesh.measure import box_scale, twins
from ..mesh.user_mesh import repaired_numbers, user_mesh
from ..results.surface_map import SurfaceMap

GREY = np.array([204, 207, 212, 255], np.uint8)
"""Colour of what has no counterpart."""

ON_VERTEX = 1e-6
"""Barycentric coordinates below this are none: the point lies on the edge or the vertex."""

FARTHEST = 3.0
"""How far a corner may lie outside the face whose texture it takes, in sizes of that face."""


class Carrier:
    """Carries from the source's file to the target's along a map; ``Carrier(surface_map.inverse)`` carries back.

    Parameters
    ----------
    surface_map
        The map.

    Attributes
    ----------
    source, target : Mesh
        The meshes as the files have them.
    missing : (n2,) bool
        Which vertices of the target have no counterpart.

    Raises
    ------
    MeshError
        If a file is needed and is missing or has changed since the match.
    """

    def __init__(self, surface_map: SurfaceMap) -> None:
        self.map = surface_map
        self.source, self.target = user_mesh(surface_map.source), user_mesh(surface_map.target)
        self._here = repaired_numbers(surface_map.source, self.source)
        self._there = repaired_numbers(surface_map.target, self.target)
        self.missing = (self._there < 0) | ~surface_map.target_mapped[self._there]

    def values(self, values: np.ndarray) -> np.ndarray:
        """Carry values at vertices.

        Parameters
        ----------
        values
            (n1, ...) one row for each vertex of the source. One column of whole numbers is taken for labels, which are
            never mixed; all others are linear within faces.

        Returns
        -------
        numpy.ndarray
            (n2, ...) one row for each vertex of the target; NaN, or -1 for labels, where nothing corresponds.
        """
        values = np.asarray(values)
        whole = values.ndim == 1 and values.dtype.kind in "iub"
        if values.ndim == 0 or len(values) != len(self.source.vertices) or values.dtype.kind not in "iubf":
            raise SettingsError(
                f"{self.source.name} has {len(self.source.vertices)} vertices: one row of numbers is needed for each, "
                f"not {values.dtype} of shape {values.shape}"
            )
        back = self.map.source_points
        if whole:
            carried = values.astype(np.int64)[self.map.source.vertex_ids[back.nearest]]
        else:
            carried = back.values(values.astype(np.float64)[self.map.source.vertex_ids])
        carried = carried[self._there]
        carried[self.missing] = -1 if whole else np.nan
        return carried

    def colors(self, colors: np.ndarray) -> np.ndarray:
        """Carry colours (n1, 3 or 4), whole numbers from 0 to 255; (n2, ...) uint8, grey where nothing corresponds."""
        colors = np.asarray(colors)
        if (
            colors.ndim != 2
            or colors.shape[1] not in (3, 4)
            or (colors.size and (colors.min() < 0 or colors.max() > 255))
        ):
            raise SettingsError(
                f"colours are rows of 3 or 4 numbers from 0 to 255, not an array of shape {colors.shape}"
            )
        carried = self.values(colors)
        carried[self.missing] = GREY[: carried.shape[1]]
        return np.round(carried).astype(np.uint8)

    def labels(self, labels: np.ndarray) -> np.ndarray:
        """Labels (m1,) of faces as :meth:`mobius_match.SurfaceMap.transfer_labels` does; (m2,) int64, -1 for none."""
        return self.map.transfer_labels(labels)

    def uv(self, uv: np.ndarray) -> np.ndarray:
        """Carry texture coordinates.

        A face of the target takes those of the source's face that its centre lies in, continued to its corners; where
        a corner's own image says nearly the same, it decides. So no face spans a seam.

        Parameters
        ----------
        uv
            (m1, 3, 2) coordinates at the corners of ``source.faces``.

        Returns
        -------
        numpy.ndarray
            (m2, 3, 2) at the corners of ``target.faces``; NaN where nothing corresponds.
        """
        uv = np.asarray(uv, np.float64)
        if uv.shape != (len(self.source.faces), 3, 2):
            raise SettingsError(
                f"{self.source.name}: texture coordinates are of shape {uv.shape}; its {len(self.source.faces)} "
                "triangles need (triangles, 3, 2)"
            )
        return self._uv(self._charts(uv), self._there[self.target.faces])

    def drawn_uv(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Texture coordinates as :meth:`uv` takes them, at the corners of the repaired source's and target's faces."""
        charts = self._charts(np.asarray(uv, np.float64))
        return charts, self._uv(charts, self.map.target.faces)

    def _uv(self, charts: np.ndarray, corners: np.ndarray) -> np.ndarray:
        """Texture coordinates of faces (m, 3) of the repaired target, -1 where a corner has no place in it."""
        centres, found = self.map.inverse.map_points(
            SurfacePoints(np.full(len(corners), -1), corners, np.full((len(corners), 3), 1 / 3))
        )
        places = self.map.source_points.values(self.map.source.vertices)[corners]
        weights = _continued(self.map.source.vertices[centres.corners], places)
        carried = np.einsum("mck,mkd->mcd", weights, charts[centres.faces])
        size = np.linalg.norm(carried - np.roll(carried, 1, axis=1), axis=2).max(axis=1)
        own = np.einsum("nk,nkd->nd", self.map.source_points.barycentric, charts[self.map.source_points.faces])[corners]
        near = np.linalg.norm(own - carried, axis=2) <= size[:, None]
        carried = np.where(near[..., None], own, carried)
        carried[~found | (corners < 0).any(axis=1)] = np.nan
        return carried

    def positions(self) -> np.ndarray:
        """Where the source's vertices lie on the target, (n1, 3): its shape in the source's triangles; NaN for none."""
        places = self.map.positions[self._here]
        places[self._here < 0] = np.nan
        return places

    def points(self, points: SurfacePoints) -> tuple[np.ndarray, np.ndarray]:
        """Where points of the source (see :meth:`at_vertices`, :meth:`snapped`) lie on the target.

        Returns
        -------
        places, vertices
            (q, 3) float64, and (q,) int64 the nearest vertices of the target's file; NaN and -1 for none.
        """
        images, found = self.map.map_points(points)
        places = images.values(self.map.target.vertices)
        vertices = self.map.target.vertex_ids[images.nearest]
        places[~found], vertices[~found] = np.nan, -1
        return places, vertices

    def landmarks(self, given: Landmarks) -> tuple[Landmarks, np.ndarray]:
        """Carry landmarks, from the point of the source nearest to each.

        Returns
        -------
        carried
            Points of the target and its nearest vertices; NaN and -1 for those without counterpart.
        apart
            (q,) float64: how far off the source's surface each was, in the mesh's units.
        """
        if given.points is None:
            points, apart = self.at_vertices(given.vertices), np.zeros(len(given))
        else:
            points, apart = self.snapped(given.points)
        places, vertices = self.points(points)
        return Landmarks(given.names, vertices, places), apart

    def at_vertices(self, vertices: np.ndarray) -> SurfacePoints:
        """Vertices (q,) of the source as points; those that are in no face are replaced by the nearest point."""
        vertices = np.asarray(vertices, np.int64)
        wrong = vertices[(vertices < 0) | (vertices >= len(self.source.vertices))]
        if len(wrong):
            raise SettingsError(
                f"{self.source.name} has no vertex {wrong[0]}; it has {len(self.source.vertices)}, numbered from 0"
            )
        return self.snapped(self.source.vertices[vertices])[0]

    def snapped(self, places: np.ndarray) -> tuple[SurfacePoints, np.ndarray]:
        """The points of the source nearest to places (q, 3), and how far off (q,) they are, in the mesh's units."""
        import igl

        mesh = self.map.source
        scale = box_scale(mesh.vertices)
        places, vertices = np.ascontiguousarray(places, np.float64) / scale, mesh.vertices / scale
        if not np.isfinite(places).all():
            raise SettingsError("a place on the surface has a coordinate that is not a finite number")
        faces = np.asarray(igl.point_mesh_squared_distance(places, vertices, mesh.faces)[1]).reshape(-1)
        points = closest_points(vertices, mesh.faces, places, mesh.faces[faces, 0])
        weights = np.where(points.barycentric < ON_VERTEX, 0.0, points.barycentric)
        points = SurfacePoints(points.faces, points.corners, weights / weights.sum(axis=1, keepdims=True))
        return points, np.linalg.norm(points.values(vertices) - places, axis=1) * scale

    def _charts(self, uv: np.ndarray) -> np.ndarray:
        """Texture coordinates at the corners of the repaired source's faces; NaN where repair has turned an edge."""
        twin, mesh = twins(self.source.vertices), self.map.source
        size = len(twin)
        known = (self.source.face_ids[:, None] * size + twin[self.source.faces]).ravel()
        wanted = (mesh.face_ids[:, None] * size + twin[mesh.vertex_ids[mesh.faces]]).ravel()
        order = np.argsort(known, kind="stable")
        place = order[np.searchsorted(known[order], wanted).clip(max=len(order) - 1)]
        found = np.where((known[place] == wanted)[:, None], uv.reshape(-1, 2)[place], np.nan)
        return found.reshape(-1, 3, 2)


def _continued(triangles: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (m, c, 3) of places (m, c, 3) in the planes of triangles (m, 3, 3), some negative."""
    sides = triangles[:, 1:] - triangles[:, :1]
    to = places - triangles[:, :1]
    gram, along = np.einsum("mik,mjk->mij", sides, sides), np.einsum("mck,mik->mci", to, sides)
    (a, b), c = gram[:, 0].T, gram[:, 1, 1]
    determinant = np.maximum(a * c - b * b, 1e-12 * a * c + np.finfo(float).tiny)[:, None]
    first = (along[..., 0] * c[:, None] - along[..., 1] * b[:, None]) / determinant
    second = (along[..., 1] * a[:, None] - along[..., 0] * b[:, None]) / determinant
    first, second = np.clip(first, -FARTHEST, FARTHEST), np.clip(second, -FARTHEST, FARTHEST)
    return np.stack([1 - first - second, first, second], axis=2)
