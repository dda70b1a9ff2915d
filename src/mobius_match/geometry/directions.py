"""Directions of the shortest paths from samples at each point of a surface."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp


def directions(
    points: np.ndarray, normals: np.ndarray, edges: np.ndarray, distances: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of distances, in a tangent frame at each point.

    The frames are arbitrary, but right-handed as seen from outside. So only the angle between two gradients at a point
    has a meaning: isometries keep it, mirror images change its sign.

    Parameters
    ----------
    points, normals
        (P, 3) and their unit normals.
    edges
        (E, 2) between neighbouring points.
    distances
        (N, P) geodesic distances of the points from each of N samples.

    Returns
    -------
    x, y
        (N, P) float32 each, of length 1; shorter where several paths are shortest.
    """
    size = len(points)
    ring = sp.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(size, size))
    ring = ring + ring.T
    near = ring @ ring + ring
    near.setdiag(0)
    near.eliminate_zeros()
    here, there = near.nonzero()
    first = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), np.finfo(float).tiny)
    second = np.cross(normals, first)
    step = points[there] - points[here]
    x, y = (np.einsum("ij,ij->i", step, axis[here]) for axis in (first, second))
    # Steps are rotated into the tangent plane: they keep their length.
    stretch = np.linalg.norm(step, axis=1) / np.maximum(np.hypot(x, y), np.finfo(float).tiny)
    x, y = x * stretch, y * stretch
    # Least squares; a neighbour with another normal, as across an edge of a thin sheet, has a small weight.
    weight = np.maximum(np.einsum("ij,ij->i", normals[here], normals[there]), 0.0)
    xx, xy, yy = (np.bincount(here, weight * product, size) for product in (x * x, x * y, y * y))
    determinant = xx * yy - xy**2
    determinant = np.where(determinant > 1e-6 * (xx + yy) ** 2, determinant, np.inf)[here]
    gradient = []
    for row in (
        weight * (yy[here] * x - xy[here] * y) / determinant,
        weight * (xx[here] * y - xy[here] * x) / determinant,
    ):
        slope = sp.csr_matrix((row, (here, there)), shape=(size, size))
        slope -= sp.diags(np.asarray(slope.sum(axis=1)).ravel())
        gradient.append((slope @ distances.T).T)
    length = np.maximum(np.hypot(*gradient), 1.0)
    return np.ascontiguousarray(gradient[0] / length, np.float32), np.ascontiguousarray(
        gradient[1] / length, np.float32
    )
