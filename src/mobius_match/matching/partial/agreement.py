"""How well triplets explain a surface by geodesic distances alone: a part and its whole have no Möbius map.

Distances do not know a surface from its mirror image, which most bodies are of themselves. Directions do: two shortest
paths meet at a point at an angle, left of each other or right.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ..._core.compiling import jit

BATCH = 250
"""Triplets that a thread takes at a time."""


class Paths(NamedTuple):
    """Shortest paths from samples to points.

    Parameters
    ----------
    lengths
        (N, P) float32, in common units.
    x, y
        (N, P) float32: which way they run at the points; see :func:`mobius_match.geometry.directions.directions`.
    """

    lengths: np.ndarray
    x: np.ndarray
    y: np.ndarray

    def to(self, points: np.ndarray) -> Paths:
        """Those to some of the points (p,)."""
        return Paths(*(np.ascontiguousarray(values[:, points]) for values in self))

    def of(self, samples: np.ndarray) -> Paths:
        """Those from some of the samples (s,)."""
        return Paths(*(values[samples] for values in self))


def agreement(
    first: Paths,
    second: Paths,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    turning: float,
    scale: float,
    pool: ThreadPoolExecutor,
) -> np.ndarray:
    """Judge triplets by whether each point of the source finds one of the target as far from the triplet's points.

    Parameters
    ----------
    first, second
        From the samples to points of their surface.
    costs
        (P1, P2) float32, added to the three differences of distances: how unlike two points look.
    triplets1, triplets2
        (I, 3) int: three different samples of each side, matched in order.
    turning
        Weight of the differences of the signed sines of the three angles between paths.
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
        _agreement(first, second, costs, triplets1[part], triplets2[part], np.float32(turning), scale, totals[part])

    list(pool.map(judge, (slice(start, start + BATCH) for start in range(0, len(totals), BATCH))))
    return totals


@jit
def _agreement(
    first: Paths,
    second: Paths,
    costs: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    turning: np.float32,
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
                sines[k, q] = turning * (second.x[one, q] * second.y[two, q] - second.y[one, q] * second.x[two, q])
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
            f = turning * (first.x[i1, p] * first.y[i2, p] - first.y[i1, p] * first.x[i2, p])
            g = turning * (first.x[i2, p] * first.y[i3, p] - first.y[i2, p] * first.x[i3, p])
            h = turning * (first.x[i3, p] * first.y[i1, p] - first.y[i3, p] * first.x[i1, p])
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


def differences(first: Paths, second: Paths, costs: np.ndarray, turning: float) -> np.ndarray:
    """What :func:`agreement` sums for one triplet, from whose samples the paths are: all pairs of points (p1, p2)."""
    total = costs + np.abs(first.lengths[:, :, None] - second.lengths[:, None]).sum(axis=0)
    mine, theirs = (x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0) for _, x, y in (first, second))
    return np.asarray(total + turning * np.abs(mine[:, :, None] - theirs[:, None]).sum(axis=0))


@jit
def match_by_distances(
    first: Paths, second: Paths, costs: np.ndarray, cap: float, soft: float, weight: float, turning: float
) -> np.ndarray:
    """Each point of the source to the one of the target that is as far from the landmarks and looks alike.

    Distances count the less the longer they are: those to landmarks nearby neither lead through what is missing nor
    change much as the surface bends.

    Parameters
    ----------
    first, second
        From L landmarks to the points (P1) and (P2) of their surface.
    costs
        (P1, P2) float32: how unlike two points look.
    cap
        What a difference of distances counts at most.
    soft
        Added to a distance in the source before its inverse is the landmark's weight.
    weight
        Of the mean difference of distances.
    turning
        How much counts that the paths to two points run the same way, once their frames are turned.

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
            length, theirs = first.lengths[k, p], second.lengths[k]
            share = np.float32(1 / (length + soft))
            weights += share
            x, y, x2, y2 = share * first.x[k, p], share * first.y[k, p], second.x[k], second.y[k]
            for q in range(size):
                row[q] += share * min(abs(length - theirs[q]), most)
                along[q] += x * x2[q] + y * y2[q]
                across[q] += y * x2[q] - x * y2[q]
        of_distances, of_turns = np.float32(weight / weights), np.float32(turning / weights)
        best = 0
        for q in range(size):
            same_way = math.sqrt(along[q] * along[q] + across[q] * across[q])
            row[q] = row[q] * of_distances + costs[p, q] - of_turns * same_way
            if row[q] < row[best]:
                best = q
        image[p] = best
    return image
