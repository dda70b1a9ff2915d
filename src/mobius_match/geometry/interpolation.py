"""Values that are known at some points, at others."""

from __future__ import annotations

import numpy as np

NEIGHBOURS = 4
"""Vertices of the proxy that a distance is interpolated from."""


def interpolate_nearby(points: np.ndarray, queries: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (N, p) that are known at points (p, 3), at queries (q, 3): (N, q), by distance in space."""
    return _means(np.sqrt(squared_distances(queries, points)), values)


def _means(apart: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (N, p) at queries that lie apart (q, p) from where they are known: (N, q), of the nearest."""
    number = min(NEIGHBOURS, apart.shape[1])
    near = np.argpartition(apart, number - 1, axis=1)[:, :number]
    apart = np.take_along_axis(apart, near, axis=1)
    weights = 1 / (apart + 1e-3 * apart.mean() + np.finfo(float).tiny) ** 2
    return np.einsum("nqk,qk->nq", values[:, near], weights / weights.sum(axis=1, keepdims=True))


def squared_distances(queries: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Squared distances in space (q, p)."""
    # So few points need no search tree, which takes longer to import.
    return np.asarray(
        sum(np.subtract.outer(query, point) ** 2 for query, point in zip(queries.T, points.T, strict=True))
    )
