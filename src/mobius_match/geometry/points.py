"""Points on a surface: a face and barycentric coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core.compiling import jit
from .._core.display import one_line

MAX_VISITED = 200
"""Number of vertices that a search for the closest point visits at most."""

FLAT = 1e-14
"""Squared sine of the angle below which a triangle is treated as a line: round-off of float64."""


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

    def __repr__(self) -> str:
        return one_line(self)

    def __getitem__(self, rows: np.ndarray) -> SurfacePoints:
        return SurfacePoints(self.faces[rows], self.corners[rows], self.barycentric[rows])

    @property
    def nearest(self) -> np.ndarray:
        """The corner with the largest weight, (q,) int64."""
        return self.corners[np.arange(len(self.corners)), self.barycentric.argmax(axis=1)]

    @property
    def in_flipped_faces(self) -> SurfacePoints:
        """The same points where the second and the third corner of all faces are exchanged."""
        return SurfacePoints(self.faces, self.corners[:, [0, 2, 1]], self.barycentric[:, [0, 2, 1]])

    def values(self, at_vertices: np.ndarray) -> np.ndarray:
        """Interpolate values at the vertices.

        Parameters
        ----------
        at_vertices
            (n, ...) numbers, one row for each vertex of the mesh.

        Returns
        -------
        numpy.ndarray
            (q, ...) their weighted means at the points.
        """
        return np.einsum("qk,qk...->q...", self.barycentric, at_vertices[self.corners])

    def replaced(self, rows: np.ndarray, others: SurfacePoints) -> SurfacePoints:
        """The points, with others in some rows.

        Parameters
        ----------
        rows
            (r,) int64 rows to replace.
        others
            (r,) points.

        Returns
        -------
        SurfacePoints
            (q,) points.
        """
        parts = []
        for name in ("faces", "corners", "barycentric"):
            values = getattr(self, name).copy()
            values[rows] = getattr(others, name)
            parts.append(values)
        return SurfacePoints(*parts)


def points_at(faces: np.ndarray, vertices: np.ndarray) -> SurfacePoints:
    """Vertices (q,) of a mesh with faces (m, 3) as points; each must be a corner of a face."""
    corner = np.zeros(faces.max() + 1, np.int64)
    corner[faces.ravel()[::-1]] = np.arange(faces.size)[::-1]
    face, place = np.divmod(corner[vertices], 3)
    return SurfacePoints(face, faces[face], np.eye(3)[place])


def closest_points(
    positions: np.ndarray, faces: np.ndarray, queries: np.ndarray, vertices: np.ndarray
) -> SurfacePoints:
    """The closest points of a surface to points in space, by a search over the surface from given vertices.

    The search begins on the faces around the vertex and moves on to neighbouring faces as long as they are closer. So
    it never jumps to another sheet of the surface that is near in space.

    Parameters
    ----------
    positions, faces
        (n, 3) float and (m, 3) int: the mesh.
    queries
        (q, 3) points in space.
    vertices
        (q,) the vertex at which each search begins.
    """
    order = np.argsort(faces.ravel(), kind="stable").astype(np.int32) // 3
    start = np.concatenate([[0], np.cumsum(np.bincount(faces.ravel(), minlength=len(positions)))])
    nearest, weights = np.empty(len(queries), np.int64), np.empty((len(queries), 3))
    _descend(positions, faces, start, order, np.asarray(queries, np.float64), vertices, nearest, weights)
    return SurfacePoints(nearest, faces[nearest], weights)


@jit
def _descend(
    positions: np.ndarray,
    faces: np.ndarray,
    start: np.ndarray,
    around: np.ndarray,
    queries: np.ndarray,
    seeds: np.ndarray,
    result: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Write the face and the weights of the closest point for each query."""
    trial, visited = np.empty(3), np.empty(MAX_VISITED, np.int64)
    for i in range(len(queries)):
        vertex, n_visited, nearest = seeds[i], 0, np.inf
        result[i] = around[start[vertex]]
        while n_visited < MAX_VISITED:
            visited[n_visited] = vertex
            n_visited += 1
            for place in range(start[vertex], start[vertex + 1]):
                face = around[place]
                distance = _closest_on_triangle(queries[i], positions, faces[face], trial)
                if distance < nearest:
                    nearest = distance
                    result[i] = face
                    weights[i] = trial
            # Next is the corner of the best face with the largest weight whose faces have not been visited.
            best = -1
            for k in range(3):
                fresh = weights[i, k] > 0.0
                for j in range(n_visited):
                    fresh = fresh and visited[j] != faces[result[i], k]
                if fresh and (best < 0 or weights[i, k] > weights[i, best]):
                    best = k
            if best < 0:
                break
            vertex = faces[result[i], best]


@jit
def _closest_on_triangle(query: np.ndarray, positions: np.ndarray, face: np.ndarray, weights: np.ndarray) -> float:
    """Write the barycentric coordinates of the closest point to the query; return its squared distance."""
    one_one = one_two = two_two = one_to = two_to = 0.0
    for axis in range(3):
        origin = positions[face[0], axis]
        one, two, to = positions[face[1], axis] - origin, positions[face[2], axis] - origin, query[axis] - origin
        one_one += one * one
        one_two += one * two
        two_two += two * two
        one_to += one * to
        two_to += two * to
    determinant = one_one * two_two - one_two * one_two
    v, w = (one_to * two_two - two_to * one_two) / determinant, (two_to * one_one - one_to * one_two) / determinant
    if v >= 0.0 and w >= 0.0 and v + w <= 1.0 and determinant > FLAT * one_one * two_two:
        weights[0], weights[1], weights[2] = max(1.0 - v - w, 0.0), v, w
        return _squared(query, positions, face, weights)
    # Beside the triangle, or the triangle has no area: the closest point on its edges.
    nearest, first, step = np.inf, 0, 0.0
    for k in range(3):
        along, length = 0.0, 0.0
        for axis in range(3):
            edge = positions[face[(k + 1) % 3], axis] - positions[face[k], axis]
            along += (query[axis] - positions[face[k], axis]) * edge
            length += edge * edge
        part = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0
        weights[k], weights[(k + 1) % 3], weights[(k + 2) % 3] = 1.0 - part, part, 0.0
        distance = _squared(query, positions, face, weights)
        if distance < nearest:
            nearest, first, step = distance, k, part
    weights[first], weights[(first + 1) % 3], weights[(first + 2) % 3] = 1.0 - step, step, 0.0
    return nearest


@jit
def _squared(query: np.ndarray, positions: np.ndarray, face: np.ndarray, weights: np.ndarray) -> float:
    total = 0.0
    for axis in range(3):
        difference = -query[axis]
        for k in range(3):
            difference += weights[k] * positions[face[k], axis]
        total += difference * difference
    return total
