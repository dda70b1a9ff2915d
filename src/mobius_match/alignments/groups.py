"""The best triplets, grouped by where they send the samples."""

from __future__ import annotations

import numpy as np

from ..voting.assignment import max_row_column

GROUP_RADIUS = 0.2
"""Two triplets tell the same if they send the samples to places that differ by less, on average, per sqrt(area)."""

LEAST_SHARE = 0.6
"""Groups whose best triplet weighs less than this part of the best of all are not examined."""

MOST_GROUPS = 8
TRUSTED = 60
"""How many of the matches that a group agrees on are used."""


def cluster_triplets(
    pairs: np.ndarray,
    distances: np.ndarray,
    triplet_weights: np.ndarray,
    radius: float = GROUP_RADIUS,
    most: int = MOST_GROUPS,
) -> list[np.ndarray]:
    """Group triplets by where they send the samples.

    Parameters
    ----------
    pairs
        (B, N1) int, the target sample of each source sample under each triplet, -1 for none, best triplet first.
    distances
        (N2, N2) between the target's samples per sqrt(area).
    totals
        (B,) weights of the triplets, not increasing.
    radius, most
        Largest mean distance of a triplet's places from those of its group's best, and how many groups at most.

    Returns
    -------
    list of numpy.ndarray
        Numbers of the triplets of each group; the first of each is its best, and the groups are in their order.
    """
    left = np.flatnonzero(triplet_weights >= LEAST_SHARE * triplet_weights.max(initial=0.0))
    groups: list[np.ndarray] = []
    while len(left) and len(groups) < most:
        same = _differences(pairs[left], pairs[left[0]], distances) < radius
        same[0] = True
        groups.append(left[same])
        left = left[~same]
    return groups


def agreed_matches(pairs: np.ndarray, triplet_weights: np.ndarray, n2: int) -> np.ndarray:
    """The matches (q, 2) that a group of triplets agrees on."""
    votes = np.zeros((pairs.shape[1], n2))
    for row, total in zip(pairs, triplet_weights, strict=True):
        paired = np.flatnonzero(row >= 0)
        votes[paired, row[paired]] += total**2
    return max_row_column(votes)[0][:TRUSTED]


def most_consistent_half(pairs: np.ndarray, distances: np.ndarray, group: np.ndarray) -> np.ndarray:
    """The half of a group's triplets that differ least from its best one; see :func:`cluster_triplets`."""
    apart = _differences(pairs[group], pairs[group[0]], distances)
    return group[np.sort(np.argsort(apart, kind="stable")[: (len(group) + 1) // 2])]


def _differences(pairs: np.ndarray, leader: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Mean distances (B,) between where triplets (B, N1) send the samples and where another (N1,) does."""
    shared = (pairs >= 0) & (leader >= 0)
    sums = np.where(shared, distances[pairs, leader], 0.0).sum(axis=1)
    return np.where(shared.any(axis=1), sums / np.maximum(shared.sum(axis=1), 1), np.inf)
