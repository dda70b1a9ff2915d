"""Points on a surface: a face and barycentric coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..compiling import jit

SEEN = 200
"""Vertices that a search for the closest point passes at most."""


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


def closest_points(
    positions: np.ndarray, faces: np.ndarray, queries: np.ndarray, vertices: np.ndarray
) -> SurfacePoints:
    """The points of a surface closest to others in space, looked for from given vertices on.

    The search begins on the faces around the vertex and moves on over the surface as long as that comes closer. So it
    never jumps to another sheet of the surface that happens to be near.

    Parameters
    ----------
    positions, faces
        (n, 3) float and (m, 3) int: the mesh.
    queries
        (q, 3) points in space.
    vertices
        (q,) for each of them a vertex, on whose faces the search begins.
    """
    order = np.argsort(faces.ravel(), kind="stable").astype(np.int32) // 3
    start = np.concatenate([[0], np.cumsum(np.bincount(faces.ravel(), minlength=len(positions)))])
    found, weights = np.empty(len(queries), np.int64), np.empty((len(queries), 3))
    _descend(positions, faces, start, order, np.asarray(queries, np.float64), vertices, found, weights)
    return SurfacePoints(found, faces[found], weights)


@jit
def _descend(
    positions: np.ndarray,
    faces: np.ndarray,
    start: np.ndarray,
    around: np.ndarray,
    queries: np.ndarray,
    seeds: np.ndarray,
    found: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Write the face and the weights of the closest point for each query."""
    trial, seen = np.empty(3), np.empty(SEEN, np.int64)
    for i in range(len(queries)):
        vertex, n_seen, nearest = seeds[i], 0, np.inf
        found[i] = around[start[vertex]]
        while n_seen < SEEN:
            seen[n_seen] = vertex
            n_seen += 1
            for place in range(start[vertex], start[vertex + 1]):
                face = around[place]
                apart = _closest_on_triangle(queries[i], positions, faces[face], trial)
                if apart < nearest:
                    nearest = apart
                    found[i] = face
                    weights[i] = trial
            # On to the corner of the best face next to the point, of those whose faces have not been seen.
            best = -1
            for k in range(3):
                fresh = weights[i, k] > 0.0
                for j in range(n_seen):
                    fresh = fresh and seen[j] != faces[found[i], k]
                if fresh and (best < 0 or weights[i, k] > weights[i, best]):
                    best = k
            if best < 0:
                break
            vertex = faces[found[i], best]


@jit
def _closest_on_triangle(query: np.ndarray, positions: np.ndarray, face: np.ndarray, weights: np.ndarray) -> float:
    """Write the barycentric coordinates of the point closest to the query (Ericson 2005); its squared distance."""
    ab_ab = ab_ac = ac_ac = ab_ap = ac_ap = 0.0
    for axis in range(3):
        a = positions[face[0], axis]
        ab, ac, ap = positions[face[1], axis] - a, positions[face[2], axis] - a, query[axis] - a
        ab_ab += ab * ab
        ab_ac += ab * ac
        ac_ac += ac * ac
        ab_ap += ab * ap
        ac_ap += ac * ap
    d3, d4 = ab_ap - ab_ab, ac_ap - ab_ac  # of the edges at a with the query seen from b
    d5, d6 = ab_ap - ab_ac, ac_ap - ac_ac  # and from c
    va, vb, vc = d3 * d6 - d5 * d4, d5 * ac_ap - ab_ap * d6, ab_ap * d4 - d3 * ac_ap
    if ab_ap <= 0.0 and ac_ap <= 0.0:
        v, w = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        v, w = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        v, w = 0.0, 1.0
    elif vc <= 0.0 and ab_ap >= 0.0 and d3 <= 0.0:
        v, w = ab_ap / (ab_ap - d3), 0.0
    elif vb <= 0.0 and ac_ap >= 0.0 and d6 <= 0.0:
        v, w = 0.0, ac_ap / (ac_ap - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    elif va + vb + vc > 0.0:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    else:  # no area
        v, w = 0.0, 0.0
    weights[0], weights[1], weights[2] = max(1.0 - v - w, 0.0), v, w
    squared = 0.0
    for axis in range(3):
        place = 0.0
        for k in range(3):
            place += weights[k] * positions[face[k], axis]
        squared += (place - query[axis]) ** 2
    return squared
