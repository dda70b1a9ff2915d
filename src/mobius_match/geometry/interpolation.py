"""Interpolation of values that are known at some points."""

from __future__ import annotations

import numpy as np


def interpolate_nearby(
    points: np.ndarray, queries: np.ndarray, values: np.ndarray, *, neighbors: int = 4
) -> np.ndarray:
    """Values (N, p) known at points (p, 3), interpolated at queries (q, 3) by distance in space: (N, q)."""
    return inverse_distance_means(np.sqrt(squared_distances(queries, points)), values, neighbors=neighbors)


def inverse_distance_means(distances: np.ndarray, values: np.ndarray, *, neighbors: int = 4) -> np.ndarray:
    """Inverse distance weighting with exponent 2 (Shepard 1968) over the nearest points.

    Parameters
    ----------
    distances
        (q, p) from each query to each point.
    values
        (N, p) at the points.
    neighbors
        Number of nearest points that each query's value is a mean of.

    Returns
    -------
    numpy.ndarray
        (N, q) at the queries.
    """
    number = min(neighbors, distances.shape[1])
    near = np.argpartition(distances, number - 1, axis=1)[:, :number]
    distances = np.take_along_axis(distances, near, axis=1)
    # A query that lies on a point takes that point's value, nearly, without division by zero.
    weights = 1 / (distances + 1e-3 * distances.mean() + np.finfo(float).tiny) ** 2
    return np.einsum("nqk,qk->nq", values[:, near], weights / weights.sum(axis=1, keepdims=True))


def squared_distances(queries: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Squared distances (q, p) in space of queries (q, 3) from points (p, 3)."""
    return np.asarray(
        sum(np.subtract.outer(query, point) ** 2 for query, point in zip(queries.T, points.T, strict=True))
    )
