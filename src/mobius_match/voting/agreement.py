"""How well triplets explain a surface by geodesic distances alone: a part and its whole have no Möbius map."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..compiling import jit

BATCH = 500
"""Triplets that a thread takes at a time."""


def agreement(
    distances1: np.ndarray,
    distances2: np.ndarray,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    scale: float,
    pool: ThreadPoolExecutor,
) -> np.ndarray:
    """Judge triplets by whether each point of the source finds one of the target as far from the triplet's points.

    Parameters
    ----------
    distances1, distances2
        (N1, P1) and (N2, P2) float32, from the samples to points of their surface, in common units.
    costs
        (P1, P2) float32, added to the three differences of distances: how unlike two points look.
    triplets1, triplets2
        (I, 3) int: three different samples of each side, matched in order.
    scale
        Sum of differences and cost at which a point counts 1 / e.
    pool
        Its threads share the work.

    Returns
    -------
    numpy.ndarray
        (I,) float64: the mean over the source's points of what each counts, in [0, 1].
    """
    totals = np.empty(len(triplets1))

    def judge(part: slice) -> None:
        _agreement(distances1, distances2, costs, triplets1[part], triplets2[part], scale, totals[part])

    list(pool.map(judge, (slice(start, start + BATCH) for start in range(0, len(totals), BATCH))))
    return totals


@jit
def _agreement(
    distances1: np.ndarray,
    distances2: np.ndarray,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    scale: float,
    totals: np.ndarray,
) -> None:
    row = np.empty(costs.shape[1], np.float32)
    for i in range(len(triplets1)):
        a, b, c = (distances2[triplets2[i, 0]], distances2[triplets2[i, 1]], distances2[triplets2[i, 2]])
        total = 0.0
        for p in range(len(costs)):
            x, y, z = (
                distances1[triplets1[i, 0], p],
                distances1[triplets1[i, 1], p],
                distances1[triplets1[i, 2], p],
            )
            cost = costs[p]
            for q in range(len(row)):
                row[q] = abs(x - a[q]) + abs(y - b[q]) + abs(z - c[q]) + cost[q]
            least = row[0]
            for q in range(len(row)):
                least = min(least, row[q])
            total += math.exp(-least / scale)
        totals[i] = total / len(costs)


@jit
def as_far(distances1: np.ndarray, distances2: np.ndarray, cap: float, weight: float, costs: np.ndarray) -> np.ndarray:
    """Each point of the source to the one of the target that is as far from the landmarks and looks alike.

    Parameters
    ----------
    distances1, distances2
        (L, P1) and (L, P2) float32, from the landmarks to the points, in common units.
    cap
        What a difference of distances counts at most.
    weight
        Of the sum of differences.
    costs
        (P1, P2) float32, added to it.

    Returns
    -------
    numpy.ndarray
        (P1,) int64 points of the target, the lowest of equal ones.
    """
    image, row = np.empty(len(costs), np.int64), np.empty(costs.shape[1], np.float32)
    most, share = np.float32(cap), np.float32(weight)
    for p in range(len(costs)):
        row[:] = 0
        for k in range(len(distances1)):
            x, theirs = distances1[k, p], distances2[k]
            for q in range(len(row)):
                row[q] += min(abs(x - theirs[q]), most)
        best = 0
        for q in range(len(row)):
            row[q] = row[q] * share + costs[p, q]
            if row[q] < row[best]:
                best = q
        image[p] = best
    return image
