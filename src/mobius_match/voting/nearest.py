"""Section 6, "Find mutually nearest-neighbors": the line of Algorithm 2 that takes most of the time.

All points of one set are compared with all points of the other; :mod:`mobius_match.voting.sweep` is for many points.

Points are the columns of float32 arrays (3, padded): two coordinates in the plane, three on the sphere. The columns
after the last point repeat it, which changes no minimum and fills whole vector instructions. Points of the first set
are called rows here and those of the second set columns, after the matrix of their distances, which is never stored.

Distances are squared and kept as the bits of their float32. They are not negative, so the bits order as the numbers do;
the compiler turns minima of integers into single vector instructions, but not minima of floats.

numba keeps compiled callers when a function in another file changes: delete ``__pycache__`` after changes here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._core.compiling import inlined, jit

BLOCK = 8
"""Arrays of points are padded to a multiple of this: a vector of float32 with AVX, two with SSE or NEON."""

GROUP = 4
"""Rows that :func:`compare` takes at once, so that it loads a column and its minimum once for all of them."""

FARTHEST = np.finfo(np.float32).max.view(np.int32)
"""The bits of a distance greater than any other."""


class Minima(NamedTuple):
    """Least squared distances found so far, as bits: of each row and of each column.

    ``groups`` holds the first row of the group in which the nearest row of each column is. Which of the group it is
    matters for few columns; :func:`collect` finds out.
    """

    rows: np.ndarray
    columns: np.ndarray
    groups: np.ndarray


class Pairs(NamedTuple):
    """Mutually nearest pairs, triplet by triplet.

    Those of triplet i are the points ``rows[i]`` and ``columns[i]`` at the squared distances ``squared[i]``, the first
    ``counts[i]`` of each. The count is -1 where the triplet has no transformation.
    """

    counts: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    squared: np.ndarray


def padded(n: int) -> int:
    """Number of columns of an array for n points."""
    return -(-n // BLOCK) * BLOCK


def empty_minima(n1: int, n2: int) -> Minima:
    """Arrays for n1 rows and n2 columns."""
    # Unsigned indices here and in the pairs: numba then has no negative ones to look for.
    return Minima(np.empty(padded(n1), np.int32), np.empty(padded(n2), np.int32), np.zeros(padded(n2), np.uint32))


def empty_pairs(n_triplets: int, n2: int) -> Pairs:
    """Arrays for the pairs of some triplets; no triplet has more pairs than there are columns."""
    rows, columns = np.empty((2, n_triplets, n2), np.uint32)
    return Pairs(np.empty(n_triplets, np.int64), rows, columns, np.empty((n_triplets, n2), np.float32))


@jit
def reset(minima: Minima) -> None:
    """Forget all distances."""
    minima.rows[:] = FARTHEST
    minima.columns[:] = FARTHEST


@jit
def point(points: np.ndarray, k: int) -> tuple[float, float, float]:
    """The coordinates of point k."""
    return points[0, k], points[1, k], points[2, k]


@jit
def squared_distance(p: tuple[float, float, float], q: tuple[float, float, float], spherical: bool) -> np.int32:
    """Squared distance of two points, as the bits of a float32."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    square = dx * dx + dy * dy
    if spherical:
        dz = q[2] - p[2]
        square += dz * dz
    return np.float32(square).view(np.int32)


