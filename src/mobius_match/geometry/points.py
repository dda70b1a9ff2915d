"""Points on a surface: a face and barycentric coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points of a mesh.

    Parameters
    ----------
    faces
        (q,) int64 face numbers.
    corners
        (q, 3) int64, the vertices of these faces.
    barycentric
        (q, 3) float64, not negative, rows sum to 1: the weights of the corners.
    """

    faces: np.ndarray
    corners: np.ndarray
    barycentric: np.ndarray

    def __getitem__(self, rows: np.ndarray) -> SurfacePoints:
        return SurfacePoints(self.faces[rows], self.corners[rows], self.barycentric[rows])

    @property
    def nearest(self) -> np.ndarray:
        """The corner that weighs most, (q,) int64."""
        return self.corners[np.arange(len(self.corners)), self.barycentric.argmax(axis=1)]

    def values(self, at_vertices: np.ndarray) -> np.ndarray:
        """Values (q, ...) at the points, of values (n, ...) at the vertices."""
        return np.einsum("qk,qk...->q...", self.barycentric, at_vertices[self.corners])

    def replaced(self, rows: np.ndarray, others: SurfacePoints) -> SurfacePoints:
        """The points, with others in some rows (r,)."""
        parts = []
        for name in ("faces", "corners", "barycentric"):
            values = getattr(self, name).copy()
            values[rows] = getattr(others, name)
            parts.append(values)
        return SurfacePoints(*parts)


def closest_points(
    positions: np.ndarray, faces: np.ndarray, queries: np.ndarray, vertices: np.ndarray
) -> SurfacePoints:
    """The points closest to others in space, on the faces around given vertices.

    Parameters
    ----------
    positions, faces
        (n, 3) float and (m, 3) int: the mesh.
    queries
        (q, 3) points in space.
    vertices
        (q,) for each of them a vertex, on whose faces the closest point is looked for.
    """
    from trimesh.triangles import closest_point, points_to_barycentric

    order = np.argsort(faces.ravel(), kind="stable")
    start = np.searchsorted(faces.ravel()[order], [vertices, vertices + 1])
    number = start[1] - start[0]
    row = np.repeat(np.arange(len(queries)), number)
    face = order[np.arange(len(row)) - np.repeat(np.cumsum(number) - number - start[0], number)] // 3
    triangles = positions[faces[face]]
    found = closest_point(triangles, queries[row])
    apart = np.linalg.norm(found - queries[row], axis=1)
    best = np.lexsort((apart, row))[np.cumsum(number) - number]
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.clip(points_to_barycentric(triangles[best], found[best]), 0.0, 1.0)
        weights /= weights.sum(axis=1, keepdims=True)
    # A face without area has no barycentric coordinates: its vertex stands for it.
    vertex = (faces[face[best]] == vertices[:, None]).astype(np.float64)
    weights = np.where(np.isfinite(weights).all(axis=1, keepdims=True), weights, vertex)
    return SurfacePoints(face[best], faces[face[best]], weights)
