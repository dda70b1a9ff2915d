"""Section 6, "Find mutually nearest-neighbors", for many points, in close to N log N: a sweep along the first axis.

It finds the pairs that :mod:`mobius_match.voting.nearest` finds, and takes and gives what that does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._core.compiling import inlined, jit
from .lanes import WIDTH, least_lane, load, minimum, spread, store, where_less
from .nearest import LARGEST, Least, Pairs, collect, forget, padded, point, points_from, shortlist, squared_distances

SWEEP_FROM = 400
"""Number of points from which the sweep is faster, see benchmarks/kernel.py."""

SEEDS = 32
"""How many columns a row is compared with in the sweep to know how far it has to look."""


class Sorted(NamedTuple):
    """Points by slices of the first axis: their old numbers, the slice of each old number, where each slice starts."""

    points: np.ndarray
    numbers: np.ndarray
    slices: np.ndarray
    starts: np.ndarray


@jit
def sweep(first: np.ndarray, n1: int, second: np.ndarray, n2: int, spherical: bool, least: Least, pairs: Pairs) -> int:
    """Do the work of :func:`mobius_match.voting.nearest.mutually_nearest` on many points in close to N log N.

    Rows are compared with those columns alone that are no farther along the first axis than the nearest that they have
    seen. So they see their nearest, and each mutually nearest pair is among the candidates. A column may have nearer
    rows that did not look as far: a candidate is a pair if no row within its distance is nearer.
    """
    forget(least)
    n_slices = max(n1, n2)
    rows, columns = sort(first, n1, n_slices), sort(second, n2, n_slices)
    windows = np.empty((2, padded(n_slices)), np.int32)
    compare_neighbours(rows, n1, columns, spherical, least)
    find_windows(rows.points, n1, least.of_rows, columns.starts, windows)
    compare_windows(rows.points, n1, columns.points, windows, spherical, least)
    n_candidates = collect(shortlist(n2, least, pairs), rows.points, columns.points, spherical, least, pairs)
    find_windows(columns.points, n2, least.of_columns, rows.starts, windows)
    return verify(n_candidates, rows, columns, windows, spherical, least, pairs)


@inlined
def compare_two(
    first: np.ndarray, k: int, second: np.ndarray, begin: int, end: int, spherical: bool, least: Least
) -> None:
    """Bring the least distances up to date with those between rows k and k + 1 and the columns from begin to end.

    Columns go in whole vectors, from before the beginning to beyond the end if need be: those that overlapped others
    that were just written would have to wait for them.
    """
    of_rows, of_columns, groups, _ = least
    one, two = point(first, k), point(first, k + 1)
    of_one, of_two = spread(LARGEST), spread(LARGEST)
    group = spread(np.int32(min(k, len(of_rows) - WIDTH)))
    for column in range(begin // WIDTH * WIDTH, end, WIDTH):
        there = points_from(second, column)
        to_one, to_two = squared_distances(there, one, spherical), squared_distances(there, two, spherical)
        of_one, of_two = minimum(to_one, of_one), minimum(to_two, of_two)
        nearer = minimum(to_one, to_two)
        # Both are read before either is written: else AVX2 writes groups lane by lane, which takes three times as long.
        before, group_before = load(of_columns, column), load(groups, column)
        store(of_columns, column, minimum(nearer, before))
        store(groups, column, where_less(nearer, before, group, group_before))
    of_rows[k], of_rows[k + 1] = min(of_rows[k], least_lane(of_one)), min(of_rows[k + 1], least_lane(of_two))


@jit
def compare_neighbours(rows: Sorted, n1: int, columns: Sorted, spherical: bool, least: Least) -> None:
    """Compare each row with the columns about its own slice."""
    for k in range(0, n1, 2):
        begin = columns.starts[rows.slices[rows.numbers[k]]] // WIDTH * WIDTH - SEEDS // 2
        begin = min(max(begin, 0), columns.points.shape[1] - SEEDS)
        compare_two(rows.points, k, columns.points, begin, begin + SEEDS, spherical, least)


@jit
def compare_windows(
    rows: np.ndarray, n1: int, columns: np.ndarray, windows: np.ndarray, spherical: bool, least: Least
) -> None:
    """Compare each row with the columns in its window."""
    for k in range(0, n1, 2):
        begin, end = min(windows[0, k], windows[0, k + 1]), max(windows[1, k], windows[1, k + 1])
        compare_two(rows, k, columns, begin, end, spherical, least)


@jit
def verify(
    n: int, rows: Sorted, columns: Sorted, windows: np.ndarray, spherical: bool, least: Least, pairs: Pairs
) -> int:
    """Keep of n candidates those that have no nearer row in the column's window, under their old numbers."""
    n_pairs = 0
    for i in range(n):
        j = pairs.columns[i]
        here, nearest = point(columns.points, j), spread(LARGEST)
        for row in range(windows[0, j] // WIDTH * WIDTH, windows[1, j], WIDTH):
            squared = squared_distances(points_from(rows.points, row), here, spherical)
            nearest = minimum(squared, nearest)
        pairs.rows[n_pairs], pairs.columns[n_pairs] = rows.numbers[pairs.rows[i]], columns.numbers[j]
        pairs.squared[n_pairs] = pairs.squared[i]
        n_pairs += least_lane(nearest) >= least.of_columns[j]
    return n_pairs


@jit
def find_windows(points: np.ndarray, n: int, squared: np.ndarray, starts: np.ndarray, windows: np.ndarray) -> None:
    """For each point, from where to where the sorted others can lie that are as near as its least distance."""
    n_slices = len(starts) - 2
    for k in range(n):
        # A little farther, because squared distances are rounded.
        reach = math.sqrt(np.float64(np.int32(squared[k]).view(np.float32))) * (1 + 1e-6)
        windows[0, k] = slice_of(points[0, k] - reach, n_slices)
        windows[1, k] = slice_of(points[0, k] + reach, n_slices)
    for k in range(n):
        windows[0, k], windows[1, k] = starts[windows[0, k]], starts[windows[1, k] + 1]
    if n % 2 == 1:  # rows go in twos
        windows[:, n] = windows[:, n - 1]


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
