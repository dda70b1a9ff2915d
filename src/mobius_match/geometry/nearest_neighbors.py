"""Exact nearest neighbours among rows with many columns, such as positions with normals and eigenfunctions.

Rows are divided into leaves, groups that are close in the leading columns, which should be those that vary most. A leaf
whose bounding box in these columns is farther away than the nearest row so far is skipped; the rows of all others are
compared together, some columns at a time, as long as one of them may still be the nearest.

Which search is for what:

- this one: rows with more than three columns. scipy's cKDTree takes 5 to 7 times as long for the nearest of 5,000 rows
  of 60 eigenfunctions of one pose among those of another (one thread), and as long where each query is close to a row;
  the full matrix of distances takes about as long as the former. Equal distances give the lowest row, in every order.
- scipy's cKDTree: points in space, radii, several neighbours.
- :func:`.interpolation.squared_distances`: the full matrix between few points in space.
- :mod:`mobius_match.voting.nearest`: points in the plane inside the voting kernel, which has no time to build a tree.
- :func:`.geodesics.nearest_centres`: nearest along the edges of a mesh.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

LEADING = 6
"""Number of leading columns."""

WIDTH = 24
"""Rows of a leaf: a multiple of the width of vector instructions."""

STRIDE = 8
"""Number of columns that are compared before a leaf is tested again."""

SLACK = np.float32(1 - 1e-5)
"""Bounds are lowered by this factor, as they and squared distances are rounded."""


class NearestNeighbors:
    """Searches the nearest of rows (n, k).

    Parameters
    ----------
    rows
        (n, k) float, n > 0.
    order
        (L, WIDTH) int64, the rows of each leaf, from :func:`spatial_order` of these or similar rows; the time depends
        on it, the result does not.
    """

    def __init__(self, rows: np.ndarray, order: np.ndarray | None = None) -> None:
        # Relative to the mean, single precision is enough.
        self._mean = rows.mean(axis=0)
        rows = _single(rows - self._mean)
        leading = min(LEADING, rows.shape[1])
        self._order = spatial_order(rows[:, :leading]) if order is None else order
        blocks = np.zeros((len(self._order), _strides(rows), WIDTH), np.float32)
        self._low, self._high = np.empty((2, leading, len(blocks)), np.float32)
        _pack(rows, self._order, blocks, self._low, self._high)
        self._blocks = blocks

    def nearest(self, queries: np.ndarray) -> np.ndarray:
        """Number of the nearest row to each of ``queries`` (p, k), (p,) int64; the lowest of equally near ones."""
        nearest = np.empty(len(queries), np.int64)
        padded = np.zeros((len(queries), self._blocks.shape[1]), np.float32)
        padded[:, : queries.shape[1]] = queries - self._mean
        _search(padded, self._order, self._blocks, self._low, self._high, nearest)
        return nearest


def nearest_neighbors(queries: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Number of the nearest of ``rows`` (n, k) to each of ``queries`` (p, k), (p,) int64; the lowest if equal."""
    return NearestNeighbors(rows).nearest(queries)


