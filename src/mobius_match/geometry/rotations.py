"""Nearest rotations to many 3 x 3 matrices, from quaternions (Horn 1987): their polar decompositions."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

ITERATIONS = 50
"""Largest number of Newton steps to the largest eigenvalue; about seven are usual."""


def nearest_rotations(matrices: np.ndarray) -> np.ndarray:
    """The rotation R nearest to each matrix A, which maximises the trace of R^T A.

    Parameters
    ----------
    matrices
        (n, 3, 3) float64.

    Returns
    -------
    numpy.ndarray
        (n, 3, 3) float64 of determinant 1; the identity where the nearest rotation is not unique.
    """
    found = np.empty((len(matrices), 3, 3))
    _nearest_rotations(np.ascontiguousarray(matrices, np.float64), found)
    return found


def rigid_residual(first: np.ndarray, second: np.ndarray) -> float:
    """Share, 0 to 1, of the variance of points (n, 3) that no rotation, scale and shift of other points explains."""
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    left, sizes, right = np.linalg.svd(first.T @ second)
    sizes[2] *= np.sign(np.linalg.det(left @ right))  # a reflection is no motion
    explained = max(sizes.sum(), 0.0) ** 2 / max((first**2).sum() * (second**2).sum(), np.finfo(float).tiny)
    return float(max(1 - explained, 0.0))  # round-off can explain too much


@jit
def _nearest_rotations(matrices: np.ndarray, found: np.ndarray) -> None:
    """Write the rotations."""
    k, cofactors = np.empty((4, 4)), np.empty(4)
    for i in range(len(matrices)):
        a = matrices[i]
        size = 0.0
        for row in range(3):
            for column in range(3):
                size += a[row, column] ** 2
        size = np.sqrt(size)
        found[i] = np.eye(3)
        if not size > 0.0:
            continue
        _fill_quaternion_matrix(a, size, k)
        largest = _largest_eigenvalue(k)
        for row in range(4):
            k[row, row] -= largest
        # Any column of the adjugate that is not zero is the eigenvector.
        best, length = -1, 1e-7
        for column in range(4):
            _cofactors(k, column, cofactors)
            norm = np.sqrt((cofactors**2).sum())
            if norm > length:
                best, length = column, norm
        if best < 0:
            continue
        _cofactors(k, best, cofactors)
        w, x, y, z = cofactors / length
        found[i, 0] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        found[i, 1] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        found[i, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@jit
def largest_trace(matrix: np.ndarray) -> float:
    """The largest trace of R^T A over all rotations R, for one matrix A (3, 3)."""
    size = np.sqrt((matrix**2).sum())
    if not size > 0.0:
        return 0.0
    k = np.empty((4, 4))
    _fill_quaternion_matrix(matrix, size, k)
    return _largest_eigenvalue(k) * size


@jit
def _fill_quaternion_matrix(a: np.ndarray, size: float, k: np.ndarray) -> None:
    """Write the symmetric matrix K (4, 4) of a matrix A (3, 3), divided by a size."""
    # The unit quaternion q of the rotation maximises q^T K q.
    k[0, 0] = (a[0, 0] + a[1, 1] + a[2, 2]) / size
    k[1, 1] = (a[0, 0] - a[1, 1] - a[2, 2]) / size
    k[2, 2] = (a[1, 1] - a[0, 0] - a[2, 2]) / size
    k[3, 3] = (a[2, 2] - a[0, 0] - a[1, 1]) / size
    k[0, 1] = k[1, 0] = (a[2, 1] - a[1, 2]) / size
    k[0, 2] = k[2, 0] = (a[0, 2] - a[2, 0]) / size
    k[0, 3] = k[3, 0] = (a[1, 0] - a[0, 1]) / size
    k[1, 2] = k[2, 1] = (a[0, 1] + a[1, 0]) / size
    k[1, 3] = k[3, 1] = (a[0, 2] + a[2, 0]) / size
    k[2, 3] = k[3, 2] = (a[1, 2] + a[2, 1]) / size


@jit
def _largest_eigenvalue(k: np.ndarray) -> float:
    """Largest eigenvalue of a symmetric matrix (4, 4) of trace 0, by Newton's method from above."""
    square, cube = 0.0, 0.0
    for i in range(4):
        for j in range(4):
            square += k[i, j] * k[j, i]
            for m in range(4):
                cube += k[i, j] * k[j, m] * k[m, i]
    quadratic, linear = -square / 2, -cube / 3
    constant = 0.0
    cofactors = np.empty(4)
    _cofactors(k, 0, cofactors)
    for j in range(4):
        constant += k[j, 0] * cofactors[j]
    value = np.sqrt(3.0) + 1e-9  # singular values of a matrix of Frobenius norm 1 sum to no more
    for _ in range(ITERATIONS):
        polynomial = ((value * value + quadratic) * value + linear) * value + constant
        slope = (4 * value * value + 2 * quadratic) * value + linear
        if not slope > 0.0:
            break
        step = polynomial / slope
        value -= step
        if abs(step) < 1e-14:
            break
    return value


@jit
def _cofactors(k: np.ndarray, column: int, found: np.ndarray) -> None:
    """Write the cofactors (4,) of one column."""
    c0, c1, c2 = (1 if column == 0 else 0), (2 if column <= 1 else 1), (2 if column == 3 else 3)
    for row in range(4):
        r0, r1, r2 = (1 if row == 0 else 0), (2 if row <= 1 else 1), (2 if row == 3 else 3)
        minor = (
            k[r0, c0] * (k[r1, c1] * k[r2, c2] - k[r1, c2] * k[r2, c1])
            - k[r0, c1] * (k[r1, c0] * k[r2, c2] - k[r1, c2] * k[r2, c0])
            + k[r0, c2] * (k[r1, c0] * k[r2, c1] - k[r1, c1] * k[r2, c0])
        )
        found[row] = minor if (row + column) % 2 == 0 else -minor
