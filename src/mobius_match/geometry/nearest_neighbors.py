"""The nearest of many rows of numbers, exactly, without looking at most of them.

Rows are cut into leaves, groups that lie together in the first few columns, which are to be those that vary most. A
leaf whose box is farther away there than the nearest row so far is passed over; of the others all rows are compared at
once, column by column, as long as one of them may still be the nearest.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

LEADING = 6
"""Columns that leaves lie together in."""

WIDTH = 24
"""Rows of a leaf: whole vector instructions."""

STRIDE = 8
"""Columns that are compared between two looks at whether a leaf is still of interest."""

SLACK = np.float32(1 - 1e-5)
"""Bounds are lowered by this factor: they are rounded, as squared distances are."""


class NearestNeighbors:
    """Rows (n, k) to find the nearest among.

    Parameters
    ----------
    rows
        (n, k) float, n > 0.
    order
        (L, WIDTH) int64, rows that lie together, as :func:`spatial_order` gives them for rows like these; the time
        depends on it, the result does not.
    """

    def __init__(self, rows: np.ndarray, order: np.ndarray | None = None) -> None:
        # Single precision is enough about the middle.
        self._middle = rows.mean(axis=0)
        rows = _single(rows - self._middle)
        leading = min(LEADING, rows.shape[1])
        self._order = spatial_order(rows[:, :leading]) if order is None else order
        blocks = np.zeros((len(self._order), _strides(rows), WIDTH), np.float32)
        self._low, self._high = np.empty((2, leading, len(blocks)), np.float32)
        _pack(rows, self._order, blocks, self._low, self._high)
        self._blocks = blocks

    def nearest(self, queries: np.ndarray) -> np.ndarray:
        """Number of the nearest row to each of ``queries`` (p, k), (p,) int64; the lowest of equal ones."""
        found = np.empty(len(queries), np.int64)
        asked = np.zeros((len(queries), self._blocks.shape[1]), np.float32)
        asked[:, : queries.shape[1]] = queries - self._middle
        _search(asked, self._order, self._blocks, self._low, self._high, found)
        return found


def nearest_neighbors(queries: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Number of the nearest of ``rows`` (n, k) to each of ``queries`` (p, k), (p,) int64; the lowest of equal ones."""
    return NearestNeighbors(rows).nearest(queries)


def spatial_order(points: np.ndarray) -> np.ndarray:
    """Points (n, d) in groups that lie together, (L, WIDTH) int64; the last is filled up with one of its own."""
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
    """Halve again and again, each part along the axis in which it is longest, down to leaves."""
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
    """Exchange until no value from begin to middle is greater than one from middle to end (Hoare's quickselect)."""
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
    """Write the rows leaf by leaf and there column by column, and the leaves' boxes in the leading columns."""
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
    found: np.ndarray,
) -> None:
    """Write the number of the nearest row for each query."""
    bounds, squares, zero = np.empty(len(blocks), np.float32), np.empty(WIDTH, np.float32), np.float32(0)
    bits = bounds.view(np.int32)  # order as the numbers do, which are not negative; see voting/nearest.py
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
        found[i] = number


@jit
def _compare(
    query: np.ndarray, order: np.ndarray, block: np.ndarray, number: int, nearest: float, squares: np.ndarray
) -> tuple[int, float]:
    """The nearest row and its squared distance, of a leaf and the nearest so far."""
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
