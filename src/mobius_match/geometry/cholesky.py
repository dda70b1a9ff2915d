"""Sparse symmetric linear systems: factors L D L' of matrices that share one pattern, and of a single matrix.

All linear systems of a surface's preparation (heat, eigenfunctions, smoothing, flattening) have the pattern of its
Laplacian, so the elimination order is computed once per surface (:class:`Pattern`); the factors are simplicial, row by
row along the elimination tree (Davis 2006, chapter 4). Where there is only one matrix, :func:`factorized` keeps the
factors that SuperLU computes along with that order, which takes half the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from .._core.compiling import jit

SMALLEST = 1e-30
"""Replaces a pivot of zero."""


@dataclass(frozen=True, eq=False)
class Factors:
    """L by columns, with D on its diagonal, of a matrix with rows and columns permuted by ``order``."""

    order: np.ndarray
    start: np.ndarray
    rows: np.ndarray
    values: np.ndarray

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution (n,) for a right-hand side (n,), or (n, c) for several."""
        columns = np.array(right.T, np.float64, ndmin=2, order="C")
        out = np.empty_like(columns)
        for column, solution in zip(columns, out, strict=True):
            _solve(self.order, self.start, self.rows, self.values, column, solution)
        return out.T.reshape(right.shape)


class Pattern:
    """Symbolic factorisation of symmetric matrices with the same pattern.

    Parameters
    ----------
    matrix
        (n, n) one of these matrices, in canonical form, with all diagonal entries. Entries may be zero.
    masses
        (n,) added to the diagonal, they make the matrix positive definite.
    """

    def __init__(self, matrix: sp.csr_matrix, masses: np.ndarray) -> None:
        n = len(masses)
        self._diagonal = np.flatnonzero(matrix.indices == np.repeat(np.arange(n), np.diff(matrix.indptr)))
        matrix = matrix.copy()
        matrix.data[self._diagonal] += masses
        try:
            shuffled, factors = _superlu(matrix)  # of which only the order is used
        except RuntimeError:  # a pivot is zero, next to faces without area: any matrix of the pattern has that order
            matrix.data[:] = -1.0
            matrix.data[self._diagonal] = np.diff(matrix.indptr)
            shuffled, factors = _superlu(matrix)
        self._order = np.empty(n, np.int64)
        self._order[shuffled] = factors.perm_c
        self._columns, self._rows, self._source = _upper(matrix.indptr, matrix.indices, self._order)
        self._parent, counts = _tree(self._columns, self._rows)
        self._start = np.concatenate([[0], np.cumsum(counts)])

    def factors(self, data: np.ndarray, diagonal: np.ndarray | float = 0.0) -> Factors:
        """Factors of the matrix with entries ``data`` (nnz,), in the order of the pattern, plus ``diagonal``."""
        data = data.copy()
        data[self._diagonal] += diagonal
        rows, values = np.empty(self._start[-1], np.int32), np.empty(self._start[-1])
        _factor(self._columns, self._rows, data[self._source], self._parent, self._start, rows, values)
        return Factors(self._order, self._start, rows, values)


def factorized(matrix: sp.spmatrix) -> SuperLUFactors:
    """Factors of one symmetric positive definite sparse matrix (n, n)."""
    return SuperLUFactors(*_superlu(matrix.tocsr()))


@dataclass(frozen=True, eq=False)
class SuperLUFactors:
    """Factors of a matrix with rows and columns permuted by ``order``."""

    order: np.ndarray
    factors: spla.SuperLU

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution (n, ...) for right-hand sides (n, ...)."""
        solution = np.empty(right.shape)
        solution[self.order] = self.factors.solve(np.ascontiguousarray(right[self.order], np.float64))
        return solution


def _superlu(matrix: sp.csr_matrix) -> tuple[np.ndarray, spla.SuperLU]:
    """A permutation (n,), and SuperLU's factors of the symmetric matrix permuted by it, in minimum degree order."""
    # On meshes that are numbered regularly, minimum degree does up to 40 times the work; shuffled it does not.
    order = np.random.default_rng(0).permutation(matrix.shape[0])
    shuffled, options = matrix[order][:, order].tocsc(), {"SymmetricMode": True}
    return order, spla.splu(shuffled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)


@jit
def _upper(indptr: np.ndarray, indices: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The permuted upper triangle by columns: starts, rows, and the place of each entry in the original data."""
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
    """The elimination tree, and the number of entries in each column of L."""
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
            value = work[i]
            entry = value / values[start[i]]
            work[i] = 0.0
            for place in range(start[i] + 1, fill[i]):
                work[rows[place]] -= values[place] * value
            pivot -= entry * value
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
        value = work[j]
        if value != 0.0:  # with a single source most columns are skipped
            for place in range(start[j] + 1, start[j + 1]):
                work[rows[place]] -= values[place] * value
        work[j] = value / values[start[j]]
    for j in range(n - 1, -1, -1):
        # Two partial sums: an addition does not wait for the one before.
        even, odd = 0.0, 0.0
        place = start[j] + 1
        while place + 1 < start[j + 1]:
            even += values[place] * work[rows[place]]
            odd += values[place + 1] * work[rows[place + 1]]
            place += 2
        if place < start[j + 1]:
            even += values[place] * work[rows[place]]
        work[j] -= even + odd
    for i in range(n):
        out[i] = work[order[i]]
