"""Section 6, "Random z1, z2, z3": how triplets are drawn, uniformly or guided by geodesic distances."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

ATTEMPTS = 1000
"""Draws of one guided triplet before it is left out: a bound where no triplet fits."""

FAILURES = 100
"""Guided triplets that are left out one after the other before no more are drawn. Where one in ten is found, that
happens once in 40,000."""


def uniform_triplets(generator: np.random.Generator, count: int, n1: int, n2: int) -> tuple[np.ndarray, np.ndarray]:
    """Triplets of three different samples, (count, 3) int64 of each side, all equally likely (the paper's)."""
    return _distinct(generator, count, n1), _distinct(generator, count, n2)


def _distinct(generator: np.random.Generator, count: int, n: int) -> np.ndarray:
    # Draw from n, n - 1 and n - 2 numbers, and skip those already drawn.
    first, second, third = (generator.integers(0, n - taken, count) for taken in range(3))
    second += second >= first
    low, high = np.minimum(first, second), np.maximum(first, second)
    third += third >= low
    third += third >= high
    return np.stack([first, second, third], axis=1)


@jit
def guided_triplets(
    generator: np.random.Generator,
    count: int,
    geodesics1: np.ndarray,
    geodesics2: np.ndarray,
    allowed: np.ndarray,
    least_spread: float,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Triplets that agree in their mutual distances, (found, 3) int64 of each side, found <= count.

    Parameters
    ----------
    generator
        Random stream of this batch.
    count
        Number of triplets.
    geodesics1, geodesics2
        (N1, N1) and (N2, N2) float64, distances between the samples per sqrt(area).
    allowed
        (N1, N2) bool: which samples may be matched.
    least_spread
        Least distance between source samples.
    tolerance
        Largest relative difference of corresponding distances.
    """
    n1, n2 = allowed.shape
    triplets1, triplets2 = np.empty((count, 3), np.int64), np.empty((count, 3), np.int64)
    partners, n_partners, choices = np.empty((n1, n2), np.int64), np.zeros(n1, np.int64), np.empty(n2, np.int64)
    for sample in range(n1):
        for far in range(n2):
            if allowed[sample, far]:
                partners[sample, n_partners[sample]] = far
                n_partners[sample] += 1
    found, failures = 0, 0
    for _ in range(count):
        if failures == FAILURES:
            break
        failures += 1
        for _ in range(ATTEMPTS):
            n_matched = 0
            while n_matched < 3:
                near = generator.integers(0, n1)
                if n_matched == 0:
                    n_choices = int(n_partners[near])
                    choices[:n_choices] = partners[near, :n_choices]
                else:
                    last = n_matched - 1  # 0 or 1
                    one1, two1 = geodesics1[triplets1[found, 0], near], geodesics1[triplets1[found, last], near]
                    if min(one1, two1) < least_spread:
                        break
                    ones, twos = geodesics2[triplets2[found, 0]], geodesics2[triplets2[found, last]]
                    one_error, two_error = tolerance * one1, tolerance * two1
                    n_choices = 0
                    for far in partners[near, : n_partners[near]]:
                        # Without branches, since it is hard to predict which samples fit.
                        choices[n_choices] = far
                        n_choices += (
                            (min(ones[far], twos[far]) > 0)
                            & (abs(one1 - ones[far]) <= one_error)
                            & (abs(two1 - twos[far]) <= two_error)
                        )
                if n_choices == 0:
                    break
                triplets1[found, n_matched] = near
                triplets2[found, n_matched] = choices[generator.integers(0, n_choices)]
                n_matched += 1
            if n_matched == 3:
                found += 1
                failures = 0
                break
    return triplets1[:found], triplets2[:found]
