"""Section 6, "Find mutually nearest-neighbors": the line of Algorithm 2 that takes most of the time.

All points of one set are compared with all of the other where they are few; where they are many, a sweep along the
first axis leaves most of them out. Either way the same pairs are found.

Points are the columns of float32 arrays (3, padded): two coordinates in the plane, three on the sphere. The columns
after the last point repeat it, which changes no minimum and leaves the inner loops whole vector instructions. Points of
the first set are called rows here and those of the second columns, after the matrix of distances that is never stored.

numba keeps compiled callers when a function in another file changes: delete ``__pycache__`` after changes here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiling import inlined, jit

BLOCK = 8
LARGEST = np.finfo(np.float32).max.view(np.int32)

SWEEP_FROM = 350
"""Number of points from which the sweep is faster, see benchmarks/kernel.py."""

SEEDS = 32
"""How many columns a row is compared with in the sweep to know how far it has to look."""


Index = int | np.unsignedinteger


class Least(NamedTuple):
    """Least squared distances (as bits) found so far of rows and of columns, and the nearest row of each column."""

    of_rows: np.ndarray
    of_columns: np.ndarray
    nearest_rows: np.ndarray


class Pairs(NamedTuple):
    """Room for pairs: the i-th is of points ``rows[i]`` and ``columns[i]``, ``squared[i]`` their distance squared."""

    rows: np.ndarray
    columns: np.ndarray
    squared: np.ndarray


class Sorted(NamedTuple):
    """Points by slices of the first axis: their old numbers, the slice of each old number, where each slice starts."""

    points: np.ndarray
    numbers: np.ndarray
    slices: np.ndarray
    starts: np.ndarray


@jit
def padded(n: int) -> int:
    """Number of columns of an array for n points."""
    return -(-n // BLOCK) * BLOCK


@jit
def room_for_least(n1: int, n2: int) -> Least:
    """Room for n1 rows and n2 columns."""
    rows, columns = np.empty(padded(n1), np.int32), np.empty(padded(n2), np.int32)
    return Least(rows, columns, np.empty_like(columns))


@jit
def room_for_pairs(n2: int) -> Pairs:
    """Room for as many pairs as there are columns."""
    return Pairs(np.empty(n2, np.int32), np.empty(n2, np.int32), np.empty(n2, np.float32))


@jit
def point(points: np.ndarray, k: Index) -> tuple[float, float, float]:
    """The three numbers of a point."""
    return points[0, k], points[1, k], points[2, k]


@jit
def squared_distance(points: np.ndarray, j: Index, to: tuple[float, float, float], spherical: bool) -> np.int32:
    """Squared distance of a point as the bits of a float32.

    It is not negative, so the bits order as the numbers do, and minima of integers are single vector instructions.
    """
    dx, dy = points[0, j] - to[0], points[1, j] - to[1]
    square = dx * dx + dy * dy
    if spherical:
        dz = points[2, j] - to[2]
        square += dz * dz
    return np.float32(square).view(np.int32)


@inlined
def compare(first: np.ndarray, k: int, second: np.ndarray, begin: int, end: int, spherical: bool, least: Least) -> None:
    """Bring the least distances up to date with those between rows k and k + 1 and the columns from begin to end."""
    of_rows, of_columns, nearest_rows = least
    one, two = point(first, k), point(first, k + 1)
    least_one, least_two = of_rows[k], of_rows[k + 1]
    for column in range(begin, end):
        j = np.uint64(column)  # numbers that might be negative would keep the loop from vector instructions
        to_one, to_two = squared_distance(second, j, one, spherical), squared_distance(second, j, two, spherical)
        least_one, least_two = min(to_one, least_one), min(to_two, least_two)
        nearest, least_here = nearest_rows[j], of_columns[j]
        nearest, least_here = np.int32(k) if to_one < least_here else nearest, min(to_one, least_here)
        nearest_rows[j] = np.int32(k + 1) if to_two < least_here else nearest
        of_columns[j] = min(to_two, least_here)
    of_rows[k], of_rows[k + 1] = least_one, least_two


@jit
def mutually_nearest(
    first: np.ndarray, n1: int, second: np.ndarray, n2: int, spherical: bool, least: Least, pairs: Pairs
) -> int:
    """Pair the points that are each other's nearest; write them to ``pairs`` and return their number.

    Each point is in one pair at most: of equally near points one is taken, always the same.
    """
    least.of_rows[:] = LARGEST
    least.of_columns[:] = LARGEST
    least.nearest_rows[:] = 0
    if min(n1, n2) >= SWEEP_FROM:
        return sweep(first, n1, second, n2, spherical, least, pairs)
    compare_all(first, n1, second, spherical, least)
    return collect(n2, least, pairs)


@jit
def compare_all(first: np.ndarray, n1: int, second: np.ndarray, spherical: bool, least: Least) -> None:
    """Compare all rows with all columns."""
    for k in range(0, n1, 2):
        compare(first, k, second, 0, second.shape[1], spherical, least)


@jit
def collect(n2: int, least: Least, pairs: Pairs) -> int:
    """Write the columns that are the nearest of their nearest row; return their number."""
    of_rows, of_columns, nearest_rows = least
    n = 0
    for j in range(n2):
        k, nearest = nearest_rows[j], of_columns[j]
        if of_rows[k] == nearest:
            pairs.rows[n], pairs.columns[n], pairs.squared[n] = k, j, np.int32(nearest).view(np.float32)
            of_rows[k] = -1  # taken
            n += 1
    return n


@jit
def sweep(first: np.ndarray, n1: int, second: np.ndarray, n2: int, spherical: bool, least: Least, pairs: Pairs) -> int:
    """Do the work of :func:`mutually_nearest` on many points in close to N log N.

    A row is compared with those columns alone that are no farther along the first axis than the nearest it has seen.
    So it sees its nearest, and each mutually nearest pair is among the candidates. A column may have nearer rows that
    did not look as far: a candidate is a pair if no row within its distance is nearer.
    """
    n_slices = max(n1, n2)
    rows, columns = sort(first, n1, n_slices), sort(second, n2, n_slices)
    windows = np.empty((2, padded(n_slices)), np.int32)
    compare_neighbours(rows, n1, columns, spherical, least)
    find_windows(rows.points, n1, least.of_rows, columns.starts, windows)
    compare_windows(rows.points, n1, columns.points, windows, spherical, least)
    n_candidates = collect(n2, least, pairs)
    find_windows(columns.points, n2, least.of_columns, rows.starts, windows)
    return verify(n_candidates, rows, columns, windows, spherical, least, pairs)


@jit
def compare_neighbours(rows: Sorted, n1: int, columns: Sorted, spherical: bool, least: Least) -> None:
    """Compare each row with the columns about its own slice."""
    for k in range(0, n1, 2):
        begin = columns.starts[rows.slices[rows.numbers[k]]] // BLOCK * BLOCK - SEEDS // 2
        begin = min(max(begin, 0), columns.points.shape[1] - SEEDS)
        compare(rows.points, k, columns.points, begin, begin + SEEDS, spherical, least)


@jit
def compare_windows(
    rows: np.ndarray, n1: int, columns: np.ndarray, windows: np.ndarray, spherical: bool, least: Least
) -> None:
    """Compare each row with the columns in its window."""
    for k in range(0, n1, 2):
        begin, end = min(windows[0, k], windows[0, k + 1]), max(windows[1, k], windows[1, k + 1])
        compare(rows, k, columns, begin // BLOCK * BLOCK, padded(end), spherical, least)


@jit
def verify(
    n: int, rows: Sorted, columns: Sorted, windows: np.ndarray, spherical: bool, least: Least, pairs: Pairs
) -> int:
    """Keep of n candidates those that have no nearer row in the column's window, under their old numbers."""
    n_pairs = 0
    for i in range(n):
        j = pairs.columns[i]
        here, nearest = point(columns.points, j), least.of_columns[j]
        for row in range(windows[0, j] // BLOCK * BLOCK, padded(windows[1, j])):
            nearest = min(nearest, squared_distance(rows.points, np.uint64(row), here, spherical))
        pairs.rows[n_pairs], pairs.columns[n_pairs] = rows.numbers[pairs.rows[i]], columns.numbers[j]
        pairs.squared[n_pairs] = pairs.squared[i]
        n_pairs += nearest == least.of_columns[j]
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
        ordered[0, place], ordered[1, place], ordered[2, place] = point(points, number)
    return Sorted(ordered, numbers, slices, starts)
