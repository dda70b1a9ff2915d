"""Transfer of attributes along a dense map: values, colours, labels, texture coordinates, landmarks.

A :class:`~mobius_match.SurfaceMap` transfers between its two repaired meshes and knows no files. A :class:`Transfer`
builds on it for what needs the files too: vertices that repair has joined, texture seams, landmarks off the surface.
"""

from __future__ import annotations

import numpy as np

from .._core.display import shortened
from ..errors import SettingsError
from ..geometry.points import SurfacePoints, closest_points
from ..landmarks.tables import Landmarks
from ..mesh.measure import box_scale
from ..mesh.user_mesh import repaired_numbers, user_mesh
from ..results.surface_map import SurfaceMap
from .colours import GREY
from .texture import repaired_uv, transferred_uv

ON_VERTEX = 1e-6
"""Smaller barycentric coordinates are set to 0, so that the point lies on the edge or the vertex."""


class Transfer:
    """Transfers attributes from the source's file to the target's; ``Transfer(surface_map.inverse)`` does the reverse.

    Parameters
    ----------
    surface_map
        The map.

    Attributes
    ----------
    source, target : Mesh
        The meshes as in the user's files, with n1 and n2 vertices and m1 and m2 faces.
    missing : (n2,) bool
        Which vertices of the target have no counterpart.

    Raises
    ------
    MeshError
        If a file is needed and is missing or has changed since the match.

    See Also
    --------
    mobius_match.SurfaceMap.transfer : Transfers values between the repaired meshes, without the files.
    """

    def __init__(self, surface_map: SurfaceMap) -> None:
        self.map = surface_map
        self.source, self.target = user_mesh(surface_map.source), user_mesh(surface_map.target)
        self._repaired_source = repaired_numbers(surface_map.source, self.source)
        self._repaired_target = repaired_numbers(surface_map.target, self.target)
        self.missing = (self._repaired_target < 0) | ~surface_map.target_mapped[self._repaired_target]

    def __repr__(self) -> str:
        return f"<Transfer {shortened(self.source.name)} -> {shortened(self.target.name)}>"

    def values(self, values: np.ndarray) -> np.ndarray:
        """Transfer values at vertices.

        Parameters
        ----------
        values
            (n1, ...) one row for each vertex of the source. A single column of integers is treated as labels, and each
            target vertex gets the label of the nearest source vertex. All other values are interpolated linearly
            within faces.

        Returns
        -------
        numpy.ndarray
            (n2, ...) one row for each vertex of the target; NaN, or -1 for labels, without a counterpart.

        Raises
        ------
        SettingsError
            If there is not one row of numbers for each vertex of the source.
        """
        values = np.asarray(values)
        are_labels = values.ndim == 1 and values.dtype.kind in "iub"
        if values.ndim == 0 or len(values) != len(self.source.vertices) or values.dtype.kind not in "iubf":
            raise SettingsError(
                f"{self.source.name} has {len(self.source.vertices)} vertices: one row of numbers is needed for each, "
                f"not {values.dtype} of shape {values.shape}"
            )
        if are_labels:
            nearest = self.map.source.vertex_ids[self.map.source_points.nearest]
            transferred = values.astype(np.int64)[nearest[self._repaired_target]]
        else:
            # Vertices that repair has joined get what the vertex gets that they are joined with.
            transferred = self.map.transfer(values)[self.map.target.vertex_ids[self._repaired_target]]
        transferred[self.missing] = -1 if are_labels else np.nan
        return transferred

    def colors(self, colors: np.ndarray) -> np.ndarray:
        """Transfer colours of vertices.

        Parameters
        ----------
        colors
            (n1, 3) RGB or (n1, 4) RGBA, 0 to 255.

        Returns
        -------
        numpy.ndarray
            (n2, 3) or (n2, 4) uint8; grey without a counterpart.

        Raises
        ------
        SettingsError
            If these are no colours, or not one for each vertex of the source.
        """
        colors = np.asarray(colors)
        if (
            colors.ndim != 2
            or colors.shape[1] not in (3, 4)
            or (colors.size and (colors.min() < 0 or colors.max() > 255))
        ):
            raise SettingsError(
                f"`colors` must be rows of 3 or 4 numbers from 0 to 255, not an array of shape {colors.shape}"
            )
        transferred = self.values(colors)
        transferred[self.missing] = GREY[: transferred.shape[1]]
        return np.round(transferred).astype(np.uint8)

    def labels(self, labels: np.ndarray) -> np.ndarray:
        """Transfer labels of faces.

        Parameters
        ----------
        labels
            (m1,) int, one for each face of the source's file.

        Returns
        -------
        numpy.ndarray
            (m2,) int64, one for each face of the target's file; -1 without a counterpart. See
            :meth:`mobius_match.SurfaceMap.transfer_labels`.
        """
        return self.map.transfer_labels(labels)

    def uv(self, uv: np.ndarray) -> np.ndarray:
        """Transfer texture coordinates.

        A face of the target takes the texture coordinates of the source face that contains the image of its centre,
        extrapolated linearly to its corners. Where the image of a corner itself has nearly the same coordinates,
        these are used. So no face spans a seam.

        Parameters
        ----------
        uv
            (m1, 3, 2) coordinates at the corners of ``source.faces``.

        Returns
        -------
        numpy.ndarray
            (m2, 3, 2) at the corners of ``target.faces``; NaN without a counterpart.

        Raises
        ------
        SettingsError
            If ``uv`` has another shape.
        """
        uv = np.asarray(uv, np.float64)
        if uv.shape != (len(self.source.faces), 3, 2):
            raise SettingsError(
                f"{self.source.name}: `uv` has shape {uv.shape}, and its {len(self.source.faces)} triangles need "
                f"({len(self.source.faces)}, 3, 2)"
            )
        return transferred_uv(self.map, self._repaired_uv(uv), self._repaired_target[self.target.faces])

    def uv_of_repaired(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Transfer texture coordinates, and give both at the corners of the repaired meshes' faces.

        Parameters
        ----------
        uv
            (m1, 3, 2) coordinates at the corners of ``source.faces``.

        Returns
        -------
        source_uv, target_uv : numpy.ndarray
            (f1, 3, 2) and (f2, 3, 2), for the f1 and f2 faces of the repaired source and target; NaN without a
            counterpart.
        """
        source_uv = self._repaired_uv(np.asarray(uv, np.float64))
        return source_uv, transferred_uv(self.map, source_uv, self.map.target.faces)

    def _repaired_uv(self, uv: np.ndarray) -> np.ndarray:
        return repaired_uv(self.source, self.map.source, uv)

    def positions(self) -> np.ndarray:
        """The positions of the source's vertices on the target.

        With the source's faces they are the shape of the target in the source's triangulation; with those of
        ``source.reflected()`` if the map is reflected, so that they point outward.

        Returns
        -------
        numpy.ndarray
            (n1, 3) float64, in the target's units; NaN without a counterpart.
        """
        positions = self.map.positions[self._repaired_source]
        positions[self._repaired_source < 0] = np.nan
        return positions

    def points(self, points: SurfacePoints) -> tuple[np.ndarray, np.ndarray]:
        """Map points of the source, of :meth:`at_vertices` or :meth:`project`, to the target.

        Parameters
        ----------
        points
            (q,) points of the repaired source.

        Returns
        -------
        positions
            (q, 3) float64; NaN without a counterpart.
        vertices
            (q,) int64 nearest vertices of the target's file; -1 without a counterpart.
        """
        images, mapped = self.map.map_points(points)
        positions = images.values(self.map.target.vertices)
        vertices = self.map.target.vertex_ids[images.nearest]
        positions[~mapped], vertices[~mapped] = np.nan, -1
        return positions, vertices

    def landmarks(self, landmarks: Landmarks) -> tuple[Landmarks, np.ndarray]:
        """Transfer landmarks, each from the point of the source closest to it.

        Parameters
        ----------
        landmarks
            q landmarks: vertices of the source's file, or positions in its units.

        Returns
        -------
        transferred
            Positions on the target and its nearest vertices; NaN and -1 without a counterpart.
        distances
            (q,) float64 distance of each landmark from the source's surface, in the units of the mesh.

        Raises
        ------
        SettingsError
            If the source has no such vertex, or a coordinate is not finite.
        """
        if landmarks.points is None:
            points, distances = self.at_vertices(landmarks.vertices), np.zeros(len(landmarks))
        else:
            points, distances = self.project(landmarks.points)
        positions, vertices = self.points(points)
        return Landmarks(landmarks.names, vertices, positions), distances

    def at_vertices(self, vertices: np.ndarray) -> SurfacePoints:
        """Vertices of the source's file as points of the source.

        Parameters
        ----------
        vertices
            (q,) int vertex numbers.

        Returns
        -------
        SurfacePoints
            (q,) points of the repaired source; for a vertex in no face, the closest point of the surface.

        Raises
        ------
        SettingsError
            If the source has no such vertex.
        """
        vertices = np.asarray(vertices, np.int64)
        wrong = vertices[(vertices < 0) | (vertices >= len(self.source.vertices))]
        if len(wrong):
            raise SettingsError(
                f"{self.source.name} has no vertex {wrong[0]}; it has {len(self.source.vertices)}, numbered from 0"
            )
        return self.project(self.source.vertices[vertices])[0]

    def project(self, positions: np.ndarray) -> tuple[SurfacePoints, np.ndarray]:
        """Project positions in space onto the source.

        Parameters
        ----------
        positions
            (q, 3) in the units of the mesh.

        Returns
        -------
        points
            (q,) closest points of the repaired source.
        distances
            (q,) float64 distances from the surface, in the units of the mesh.

        Raises
        ------
        SettingsError
            If a coordinate is not finite.
        """
        import igl

        mesh = self.map.source
        scale = box_scale(mesh.vertices)
        queries, vertices = np.ascontiguousarray(positions, np.float64) / scale, mesh.vertices / scale
        if not np.isfinite(queries).all():
            raise SettingsError("`positions` has a coordinate that is not a finite number")
        faces = np.asarray(igl.point_mesh_squared_distance(queries, vertices, mesh.faces)[1]).reshape(-1)
        points = closest_points(vertices, mesh.faces, queries, mesh.faces[faces, 0])
        weights = np.where(points.barycentric < ON_VERTEX, 0.0, points.barycentric)
        points = SurfacePoints(points.faces, points.corners, weights / weights.sum(axis=1, keepdims=True))
        return points, np.linalg.norm(points.values(vertices) - queries, axis=1) * scale
