"""Which way the shortest paths from the samples run at each point of a surface."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp


def directions(
    points: np.ndarray, normals: np.ndarray, edges: np.ndarray, distances: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of distances, in the frame of each point.

    Frames are any that are right-handed as seen from outside: what two gradients at a point say of each other, and
    only that, is the same on a surface that is bent, and changes its sign on its mirror image.

    Parameters
    ----------
    points, normals
        (P, 3) and their unit normals.
    edges
        (E, 2) between neighbours.
    distances
        (N, P) of the points from each of N samples.

    Returns
    -------
    x, y
        (N, P) float32 each, of length 1; less where several paths are shortest.
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
    # Steps are laid into the plane at their full length.
    stretch = np.linalg.norm(step, axis=1) / np.maximum(np.hypot(x, y), np.finfo(float).tiny)
    x, y = x * stretch, y * stretch
    # Least squares; a neighbour that looks elsewhere, as across an edge of a thin sheet, counts little.
    weight = np.maximum(np.einsum("ij,ij->i", normals[here], normals[there]), 0.0)
    xx, xy, yy = (np.bincount(here, weight * product, size) for product in (x * x, x * y, y * y))
    whole = xx * yy - xy**2
    whole = np.where(whole > 1e-6 * (xx + yy) ** 2, whole, np.inf)[here]
    found = []
    for row in (weight * (yy[here] * x - xy[here] * y) / whole, weight * (xx[here] * y - xy[here] * x) / whole):
        slope = sp.csr_matrix((row, (here, there)), shape=(size, size))
        slope -= sp.diags(np.asarray(slope.sum(axis=1)).ravel())
        found.append((slope @ distances.T).T)
    length = np.maximum(np.hypot(*found), 1.0)
    return np.ascontiguousarray(found[0] / length, np.float32), np.ascontiguousarray(found[1] / length, np.float32)
