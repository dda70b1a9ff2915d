"""The best triplets, clustered by where they send the samples."""

from __future__ import annotations

import numpy as np

from ..voting.assignment import max_row_column


def cluster_triplets(
    pairs: np.ndarray,
    distances: np.ndarray,
    weights: np.ndarray,
    radius: float,
    least_weight: float,
    most: int,
) -> list[np.ndarray]:
    """Cluster triplets greedily: the best one left is the centre of a cluster.

    Parameters
    ----------
    pairs
        (B, N1) int, the target sample of each source sample under each triplet, -1 for none, best triplet first.
    distances
        (N2, N2) between the target's samples per sqrt(area).
    weights
        (B,) of the triplets, not increasing.
    radius
        Largest mean distance of a triplet's images from those of its cluster's centre, per sqrt(area).
    least_weight
        Triplets of less than this fraction of the largest weight are left out.
    most
        Number of clusters at most.

    Returns
    -------
    list of numpy.ndarray
        Numbers of the triplets of each cluster, the centre first; clusters are in the order of their centres.
    """
    left = np.flatnonzero(weights >= least_weight * weights.max(initial=0.0))
    clusters: list[np.ndarray] = []
    while len(left) and len(clusters) < most:
        same = _mean_distances(pairs[left], pairs[left[0]], distances) < radius
        same[0] = True
        clusters.append(left[same])
        left = left[~same]
    return clusters


def agreed_matches(pairs: np.ndarray, weights: np.ndarray, n2: int, most: int) -> np.ndarray:
    """The matches (q, 2) that triplets (B, N1) of weights (B,) agree on, at most so many, the most certain first."""
    votes = np.zeros((pairs.shape[1], n2))
    for row, weight in zip(pairs, weights, strict=True):
        paired = np.flatnonzero(row >= 0)
        votes[paired, row[paired]] += weight**2
    return max_row_column(votes)[0][:most]


def most_consistent_half(pairs: np.ndarray, distances: np.ndarray, cluster: np.ndarray) -> np.ndarray:
    """The half of a cluster's triplets whose images are closest to its centre's; see :func:`cluster_triplets`."""
    order = np.argsort(_mean_distances(pairs[cluster], pairs[cluster[0]], distances), kind="stable")
    return cluster[np.sort(order[: (len(cluster) + 1) // 2])]


def _mean_distances(pairs: np.ndarray, centre: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Mean distances (B,) between the images of the samples under triplets (B, N1) and under another one (N1,)."""
    shared = (pairs >= 0) & (centre >= 0)
    sums = np.where(shared, distances[pairs, centre], 0.0).sum(axis=1)
    return np.where(shared.any(axis=1), sums / np.maximum(shared.sum(axis=1), 1), np.inf)
