"""Quadrics (Garland and Heckbert 1997): weighted sums of squared distances to planes, as kernels."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .rings import after, before

ROUNDNESS = 0.05
"""Weight of the squared distances to the vertices that a vertex replaces, against those to the planes of the faces."""

BOUNDARY = 10.0
"""Weight of the planes through boundary edges, against those of the faces."""


@jit
def unit_normal(vertices: np.ndarray, a: int, b: int, c: int, normal: np.ndarray) -> float:
    """Write the unit normal of a triangle; return twice its area."""
    x1, y1, z1 = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    x2, y2, z2 = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
    x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 0.0 else 0.0
    normal[0], normal[1], normal[2] = scale * x, scale * y, scale * z
    return length


@jit
def squared_length(vertices: np.ndarray, a: int, b: int) -> float:
    """Squared length of the edge between two vertices."""
    return (
        (vertices[a, 0] - vertices[b, 0]) ** 2
        + (vertices[a, 1] - vertices[b, 1]) ** 2
        + (vertices[a, 2] - vertices[b, 2]) ** 2
    )


@jit
def _add_plane(quadric: np.ndarray, x: float, y: float, z: float, d: float, weight: float) -> None:
    quadric[0] += weight * x * x
    quadric[1] += weight * x * y
    quadric[2] += weight * x * z
    quadric[3] += weight * x * d
    quadric[4] += weight * y * y
    quadric[5] += weight * y * z
    quadric[6] += weight * y * d
    quadric[7] += weight * z * z
    quadric[8] += weight * z * d
    quadric[9] += weight * d * d


@jit
def add_quadrics(vertices: np.ndarray, corners: np.ndarray, opposite: np.ndarray, quadrics: np.ndarray) -> None:
    """Add the planes of faces and boundary edges, and the vertices themselves, to the quadrics (n, 10) of vertices."""
    normal, along, conormal = np.empty(3), np.empty(3), np.empty(3)
    for face in range(len(corners) // 3):
        a, b, c = corners[3 * face], corners[3 * face + 1], corners[3 * face + 2]
        area = 0.5 * unit_normal(vertices, a, b, c, normal)
        if not area > 0.0:
            continue
        offset = -(normal[0] * vertices[a, 0] + normal[1] * vertices[a, 1] + normal[2] * vertices[a, 2])
        for k in range(3):
            v = corners[3 * face + k]
            quadric = quadrics[v]
            _add_plane(quadric, normal[0], normal[1], normal[2], offset, area / 3)
            # The squared distance to a point is that to three orthogonal planes through it.
            _add_plane(quadric, 1.0, 0.0, 0.0, -vertices[v, 0], ROUNDNESS * area / 3)
            _add_plane(quadric, 0.0, 1.0, 0.0, -vertices[v, 1], ROUNDNESS * area / 3)
            _add_plane(quadric, 0.0, 0.0, 1.0, -vertices[v, 2], ROUNDNESS * area / 3)
        for k in range(3):
            if opposite[3 * face + k] < 0:  # a plane through the edge, orthogonal to the face, keeps the boundary
                p, q = corners[after(3 * face + k)], corners[before(3 * face + k)]
                squared = 0.0
                for axis in range(3):
                    along[axis] = vertices[q, axis] - vertices[p, axis]
                    squared += along[axis] ** 2
                length = np.sqrt(squared)
                if length > 0.0:
                    for axis in range(3):
                        i, j = (axis + 1) % 3, (axis + 2) % 3
                        conormal[axis] = (normal[i] * along[j] - normal[j] * along[i]) / length
                    offset = -(
                        conormal[0] * vertices[p, 0] + conormal[1] * vertices[p, 1] + conormal[2] * vertices[p, 2]
                    )
                    for v in (p, q):
                        _add_plane(quadrics[v], conormal[0], conormal[1], conormal[2], offset, BOUNDARY * squared / 2)


@jit
def cost(one: np.ndarray, two: np.ndarray, place: np.ndarray) -> float:
    """The sum of the quadrics of two vertices, at a place."""
    x, y, z = place[0], place[1], place[2]
    return (
        (one[0] + two[0]) * x * x
        + 2 * (one[1] + two[1]) * x * y
        + 2 * (one[2] + two[2]) * x * z
        + 2 * (one[3] + two[3]) * x
        + (one[4] + two[4]) * y * y
        + 2 * (one[5] + two[5]) * y * z
        + 2 * (one[6] + two[6]) * y
        + (one[7] + two[7]) * z * z
        + 2 * (one[8] + two[8]) * z
        + (one[9] + two[9])
    )
