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
    order = np.argsort(faces.ravel(), kind="stable")
    start = np.searchsorted(faces.ravel()[order], [vertices, vertices + 1])
    number = start[1] - start[0]
    row = np.repeat(np.arange(len(queries)), number)
    face = order[np.arange(len(row)) - np.repeat(np.cumsum(number) - number - start[0], number)] // 3
    weights, apart = closest_weights(positions[faces[face]], queries[row])
    best = np.lexsort((apart, row))[np.cumsum(number) - number]
    return SurfacePoints(face[best], faces[face[best]], weights[best])


def closest_weights(triangles: np.ndarray, queries: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric coordinates (t, 3) of each triangle's point that is closest to a query, and the distance (t,).

    Parameters
    ----------
    triangles, queries
        (t, 3, 3) corners, which may lie on a line or in a point, and (t, 3) points in space, one for each triangle.
    """
    # The point below the query if it lies inside, else the closest on one of the edges; the nearest of the four.
    one, two, to = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0], queries - triangles[:, 0]
    length1, length2, product = _dot(one, one), _dot(two, two), _dot(one, two)
    along1, along2 = _dot(to, one), _dot(to, two)
    candidates = np.zeros((4, len(triangles), 3))
    with np.errstate(divide="ignore", invalid="ignore"):  # no area, or an edge of no length
        inside = np.stack([along1 * length2 - along2 * product, along2 * length1 - along1 * product], axis=1)
        candidates[3, :, 1:] = inside / (length1 * length2 - product**2)[:, None]
        candidates[3, :, 0] = 1 - candidates[3, :, 1] - candidates[3, :, 2]
        for k in range(3):
            edge = triangles[:, (k + 1) % 3] - triangles[:, k]
            step = _dot(queries - triangles[:, k], edge) / _dot(edge, edge)
            candidates[k, :, (k + 1) % 3] = np.clip(np.nan_to_num(step), 0.0, 1.0)
            candidates[k, :, k] = 1 - candidates[k, :, (k + 1) % 3]
        apart = np.linalg.norm(np.einsum("ctk,tkd->ctd", candidates, triangles) - queries, axis=2)
        apart[3, ~(candidates[3] >= 0).all(axis=1)] = np.inf
    best, every = np.argmin(np.nan_to_num(apart, nan=np.inf), axis=0), np.arange(len(triangles))
    return candidates[best, every], apart[best, every]


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("td,td->t", first, second)
