"""Algorithm 2 without any thought for speed: what the voting kernel is measured against.

:func:`vote` stands for the public implementations: complex numbers, double loops, float64, compiled. :func:`vote_numpy`
is the same in whole arrays. Points are finite complex numbers; the triplets are those of the kernel.
"""

from __future__ import annotations

import numba
import numpy as np

from mobius_match.voting.mobius import CANONICAL_TRIANGLE

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)
TO_TRIANGLE = np.linalg.inv(np.array([[Y2 - Y3, Y1 * Y3 - Y1 * Y2], [Y2 - Y1, Y1 * Y3 - Y3 * Y2]]))


@numba.njit(cache=True, nogil=True, error_model="numpy")
def transformation(z1: complex, z2: complex, z3: complex) -> tuple[complex, complex, complex, complex]:
    """Equation 4: a, b, c, d of the map that takes the three points to the canonical triangle."""
    a, b, c, d = z2 - z3, z1 * z3 - z1 * z2, z2 - z1, z1 * z3 - z3 * z2
    ya, yb, yc, yd = TO_TRIANGLE[0, 0], TO_TRIANGLE[0, 1], TO_TRIANGLE[1, 0], TO_TRIANGLE[1, 1]
    return ya * a + yb * c, ya * b + yb * d, yc * a + yd * c, yc * b + yd * d


@numba.njit(cache=True, nogil=True, error_model="numpy")
def vote(
    points1: np.ndarray,
    points2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    epsilon: float,
    votes: np.ndarray,
) -> int:
    """Algorithm 2 on complex points (N1,) and (N2,); adds to ``votes`` and returns how many triplets voted."""
    n1, n2 = len(points1), len(points2)
    z, w = np.empty(n1, np.complex128), np.empty(n2, np.complex128)
    nearest1, nearest2 = np.empty(n1, np.int64), np.empty(n2, np.int64)
    least2 = np.empty(n2)
    n_voting = 0
    for i in range(len(triplets1)):
        a, b, c, d = transformation(points1[triplets1[i, 0]], points1[triplets1[i, 1]], points1[triplets1[i, 2]])
        for k in range(n1):
            z[k] = (a * points1[k] + b) / (c * points1[k] + d)
        a, b, c, d = transformation(points2[triplets2[i, 0]], points2[triplets2[i, 1]], points2[triplets2[i, 2]])
        for j in range(n2):
            w[j] = (a * points2[j] + b) / (c * points2[j] + d)
        least2[:] = np.inf
        for k in range(n1):
            least1 = np.inf
            for j in range(n2):
                difference = z[k] - w[j]
                squared = difference.real**2 + difference.imag**2
                if squared < least1:
                    least1, nearest1[k] = squared, j
                if squared < least2[j]:
                    least2[j], nearest2[j] = squared, k
        n, energy = 0, 0.0
        for k in range(n1):
            if nearest2[nearest1[k]] == k:
                n += 1
                energy += abs(z[k] - w[nearest1[k]])
        if n >= least_pairs:
            n_voting += 1
            for k in range(n1):
                if nearest2[nearest1[k]] == k:
                    votes[k, nearest1[k]] += 1 / (epsilon + energy / n)
    return n_voting


def vote_numpy(
    points1: np.ndarray,
    points2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    epsilon: float,
    votes: np.ndarray,
) -> int:
    """The same, a triplet at a time in whole arrays."""
    n_voting = 0
    for triplet1, triplet2 in zip(triplets1, triplets2, strict=True):
        a, b, c, d = transformation.py_func(*points1[triplet1])
        z = (a * points1 + b) / (c * points1 + d)
        a, b, c, d = transformation.py_func(*points2[triplet2])
        w = (a * points2 + b) / (c * points2 + d)
        distances = np.abs(z[:, None] - w)
        nearest = distances.argmin(axis=1)
        paired = np.flatnonzero(distances.argmin(axis=0)[nearest] == np.arange(len(z)))
        if len(paired) >= least_pairs:
            n_voting += 1
            energy = distances[paired, nearest[paired]].mean()
            votes[paired, nearest[paired]] += 1 / (epsilon + energy)
    return n_voting