@inlined
def compare(
    first: np.ndarray, k: int, second: np.ndarray, begin: int, end: int, spherical: bool, minima: Minima
) -> None:
    """Update the minima with the distances between the group of rows from k on and the columns from begin to end."""
    of_rows, of_columns, groups = minima
    # Unsigned indices: numba would look for negative ones, which keeps the loop from being vectorised.
    group, k0, k1, k2, k3 = np.uint32(k), np.uint64(k), np.uint64(k + 1), np.uint64(k + 2), np.uint64(k + 3)
    p0, p1, p2, p3 = point(first, k0), point(first, k1), point(first, k2), point(first, k3)
    least0, least1, least2, least3 = of_rows[k0], of_rows[k1], of_rows[k2], of_rows[k3]
    for j in range(np.uint64(begin), np.uint64(end)):
        q = point(second, j)
        squared0, squared1 = squared_distance(p0, q, spherical), squared_distance(p1, q, spherical)
        squared2, squared3 = squared_distance(p2, q, spherical), squared_distance(p3, q, spherical)
        least0, least1 = min(least0, squared0), min(least1, squared1)
        least2, least3 = min(least2, squared2), min(least3, squared3)
        nearest = min(min(squared0, squared1), min(squared2, squared3))
        groups[j] = group if nearest < of_columns[j] else groups[j]
        of_columns[j] = min(nearest, of_columns[j])
    of_rows[k0], of_rows[k1], of_rows[k2], of_rows[k3] = least0, least1, least2, least3


@jit
def mutually_nearest(
    first: np.ndarray,
    n1: int,
    second: np.ndarray,
    n2: int,
    spherical: bool,
    least_pairs: int,
    minima: Minima,
    pairs: Pairs,
    i: int,
) -> None:
    """Pair the points that are each other's nearest: the pairs of triplet i.

    Each point is in one pair at most: of equally near points one is taken, always the same.

    Where there cannot be ``least_pairs`` of them, the search is given up. A lower count is left, and no pairs.
    """
    reset(minima)
    # All rows are compared with the early columns first. Then the nearest rows of these are known, so that there are
    # no more pairs than early columns on the shortlist and late columns. Half as many columns are late as pairs are
    # asked for: of the triplets that go on, few go on in vain.
    n_columns = second.shape[1]
    early = min(-(-(n2 - least_pairs // 2) // BLOCK) * BLOCK, n_columns)
    begin, end, n = 0, early, 0
    while begin < end:
        for k in range(0, n1, GROUP):
            compare(first, k, second, begin, end, spherical, minima)
        n = shortlist(min(end, n2), minima, pairs, i)
        begin, end = end, n_columns if n + n2 - end >= least_pairs else end
    if n >= least_pairs:
        n = collect(n, first, second, spherical, minima, pairs, i)
    pairs.counts[i] = n


@jit
def shortlist(n2: int, minima: Minima, pairs: Pairs, i: int) -> int:
    """List the columns whose nearest distance is that of a row in their group, too; return how many.

    There are no fewer of them than pairs. There is no branch, as it would be mispredicted for most columns.
    """
    of_rows, of_columns, groups = minima
    columns = pairs.columns
    n = 0
    for j in range(n2):
        k, nearest = groups[j], of_columns[j]
        columns[i, n] = j
        n += (
            (of_rows[k] == nearest)
            | (of_rows[k + 1] == nearest)
            | (of_rows[k + 2] == nearest)
            | (of_rows[k + 3] == nearest)
        )
    return n


@jit
def collect(
    n_listed: int, first: np.ndarray, second: np.ndarray, spherical: bool, minima: Minima, pairs: Pairs, i: int
) -> int:
    """Keep the listed columns that are the nearest of their nearest row, and write the pairs; return how many."""
    of_rows, of_columns, groups = minima
    _, rows, columns, squared = pairs
    n = 0
    for listed in range(n_listed):
        j = columns[i, listed]
        nearest, row, q = of_columns[j], groups[j], point(second, j)
        for member in range(GROUP - 1, -1, -1):  # the first row at that distance
            k = np.uint32(groups[j] + member)
            row = k if squared_distance(point(first, k), q, spherical) == nearest else row
        mutual = of_rows[row] == nearest
        rows[i, n], columns[i, n], squared[i, n] = row, j, np.int32(nearest).view(np.float32)
        of_rows[row] = -1 if mutual else of_rows[row]  # -1: in a pair now
        n += mutual
    return n
