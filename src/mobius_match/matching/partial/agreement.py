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

    list(pool.map(evaluate, batches(len(totals))))
    return totals


def batches(count: int) -> list[slice]:
    """So many triplets, divided into those that a thread evaluates at a time."""
    return [slice(start, start + BATCH) for start in range(0, count, BATCH)]


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


@jit
def images_by_triplets(
    first: Paths,
    second: Paths,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    direction_weight: float,
    images: np.ndarray,
) -> None:
    """Write the point (I, P1) of the target with the least error, as in :func:`agreement`, for each of the source."""
    three, weight, size = np.float32(3), np.float32(direction_weight), costs.shape[1]
    row, sines = np.empty(size, np.float32), np.empty((3, size), np.float32)
    for i in range(len(triplets1)):
        for k in range(3):
            one, two = triplets2[i, k], triplets2[i, (k + 1) % 3]
            for q in range(size):
                sines[k, q] = second.x[one, q] * second.y[two, q] - second.y[one, q] * second.x[two, q]
        a, b, c = (
            second.lengths[triplets2[i, 0]],
            second.lengths[triplets2[i, 1]],
            second.lengths[triplets2[i, 2]],
        )
        s, t, u = sines[0], sines[1], sines[2]
        for p in range(len(costs)):
            i1, i2, i3 = triplets1[i, 0], triplets1[i, 1], triplets1[i, 2]
            x, y, z = first.lengths[i1, p], first.lengths[i2, p], first.lengths[i3, p]
            f = first.x[i1, p] * first.y[i2, p] - first.y[i1, p] * first.x[i2, p]
            g = first.x[i2, p] * first.y[i3, p] - first.y[i2, p] * first.x[i3, p]
            h = first.x[i3, p] * first.y[i1, p] - first.y[i3, p] * first.x[i1, p]
            for q in range(size):
                lengths = (abs(x - a[q]) + abs(y - b[q]) + abs(z - c[q])) / three
                angles = (abs(f - s[q]) + abs(g - t[q]) + abs(h - u[q])) / three
                row[q] = (lengths + weight * angles) + costs[p, q]
            best = 0
            for q in range(size):
                if row[q] < row[best]:
                    best = q
            images[i, p] = best


@jit(fastmath={"contract", "nnan", "nsz"})
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
    most, count = np.float32(cap), len(first.lengths)
    for p in range(len(costs)):
        row[:], along[:], across[:] = 0, 0, 0
        weights = np.float32(0)
        # Two landmarks at a time, since sums in memory take longer than sums in registers.
        for k in range(0, count, 2):
            j = min(k + 1, count - 1)
            length, length_j = first.lengths[k, p], first.lengths[j, p]
            share, share_j = np.float32(1 / (length + soft)), np.float32(1 / (length_j + soft))
            if j == k:
                share_j = np.float32(0)
            weights += share
            weights += share_j
            x, y, x_j, y_j = (
                share * first.x[k, p],
                share * first.y[k, p],
                share_j * first.x[j, p],
                share_j * first.y[j, p],
            )
            lengths, x2, y2 = second.lengths[k], second.x[k], second.y[k]
            lengths_j, x2_j, y2_j = second.lengths[j], second.x[j], second.y[j]
            for q in range(size):
                near, near_j = min(abs(length - lengths[q]), most), min(abs(length_j - lengths_j[q]), most)
                row[q] = (row[q] + share * near) + share_j * near_j
                along[q] = (along[q] + (x * x2[q] + y * y2[q])) + (x_j * x2_j[q] + y_j * y2_j[q])
                across[q] = (across[q] + (y * x2[q] - x * y2[q])) + (y_j * x2_j[q] - x_j * y2_j[q])
        of_distances, of_directions = np.float32(1 / weights), np.float32(direction_weight / weights)
        best = 0
        for q in range(size):
            agreeing = math.sqrt(along[q] * along[q] + across[q] * across[q])
            row[q] = row[q] * of_distances + costs[p, q] - of_directions * agreeing
        for q in range(size):
            if row[q] < row[best]:
                best = q
        image[p] = best
    return image


@jit
def mean_differences(first: np.ndarray, second: np.ndarray, weight: float, cap: float) -> np.ndarray:
    """Weighted mean absolute differences (p, q) float32 of the rows of (p, c) and (q, c), none above the cap."""
    out = np.empty((len(first), len(second)), np.float32)
    for i in range(len(first)):
        for j in range(len(second)):
            total = 0.0
            for k in range(first.shape[1]):
                total += abs(first[i, k] - second[j, k])
            out[i, j] = min(weight * (total / first.shape[1]), cap)
    return out
