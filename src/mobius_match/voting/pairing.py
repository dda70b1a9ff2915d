"""Section 6, the inner lines of Algorithm 2: the candidate correspondences of triplets.

Both sets of samples are moved to the canonical domain and the mutually nearest are paired. This is one kernel for all
kinds of votes, so it is compiled once. It writes the pairs of a chunk of triplets to arrays, which voting then reads.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .._core.compiling import jit
from .canonical import coordinates, to_canonical_plane, to_sphere
from .nearest import Minima, Pairs, empty_minima, empty_pairs, mutually_nearest, padded
from .sweep import SWEEP_FROM, sweep

CHUNK = 256
"""Triplets whose pairs are kept at once: the arrays of 100 samples then stay in the processor's cache."""


def candidate_pairs(
    points1: np.ndarray,
    points2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    spherical: bool,
) -> Iterator[tuple[slice, Pairs]]:
    """The candidate correspondences c of triplets, chunk by chunk; parameters are those of :func:`.kernel.vote`.

    Yields
    ------
    slice, Pairs
        Which triplets, and their pairs, good until the next chunk is asked for. A count below ``least_pairs`` stands
        for a triplet with fewer pairs; they are not written then.
    """
    n1, n2 = len(points1), len(points2)
    samples = coordinates(points1), n1, coordinates(points2), n2
    images = np.zeros((3, padded(n1)), np.float32), np.zeros((3, padded(n2)), np.float32)
    minima, pairs = empty_minima(n1, n2), empty_pairs(min(CHUNK, len(triplets1)), n2)
    pair = pair_by_comparing if min(n1, n2) < SWEEP_FROM else pair_by_sweeping
    for start in range(0, len(triplets1), CHUNK):
        chunk = slice(start, start + CHUNK)
        pair(*samples, triplets1[chunk], triplets2[chunk], least_pairs, spherical, *images, minima, pairs)
        yield chunk, pairs


@jit
def pair_by_comparing(
    samples1: np.ndarray,
    n1: int,
    samples2: np.ndarray,
    n2: int,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    spherical: bool,
    image1: np.ndarray,
    image2: np.ndarray,
    minima: Minima,
    pairs: Pairs,
) -> None:
    """Write the pairs of each triplet, found by comparing all samples with all."""
    for i in range(len(triplets1)):
        pairs.counts[i] = -1
        if to_canonical_plane(samples1, triplets1, i, image1) and to_canonical_plane(samples2, triplets2, i, image2):
            if spherical:
                to_sphere(image1)
                to_sphere(image2)
            mutually_nearest(image1, n1, image2, n2, spherical, least_pairs, minima, pairs, i)


@jit
def pair_by_sweeping(
    samples1: np.ndarray,
    n1: int,
    samples2: np.ndarray,
    n2: int,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    spherical: bool,
    image1: np.ndarray,
    image2: np.ndarray,
    minima: Minima,
    pairs: Pairs,
) -> None:
    """Write the pairs of each triplet, found by a sweep; all of them, also where there are fewer than asked for."""
    for i in range(len(triplets1)):
        pairs.counts[i] = -1
        if to_canonical_plane(samples1, triplets1, i, image1) and to_canonical_plane(samples2, triplets2, i, image2):
            if spherical:
                to_sphere(image1)
                to_sphere(image2)
            sweep(image1, n1, image2, n2, spherical, minima, pairs, i)
