"""Factors L D L' of sparse matrices that share one pattern: the order of elimination is worked out once.

All that a surface's preparation solves (heat, eigenfunctions, smoothing, the flattening) has the pattern of its
Laplacian. The factors are simplicial, row by row along the elimination tree (Davis 2006, chapter 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from .._core.compiling import jit

SMALLEST = 1e-30
"""Stands for a pivot of zero."""


@dataclass(frozen=True, eq=False)
class Factors:
    """L by columns, each with D's entry in the place of its diagonal, of a matrix whose rows are in another order."""

    order: np.ndarray
    start: np.ndarray
    rows: np.ndarray
    values: np.ndarray

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution (n,) for a right-hand side (n,), or (n, c) for several."""
        columns = np.array(right.T, np.float64, ndmin=2, order="C")
        out = np.empty_like(columns)
        for column, found in zip(columns, out, strict=True):
            _solve(self.order, self.start, self.rows, self.values, column, found)
        return out.T.reshape(right.shape)


class Pattern:
    """The pattern of symmetric matrices, analysed.

    Parameters
    ----------
    matrix
        (n, n) one of them, in canonical form, diagonals included. Zeros may be entries.
    masses
        (n,) what makes it positive definite if added to the diagonal.
    """

    def __init__(self, matrix: sp.csr_matrix, masses: np.ndarray) -> None:
        n = len(masses)
        self._diagonal = np.flatnonzero(matrix.indices == np.repeat(np.arange(n), np.diff(matrix.indptr)))
        matrix = matrix.copy()
        matrix.data[self._diagonal] += masses
        # SuperLU's minimum degree ordering; its own factors are not needed. On meshes that are numbered regularly the
        # ordering takes many times as long; shuffled it does not.
        shuffled, options = np.random.default_rng(0).permutation(n), {"SymmetricMode": True}
        some = matrix[shuffled][:, shuffled].tocsc()
        factors = spla.splu(some, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        self._order = np.empty(n, np.int64)
        self._order[shuffled] = factors.perm_c
        self._columns, self._rows, self._source = _upper(matrix.indptr, matrix.indices, self._order)
        self._parent, counts = _tree(self._columns, self._rows)
        self._start = np.concatenate([[0], np.cumsum(counts)])

    def factors(self, data: np.ndarray, diagonal: np.ndarray | float = 0.0) -> Factors:
        """Factors of the matrix with these entries (nnz,) in the order of the pattern, and more on the diagonal."""
        data = data.copy()
        data[self._diagonal] += diagonal
        rows, values = np.empty(self._start[-1], np.int32), np.empty(self._start[-1])
        _factor(self._columns, self._rows, data[self._source], self._parent, self._start, rows, values)
        return Factors(self._order, self._start, rows, values)


@jit
def _upper(indptr: np.ndarray, indices: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The upper triangle by columns in the new order: starts, rows, and where in the data each entry comes from."""
    n = len(order)
    start = np.zeros(n + 1, np.int64)
    for row in range(n):
        for place in range(indptr[row], indptr[row + 1]):
            if order[row] <= order[indices[place]]:
                start[order[indices[place]] + 1] += 1
    for i in range(n):
        start[i + 1] += start[i]
    rows, source = np.empty(start[n], np.int32), np.empty(start[n], np.int32)
    fill = start[:n].copy()
    for row in range(n):
        for place in range(indptr[row], indptr[row + 1]):
            column = order[indices[place]]
            if order[row] <= column:
                rows[fill[column]], source[fill[column]] = order[row], place
                fill[column] += 1
    return start, rows, source


@jit
def _tree(columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The elimination tree, and how many entries each column of L has."""
    n = len(columns) - 1
    parent, ancestor = np.full(n, -1), np.full(n, -1)
    for k in range(n):
        for place in range(columns[k], columns[k + 1]):
            i = rows[place]
            while i != -1 and i < k:
                following = ancestor[i]
                ancestor[i] = k
                if following == -1:
                    parent[i] = k
                i = following
    counts, mark = np.ones(n, np.int64), np.full(n, -1)
    for k in range(n):
        mark[k] = k
        for place in range(columns[k], columns[k + 1]):
            i = rows[place]
            while mark[i] != k:
                mark[i] = k
                counts[i] += 1
                i = parent[i]
    return parent, counts


@jit
def _factor(
    columns: np.ndarray,
    rows_of_matrix: np.ndarray,
    matrix: np.ndarray,
    parent: np.ndarray,
    start: np.ndarray,
    rows: np.ndarray,
    values: np.ndarray,
) -> None:
    """Write L row by row, and D."""
    n = len(parent)
    fill, work, mark = start[:n].copy(), np.zeros(n), np.full(n, -1)
    stack, path = np.empty(n, np.int64), np.empty(n, np.int64)
    for k in range(n):
        mark[k] = k
        top = n
        for place in range(columns[k], columns[k + 1]):
            i = rows_of_matrix[place]
            work[i] += matrix[place]
            length = 0
            while mark[i] != k:
                path[length] = i
                length += 1
                mark[i] = k
                i = parent[i]
            while length > 0:
                top -= 1
                length -= 1
                stack[top] = path[length]
        pivot = work[k]
        work[k] = 0.0
        for at in range(top, n):
            i = stack[at]
            found = work[i]
            entry = found / values[start[i]]
            work[i] = 0.0
            for place in range(start[i] + 1, fill[i]):
                work[rows[place]] -= values[place] * found
            pivot -= entry * found
            rows[fill[i]], values[fill[i]] = k, entry
            fill[i] += 1
        rows[fill[k]], values[fill[k]] = k, pivot if pivot != 0.0 else SMALLEST
        fill[k] += 1


@jit
def _solve(
    order: np.ndarray, start: np.ndarray, rows: np.ndarray, values: np.ndarray, right: np.ndarray, out: np.ndarray
) -> None:
    n = len(order)
    work = np.empty(n)
    for i in range(n):
        work[order[i]] = right[i]
    for j in range(n):
        found = work[j]
        if found != 0.0:  # nothing spreads from most columns where there is but one source
            for place in range(start[j] + 1, start[j + 1]):
                work[rows[place]] -= values[place] * found
        work[j] = found / values[start[j]]
    for j in range(n - 1, -1, -1):
        # Two sums at once: each addition waits for the one before.
        one, two = 0.0, 0.0
        place = start[j] + 1
        while place + 1 < start[j + 1]:
            one += values[place] * work[rows[place]]
            two += values[place + 1] * work[rows[place + 1]]
            place += 2
        if place < start[j + 1]:
            one += values[place] * work[rows[place]]
        work[j] -= one + two
    for i in range(n):
        out[i] = work[order[i]]
