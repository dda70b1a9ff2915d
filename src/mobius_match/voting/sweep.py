"""Section 6, "Find mutually nearest-neighbors", for many points, in close to N log N: a sweep along the first axis.

It finds the pairs that :mod:`mobius_match.voting.nearest` finds, with the same arguments and on the same arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._core.compiling import jit
from .nearest import (
    BLOCK,
    FARTHEST,
    GROUP,
    Minima,
    Pairs,
    collect,
    compare,
    point,
    reset,
    shortlist,
    squared_distance,
)

SWEEP_FROM = 400
"""Number of points from which the sweep is faster, see benchmarks/kernel.py."""

SEEDS = 32
"""How many columns a row is compared with first, to know how far the sweep has to look."""


class Sorted(NamedTuple):
    """Points sorted into slices of the first axis.

    ``numbers`` are their numbers before, ``slices`` the slice of each of these, ``starts`` where each slice starts.
    """

    points: np.ndarray
    numbers: np.ndarray
    slices: np.ndarray
    starts: np.ndarray


@jit
def sweep(
    first: np.ndarray, n1: int, second: np.ndarray, n2: int, spherical: bool, minima: Minima, pairs: Pairs, i: int
) -> None:
    """Do the work of :func:`mobius_match.voting.nearest.mutually_nearest` on many points in close to N log N.

    A row is compared only with columns that are no farther along the first axis than the nearest column it has been
    compared with. So its nearest column is found, and each mutually nearest pair is among the candidates. A column may
    have nearer rows that were not compared with it: a candidate is a pair if no row within its distance is nearer.
    """
    reset(minima)
    n_slices = max(n1, n2)
    rows, columns = sort(first, n1, n_slices), sort(second, n2, n_slices)
    windows = np.empty((2, max(first.shape[1], second.shape[1])), np.int64)
    find_seeds(rows, n1, columns, windows)
    compare_windows(rows.points, n1, columns.points, windows, spherical, minima)
    find_windows(rows.points, n1, minima.rows, columns, windows)
    compare_windows(rows.points, n1, columns.points, windows, spherical, minima)
    n = collect(shortlist(n2, minima, pairs, i), rows.points, columns.points, spherical, minima, pairs, i)
    find_windows(columns.points, n2, minima.columns, rows, windows)
    pairs.counts[i] = verify(n, rows, columns, windows, spherical, minima, pairs, i)


@jit
def find_seeds(rows: Sorted, n1: int, columns: Sorted, windows: np.ndarray) -> None:
    """Windows of the columns around each row's own slice."""
    for k in range(n1):
        begin = columns.starts[rows.slices[rows.numbers[k]]] // BLOCK * BLOCK - SEEDS // 2
        begin = min(max(begin, 0), columns.points.shape[1] - SEEDS)
        windows[0, k], windows[1, k] = begin, begin + SEEDS


@jit
def find_windows(points: np.ndarray, n: int, squared: np.ndarray, others: Sorted, windows: np.ndarray) -> None:
    """For each point, from where to where the sorted others can lie that are as near as its least distance."""
    n_slices = len(others.starts) - 2
    for k in range(n):
        # A little farther, because squared distances are rounded.
        reach = math.sqrt(np.float64(np.int32(squared[k]).view(np.float32))) * (1 + 1e-6)
        windows[0, k] = slice_of(points[0, k] - reach, n_slices)
        windows[1, k] = slice_of(points[0, k] + reach, n_slices)
    for k in range(n):  # whole blocks
        windows[0, k] = others.starts[windows[0, k]] // BLOCK * BLOCK
        windows[1, k] = -(-others.starts[windows[1, k] + 1] // BLOCK) * BLOCK


@jit
def compare_windows(
    rows: np.ndarray, n1: int, columns: np.ndarray, windows: np.ndarray, spherical: bool, minima: Minima
) -> None:
    """Compare each group of rows with the columns in their windows."""
    for k in range(0, n1, GROUP):
        begin, end = windows[0, k], windows[1, k]
        for row in range(k + 1, min(k + GROUP, n1)):
            begin, end = min(begin, windows[0, row]), max(end, windows[1, row])
        compare(rows, k, columns, begin, end, spherical, minima)


@jit
def verify(
    n_candidates: int,
    rows: Sorted,
    columns: Sorted,
    windows: np.ndarray,
    spherical: bool,
    minima: Minima,
    pairs: Pairs,
    i: int,
) -> int:
    """Keep the candidates that have no nearer row in the column's window, under their numbers before the sorting."""
    n = 0
    for candidate in range(n_candidates):
        j = pairs.columns[i, candidate]
        q, nearest = point(columns.points, j), FARTHEST
        for k in range(np.uint64(windows[0, j]), np.uint64(windows[1, j])):
            nearest = min(nearest, squared_distance(point(rows.points, k), q, spherical))
        pairs.rows[i, n] = rows.numbers[pairs.rows[i, candidate]]
        pairs.columns[i, n] = columns.numbers[j]
        pairs.squared[i, n] = pairs.squared[i, candidate]
        n += nearest >= minima.columns[j]
    return n


@jit
def slice_of(x: float, n_slices: int) -> np.int32:
    """Number of the slice in which a coordinate lies; a greater coordinate is never in a lower one."""
    return np.int32((x / (1 + abs(x)) + 1) * (0.4999999 * n_slices))


@jit
def sort(points: np.ndarray, n: int, n_slices: int) -> Sorted:
    """Sort n points into slices."""
    ordered, numbers = np.empty_like(points), np.empty(n, np.int32)
    slices, starts = np.empty(n, np.int32), np.zeros(n_slices + 2, np.int32)
    for k in range(n):
        slices[k] = slice_of(np.float64(points[0, k]), n_slices)
    for k in range(n):
        starts[np.uint32(slices[k] + 2)] += 1
    for s in range(2, n_slices + 2):
        starts[s] += starts[s - 1]
    # Slice s starts at starts[s + 1] for now, which moves on with every point that is placed, up to the next slice.
    for k in range(n):
        slice_after = np.uint32(slices[k] + 1)
        numbers[np.uint32(starts[slice_after])] = k
        starts[slice_after] += 1
    for place in range(points.shape[1]):
        number = np.uint32(numbers[min(place, n - 1)])
        for axis in range(3):
            ordered[axis, place] = points[axis, number]
    return Sorted(ordered, numbers, slices, starts)
