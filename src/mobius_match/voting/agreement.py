"""How well triplets explain a surface by geodesic distances alone: a part and its whole have no Möbius map."""

from __future__ import annotations

import math

import numpy as np

from ..compiling import jit


@jit
def agreement(
    distances1: np.ndarray,
    distances2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    costs: np.ndarray,
    scale: float,
    totals: np.ndarray,
) -> None:
    """Judge triplets by whether each point of the source finds one of the target as far from the triplet's points.

    Parameters
    ----------
    distances1, distances2
        (N1, P1) and (N2, P2) float32, from the samples to points of their surface, in common units.
    triplets1, triplets2
        (I, 3) int: three different samples of each side, matched in order.
    costs
        (P1, P2) float32, added to the three differences of distances: how unlike two points look.
    scale
        Sum of differences and cost at which a point counts 1 / e.
    totals
        (I,) float64, written to: the mean over the source's points of what each counts, in [0, 1].
    """
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