def spatial_order(points: np.ndarray) -> np.ndarray:
    """Points (n, d) in groups of close ones, (L, WIDTH) int64; the last group repeats one of its points."""
    order = np.arange(-(-len(points) // WIDTH) * WIDTH)
    order[len(points) :] = len(points) - 1
    _halve(_single(points), order)
    return order.reshape(-1, WIDTH)


def _single(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)


def _strides(rows: np.ndarray) -> int:
    return -(-rows.shape[1] // STRIDE) * STRIDE


@jit
def _halve(points: np.ndarray, order: np.ndarray) -> None:
    """Divide the points recursively at the median of the axis in which they extend farthest, down to leaves."""
    values = np.empty(len(order), np.float32)
    todo = [(0, len(order))]
    while todo:
        begin, end = todo.pop()
        n_leaves = (end - begin) // WIDTH
        if n_leaves < 2:
            continue
        axis, extent = 0, np.float32(-1)
        for candidate in range(points.shape[1]):
            low = high = points[order[begin], candidate]
            for place in range(begin, end):
                x = points[order[place], candidate]
                low, high = min(low, x), max(high, x)
            if high - low > extent:
                axis, extent = candidate, high - low
        for place in range(begin, end):
            values[place] = points[order[place], axis]
        middle = begin + n_leaves // 2 * WIDTH
        _select(values, order, begin, end, middle)
        todo.append((begin, middle))
        todo.append((middle, end))


@jit
def _select(values: np.ndarray, order: np.ndarray, begin: int, end: int, middle: int) -> None:
    """Exchange values until none from begin to middle is greater than one from middle to end (Hoare's quickselect)."""
    low, high = begin, end - 1
    while low < high:
        pivot = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@jit
def _pack(rows: np.ndarray, order: np.ndarray, blocks: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    """Write the rows of each leaf column by column, and the leaves' boxes in the leading columns."""
    for leaf in range(len(order)):
        for place in range(WIDTH):
            row = rows[order[leaf, place]]
            for column in range(len(row)):
                blocks[leaf, column, place] = row[column]
        for column in range(len(low)):
            low[column, leaf], high[column, leaf] = blocks[leaf, column].min(), blocks[leaf, column].max()


@jit
def _search(
    queries: np.ndarray,
    order: np.ndarray,
    blocks: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    result: np.ndarray,
) -> None:
    """Write the number of the nearest row for each query."""
    bounds, squares, zero = np.empty(len(blocks), np.float32), np.empty(WIDTH, np.float32), np.float32(0)
    bits = bounds.view(np.int32)  # floats that are not negative have the order of their bits; see voting/nearest.py
    for i in range(len(queries)):
        query = queries[i]
        bounds[:] = zero
        for column in range(len(low)):
            x = query[column]
            for leaf in range(len(bounds)):
                apart = max(max(low[column, leaf] - x, x - high[column, leaf]), zero)
                bounds[leaf] += apart * apart
        least = np.int32(0x7F7FFFFF)
        for leaf in range(len(bits)):
            least = min(least, bits[leaf])
        first = 0
        while bits[first] != least:
            first += 1
        number, nearest = _compare(query, order[first], blocks[first], -1, np.float32(np.inf), squares)
        for leaf in range(len(blocks)):
            if bounds[leaf] * SLACK <= nearest and leaf != first:
                number, nearest = _compare(query, order[leaf], blocks[leaf], number, nearest, squares)
        result[i] = number


@jit
def _compare(
    query: np.ndarray, order: np.ndarray, block: np.ndarray, number: int, nearest: float, squares: np.ndarray
) -> tuple[int, float]:
    """The nearest row and its squared distance, among a leaf and the nearest so far."""
    squares[:] = np.float32(0)
    for start in range(0, len(block), STRIDE):
        some = block[start : start + STRIDE]
        a, b, c, d = query[start], query[start + 1], query[start + 2], query[start + 3]
        e, f, g, h = query[start + 4], query[start + 5], query[start + 6], query[start + 7]
        near = False
        for place in range(WIDTH):
            first = (some[0, place] - a) ** 2 + (some[1, place] - b) ** 2
            second = (some[2, place] - c) ** 2 + (some[3, place] - d) ** 2
            third = (some[4, place] - e) ** 2 + (some[5, place] - f) ** 2
            fourth = (some[6, place] - g) ** 2 + (some[7, place] - h) ** 2
            squares[place] += (first + second) + (third + fourth)
        for place in range(WIDTH):
            near |= squares[place] <= nearest
        if not near:
            return number, nearest
    for place in range(WIDTH):
        if squares[place] < nearest or (squares[place] == nearest and order[place] < number):
            number, nearest = order[place], squares[place]
    return number, nearest
