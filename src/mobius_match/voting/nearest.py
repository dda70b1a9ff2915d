"""Section 6, "Find mutually nearest-neighbors": the line of Algorithm 2 that takes most of the time.

All points of one set are compared with all of the other; :mod:`mobius_match.voting.sweep` is for many points.

Points are the columns of float32 arrays (3, padded): two coordinates in the plane, three on the sphere. The columns
after the last point repeat it, which changes no minimum and leaves whole vectors. Points of the first set are called
rows here and those of the second columns, after the matrix of distances that is never stored.

numba keeps compiled callers when a function in another file changes: delete ``__pycache__`` after changes here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._core.compiling import inlined, jit
from .lanes import WIDTH, any_equal, bits, first_equal, least_lane, load, minimum, spread, store, where_less

LARGEST = np.finfo(np.float32).max.view(np.int32)

Point = tuple[Any, Any, Any]
"""Three coordinates, each of them ``Lanes``: sixteen points."""


class Least(NamedTuple):
    """Least squared distances (as bits) found so far of rows and of columns.

    ``groups`` tells of each column from which row on the nearest is one of sixteen; which of them it is matters for few
    columns. ``lanes`` is room for sixteen least distances of each row, from as many columns that follow each other.
    """

    of_rows: np.ndarray
    of_columns: np.ndarray
    groups: np.ndarray
    lanes: np.ndarray


class Pairs(NamedTuple):
    """Room for pairs: the i-th is of points ``rows[i]`` and ``columns[i]``, ``squared[i]`` their distance squared."""

    rows: np.ndarray
    columns: np.ndarray
    squared: np.ndarray


@jit
def padded(n: int) -> int:
    """Number of columns of an array for n points."""
    return -(-n // WIDTH) * WIDTH


@jit
def room_for_least(n1: int, n2: int) -> Least:
    """Room for n1 rows and n2 columns."""
    rows, columns = np.empty(padded(n1), np.int32), np.empty(padded(n2), np.int32)
    return Least(rows, columns, np.empty_like(columns), np.empty((padded(n1), WIDTH), np.int32))


@jit
def forget(least: Least) -> None:
    """Start anew."""
    least.of_rows[:] = LARGEST
    least.of_columns[:] = LARGEST
    least.groups[:] = 0


@jit
def room_for_pairs(n2: int) -> Pairs:
    """Room for as many pairs as there are columns."""
    return Pairs(np.empty(n2, np.int32), np.empty(n2, np.int32), np.empty(n2, np.float32))


@jit
def points_from(points: np.ndarray, start: int) -> Point:
    """The coordinates of sixteen points."""
    size = points.shape[1]
    return load(points, start), load(points, size + start), load(points, 2 * size + start)


@jit
def point(points: np.ndarray, k: int) -> Point:
    """The coordinates of one point, in all lanes."""
    j = np.uint64(k)
    return spread(points[0, j]), spread(points[1, j]), spread(points[2, j])


@jit
def squared_distances(one: Point, other: Point, spherical: bool) -> Any:
    """Squared distances as the bits of float32.

    They are not negative, so the bits order as the numbers do, and minima of integers are single vector instructions.
    """
    dx, dy = one[0] - other[0], one[1] - other[1]
    square = dx * dx + dy * dy
    if spherical:
        dz = one[2] - other[2]
        square = square + dz * dz
    return bits(square)


@jit
def compare(
    first: np.ndarray, n1: int, second: np.ndarray, begin: int, end: int, spherical: bool, least: Least
) -> None:
    """Bring the least distances up to date with those between all rows and the columns from begin to end.

    Columns begin and end with whole vectors.
    """
    of_rows, of_columns, groups, lanes = least
    farthest = spread(LARGEST)
    for column in range(begin, end, WIDTH):
        there = points_from(second, column)
        of_column, group = load(of_columns, column), load(groups, column)
        for start in range(0, n1, WIDTH):
            before = of_column
            for k in range(start, min(start + WIDTH, n1)):
                squared = squared_distances(there, point(first, k), spherical)
                of_column = minimum(squared, of_column)
                of_row = load(lanes, k * WIDTH) if column > begin else farthest
                store(lanes, k * WIDTH, minimum(squared, of_row))
            group = where_less(of_column, before, spread(np.int32(start)), group)
        store(of_columns, column, of_column)
        store(groups, column, group)
    for k in range(n1):
        of_rows[k] = min(of_rows[k], least_lane(load(lanes, k * WIDTH)))


@inlined
def mutually_nearest(
    first: np.ndarray,
    n1: int,
    second: np.ndarray,
    n2: int,
    spherical: bool,
    least_pairs: int,
    least: Least,
    pairs: Pairs,
) -> int:
    """Pair the points that are each other's nearest; write them to ``pairs`` and return their number.

    Each point is in one pair at most: of equally near points one is taken, always the same.

    Where there cannot be ``least_pairs``, the search is given up and a lower number returned; ``pairs`` means nothing.
    """
    forget(least)
    # When all rows have seen the early columns, their nearest are known; only rows may still find nearer ones. So there
    # are no more pairs than are listed now and columns to come. Half as many as pairs: few triplets go on without hope.
    early = padded(n2 - least_pairs // 2)
    if n2 - early < WIDTH:
        early = padded(n2)
    compare(first, n1, second, 0, early, spherical, least)
    n = shortlist(min(early, n2), least, pairs)
    if early < n2 and n + n2 - early >= least_pairs:
        compare(first, n1, second, early, padded(n2), spherical, least)
        n = shortlist(n2, least, pairs)
    if n >= least_pairs:
        n = collect(n, first, second, spherical, least, pairs)
    return n


@jit
def shortlist(n2: int, least: Least, pairs: Pairs) -> int:
    """Write the columns that have a row as near as their nearest in its group; return how many, no fewer than pairs.

    There is no branch, as it would be foretold wrongly for most of them.
    """
    n = 0
    for j in range(n2):
        pairs.columns[n] = j
        n += any_equal(load(least.of_rows, least.groups[j]), spread(least.of_columns[j]))
    return n


@jit
def collect(n_listed: int, first: np.ndarray, second: np.ndarray, spherical: bool, least: Least, pairs: Pairs) -> int:
    """Of the columns on the list write those that are the nearest of their nearest row; return their number."""
    of_rows, of_columns, groups, _ = least
    n = 0
    for i in range(n_listed):
        j = pairs.columns[i]
        group, nearest = groups[j], of_columns[j]
        squared = squared_distances(points_from(first, group), point(second, j), spherical)
        k = group + first_equal(squared, spread(nearest))
        if of_rows[k] == nearest:
            pairs.rows[n], pairs.columns[n], pairs.squared[n] = k, j, np.int32(nearest).view(np.float32)
            of_rows[k] = -1  # taken
            n += 1
    return n
