"""Section 6, the Möbius group: fractional linear maps of the extended complex plane, equations 3 and 4.

A map m(z) = (a z + b) / (c z + d) is the matrix [[a, b], [c, d]]; composition is the product of matrices. Infinity is
a point like others: every function accepts and returns it as ``complex("inf")``.
"""

from __future__ import annotations

import numpy as np

INFINITY = complex(float("inf"), 0.0)

CANONICAL_TRIANGLE = np.exp(2j * np.pi * np.arange(1, 4) / 3)
"""The equilateral triangle y_j = exp(2 pi i j / 3) to which all triplets are mapped."""


def homogeneous(points: np.ndarray) -> np.ndarray:
    """Points (p,) of the extended plane as pairs (p, 2): z is (z, 1), infinity is (1, 0)."""
    points = np.asarray(points, np.complex128)
    infinite = ~np.isfinite(points)
    return np.stack([np.where(infinite, 1.0, points), np.where(infinite, 0.0, 1.0)], axis=-1)


def to_zero_one_infinity(points: np.ndarray) -> np.ndarray:
    """The map (2, 2) of three distinct points (3,) to 0, 1 and infinity, in this order.

    Raises
    ------
    ValueError
        If two of the points are equal.
    """
    p = homogeneous(points)
    # In homogeneous coordinates a difference z_i - z_j is the determinant of both, and the matrix of equation 4
    # holds for infinity without a special case.
    (p1, q1), (p2, q2), (p3, q3) = p
    d12, d23, d31 = p1 * q2 - p2 * q1, p2 * q3 - p3 * q2, p3 * q1 - p1 * q3
    if d12 == 0 or d23 == 0 or d31 == 0:
        raise ValueError(f"a Möbius transformation needs three distinct points, got {list(points)}")
    return np.array([[d23 * q1, -d23 * p1], [-d12 * q3, d12 * p3]])


def from_three_points(sources: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """The unique map (2, 2) of three distinct points to three distinct points, equation 4.

    Parameters
    ----------
    sources, targets
        (3,) complex; infinity allowed.
    """
    return compose(inverse(to_zero_one_infinity(targets)), to_zero_one_infinity(sources))


def compose(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The map that applies ``first`` and then ``second``, scaled to a largest coefficient of 1."""
    product = second @ first
    return product / np.abs(product).max()


def inverse(transformation: np.ndarray) -> np.ndarray:
    """The inverse map: the adjugate, since a factor does not matter."""
    (a, b), (c, d) = transformation
    return np.array([[d, -b], [-c, a]])


def apply(transformation: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Images of points, equation 3, in the same shape; infinity may be among both."""
    images = homogeneous(points) @ np.asarray(transformation).T
    infinite = images[..., 1] == 0
    quotient = images[..., 0] / np.where(infinite, 1.0, images[..., 1])
    # The division may overflow next to the pole: that is infinity too.
    return np.where(infinite | ~np.isfinite(quotient), INFINITY, quotient)


def cross_ratio(z0: complex, z1: complex, z2: complex, z3: complex) -> complex:
    """The image of z0 under the map that takes z1, z2, z3 to 0, 1, infinity: the invariant of Möbius maps."""
    return complex(apply(to_zero_one_infinity(np.array([z1, z2, z3])), np.array(z0)))
