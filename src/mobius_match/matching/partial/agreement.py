"""Triplets evaluated by shortest paths, since no Möbius map takes a part to its whole.

Distances do not distinguish a surface from its mirror image, and most bodies are their own mirror image. Directions do:
at a point, one shortest path lies to the left or to the right of another.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ..._core.compiling import jit

BATCH = 250
"""Triplets that a thread evaluates at a time."""


class Paths(NamedTuple):
    """Shortest paths from samples to points.

    Parameters
    ----------
    lengths
        (N, P) float32, per sqrt(area) of the whole.
    x, y
        (N, P) float32 directions at the points; see :func:`mobius_match.geometry.directions.directions`.
    """

    lengths: np.ndarray
    x: np.ndarray
    y: np.ndarray

    def to(self, points: np.ndarray) -> Paths:
        """The paths to some of the points (p,)."""
        return Paths(*(np.ascontiguousarray(values[:, points]) for values in self))

    def of(self, samples: np.ndarray) -> Paths:
        """The paths from some of the samples (s,)."""
        return Paths(*(values[samples] for values in self))


def agreement(
    first: Paths,
    second: Paths,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    direction_weight: float,
    scale: float,
    pool: ThreadPoolExecutor,
) -> np.ndarray:
    """Evaluate triplets: has each point of the source a point of the target at the same distances from the triplet?

    Parameters
    ----------
    first, second
        From the samples to points of their surface.
    costs
        (P1, P2) float32 added to the mean difference of the three distances, in the same unit.
    triplets1, triplets2
        (I, 3) int: three different samples of each side, matched in order.
    direction_weight
        Weight of the mean difference of the signed sines of the three angles between paths.
    scale
        The sum of these errors at which a point counts 1 / e.
    pool
        Its threads share the work.

    Returns
    -------
    numpy.ndarray
        (I,) float64 in [0, 1]: the mean over the source's points of exp(-least error / scale).
    """
    totals = np.empty(len(triplets1))
    # The kernel sums over the three points of a triplet.
    costs, weight = np.float32(3) * costs, np.float32(direction_weight)

    def evaluate(part: slice) -> None:
        _agreement(first, second, costs, triplets1[part], triplets2[part], weight, 3 * scale, totals[part])

    list(pool.map(evaluate, (slice(start, start + BATCH) for start in range(0, len(totals), BATCH))))
    return totals


@jit
def _agreement(
    first: Paths,
    second: Paths,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    weight: np.float32,
    scale: float,
    totals: np.ndarray,
) -> None:
    size = costs.shape[1]
    row, sines = np.empty(size, np.float32), np.empty((3, size), np.float32)
    bits = row.view(np.int32)  # of numbers that are not negative order as they do, and vector instructions find least
    for i in range(len(triplets1)):
        for k in range(3):
            one, two = triplets2[i, k], triplets2[i, (k + 1) % 3]
            for q in range(size):
                sines[k, q] = weight * (second.x[one, q] * second.y[two, q] - second.y[one, q] * second.x[two, q])
        a, b, c = (
            second.lengths[triplets2[i, 0]],
            second.lengths[triplets2[i, 1]],
            second.lengths[triplets2[i, 2]],
        )
        s, t, u = sines[0], sines[1], sines[2]
        total = 0.0
        for p in range(len(costs)):
            i1, i2, i3 = triplets1[i, 0], triplets1[i, 1], triplets1[i, 2]
            x, y, z = first.lengths[i1, p], first.lengths[i2, p], first.lengths[i3, p]
            f = weight * (first.x[i1, p] * first.y[i2, p] - first.y[i1, p] * first.x[i2, p])
            g = weight * (first.x[i2, p] * first.y[i3, p] - first.y[i2, p] * first.x[i3, p])
            h = weight * (first.x[i3, p] * first.y[i1, p] - first.y[i3, p] * first.x[i1, p])
            cost = costs[p]
            for q in range(size):
                row[q] = (
                    abs(x - a[q])
                    + abs(y - b[q])
                    + abs(z - c[q])
                    + abs(f - s[q])
                    + abs(g - t[q])
                    + abs(h - u[q])
                    + cost[q]
                )
            least = bits[0]
            for q in range(size):
                least = min(least, bits[q])
            total += math.exp(-np.int32(least).view(np.float32) / scale)
        totals[i] = total / len(costs)


def differences(first: Paths, second: Paths, costs: np.ndarray, direction_weight: float) -> np.ndarray:
    """The errors (p1, p2) of all pairs of points in :func:`agreement`, for one triplet from which the paths are."""
    lengths = np.abs(first.lengths[:, :, None] - second.lengths[:, None]).mean(axis=0)
    sines1, sines2 = (x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0) for _, x, y in (first, second))
    sines = np.abs(sines1[:, :, None] - sines2[:, None]).mean(axis=0)
    return np.asarray(lengths + direction_weight * sines + costs)


@jit
def match_by_distances(
    first: Paths, second: Paths, costs: np.ndarray, cap: float, soft: float, direction_weight: float
) -> np.ndarray:
    """The point of the target whose distances from landmarks, directions and curvature are most like a source point's.

    Long distances have less weight: short paths do not run through what is missing, and change little as the surface
    bends.

    Parameters
    ----------
    first, second
        From L landmarks to the points (P1) and (P2) of their surface.
    costs
        (P1, P2) float32 added to the weighted mean difference of distances, in the same unit.
    cap
        Largest difference of distances that is counted.
    soft
        Added to a distance in the source before its inverse is the landmark's weight.
    direction_weight
        Weight of 1 - the agreement of directions, after the best rotation of the frame at one of the points.

    Returns
    -------
    numpy.ndarray
        (P1,) int64 points of the target, the lowest of equal ones.
    """
    size = costs.shape[1]
    image, row = np.empty(len(costs), np.int64), np.empty(size, np.float32)
    along, across = np.empty(size, np.float32), np.empty(size, np.float32)
    most = np.float32(cap)
    for p in range(len(costs)):
        row[:], along[:], across[:] = 0, 0, 0
        weights = np.float32(0)
        for k in range(len(first.lengths)):
            length, lengths = first.lengths[k, p], second.lengths[k]
            share = np.float32(1 / (length + soft))
            weights += share
            x, y, x2, y2 = share * first.x[k, p], share * first.y[k, p], second.x[k], second.y[k]
            for q in range(size):
                row[q] += share * min(abs(length - lengths[q]), most)
                along[q] += x * x2[q] + y * y2[q]
                across[q] += y * x2[q] - x * y2[q]
        of_distances, of_directions = np.float32(1 / weights), np.float32(direction_weight / weights)
        best = 0
        for q in range(size):
            agreeing = math.sqrt(along[q] * along[q] + across[q] * across[q])
            row[q] = row[q] * of_distances + costs[p, q] - of_directions * agreeing
            if row[q] < row[best]:
                best = q
        image[p] = best
    return image
