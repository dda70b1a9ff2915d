"""Sections 6 and 7: Algorithm 2, the voting loop, for a batch of triplets.

:func:`vote` is Algorithm 2. Its loop over the triplets is cut in two: :func:`.pairing.candidate_pairs` finds the
candidate correspondences of a chunk of triplets, :func:`add_votes` adds what they are worth to C. :func:`vote_weighted`
differs in what a vote is worth. All functions take arrays and numbers only. Points of the extended plane come as
homogeneous pairs (p, q), z = p / q; infinity is (1, 0).
"""

from __future__ import annotations

import math

import numpy as np

from .._core.compiling import jit
from .nearest import Pairs
from .pairing import candidate_pairs


def vote(
    points1: np.ndarray,
    points2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    least_pairs: int,
    epsilon: float,
    spherical: bool,
    votes: np.ndarray,
) -> int:
    """Algorithm 2: add the votes of a batch of triplets to C.

    Parameters
    ----------
    points1, points2
        (N1, 2) and (N2, 2) complex128, the samples in the plane, homogeneous.
    triplets1, triplets2
        (I, 3) int: three different samples of each side, matched in order.
    least_pairs
        The paper's K: a triplet with fewer mutually nearest pairs does not vote.
    epsilon
        The small number in 1 / (epsilon + E / n).
    spherical
        Distance on the sphere instead of in the plane.
    votes
        (N1, N2) float64, the matrix C, added to.

    Returns
    -------
    int
        How many triplets voted.
    """
    n_voting = 0
    for chunk, pairs in candidate_pairs(points1, points2, triplets1, triplets2, least_pairs, spherical):
        n_voting += add_votes(len(triplets1[chunk]), pairs, least_pairs, epsilon, spherical, votes)
    return n_voting


@jit
def add_votes(
    n_triplets: int, pairs: Pairs, least_pairs: int, epsilon: float, spherical: bool, votes: np.ndarray
) -> int:
    """Algorithm 2 from "if number of mutually closest pairs >= K" on: each pair gets 1 / (epsilon + E / n)."""
    counts, rows, columns, squared = pairs
    n_voting = 0
    for i in range(n_triplets):
        n = counts[i]
        if n >= least_pairs:
            energy = 0.0
            for pair in range(n):
                energy += deformation(squared[i, pair], spherical)
            for pair in range(n):
                votes[rows[i, pair], columns[i, pair]] += 1 / (epsilon + energy / n)
            n_voting += 1
    return n_voting


@jit
def deformation(squared: float, spherical: bool) -> float:
    """Distance of a pair in the canonical domain, section 7: |z - w|, or |z - w| / |1 + conj(z) w| on the sphere.

    With s the chord between the points on the sphere the latter is s / sqrt(4 - s^2).
    """
    square = np.float64(squared)
    return math.sqrt(square / max(4.0 - square, 1e-12) if spherical else square)


def vote_weighted(
    points1: np.ndarray,
    points2: np.ndarray,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    geodesics1: np.ndarray,
    geodesics2: np.ndarray,
    similarity: np.ndarray,
    scale: float,
    power: float,
    least_pairs: int,
    spherical: bool,
    votes: np.ndarray,
    triplet_weights: np.ndarray,
) -> int:
    """Algorithm 2 with weighted pairs in place of the deformation energy of section 7. Beyond the paper.

    The weight of a mutually nearest pair (z_k, w_j) is s_kj exp(-(g / scale)^2): s is the similarity of descriptors, g
    the mean absolute difference of its geodesic distances to the triplet's points on the two surfaces. The pair's vote
    is its weight times (W / N1)^power, W the sum of the triplet's weights. So the triplets that fit a large part of
    the surface decide, and those that map everything to a clump are not used.

    Parameters
    ----------
    geodesics1, geodesics2
        (N1, N1) and (N2, N2) float64, geodesic distances between the samples per sqrt(area).
    similarity
        (N1, N2) float64 in [0, 1], of descriptors.
    scale
        Difference of distances per sqrt(area) at which a pair's weight has fallen to 1 / e.
    power
        Exponent of the triplet's mean weight.
    triplet_weights
        (I,) float64, written to: the sum W of each triplet, 0 for one that did not vote.

    The other parameters, and the returned number, are those of :func:`vote`.
    """
    n_voting = 0
    for chunk, pairs in candidate_pairs(points1, points2, triplets1, triplets2, least_pairs, spherical):
        n_voting += add_weighted_votes(
            pairs,
            triplets1[chunk],
            triplets2[chunk],
            geodesics1,
            geodesics2,
            similarity,
            scale,
            power,
            least_pairs,
            votes,
            triplet_weights[chunk],
        )
    return n_voting


@jit
def add_weighted_votes(
    pairs: Pairs,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    geodesics1: np.ndarray,
    geodesics2: np.ndarray,
    similarity: np.ndarray,
    scale: float,
    power: float,
    least_pairs: int,
    votes: np.ndarray,
    triplet_weights: np.ndarray,
) -> int:
    """Add the weighted votes of a chunk of triplets, see :func:`vote_weighted`."""
    counts, rows, columns, _ = pairs
    weight = np.empty(rows.shape[1])
    n_voting = 0
    for i in range(len(triplets1)):
        n = counts[i]
        total = 0.0
        if n >= least_pairs:
            a1, b1, c1 = triplets1[i, 0], triplets1[i, 1], triplets1[i, 2]
            a2, b2, c2 = triplets2[i, 0], triplets2[i, 1], triplets2[i, 2]
            # A loop of its own: reads of the matrices overlap, which calls of exp between them would prevent.
            for pair in range(n):
                k, j = rows[i, pair], columns[i, pair]
                first = abs(geodesics1[a1, k] - geodesics2[a2, j])
                second = abs(geodesics1[b1, k] - geodesics2[b2, j])
                third = abs(geodesics1[c1, k] - geodesics2[c2, j])
                weight[pair] = (first + second + third) * (1 / 3) * (1 / scale)
            for pair in range(n):
                weight[pair] = similarity[rows[i, pair], columns[i, pair]] * math.exp(-(weight[pair] ** 2))
                total += weight[pair]
            worth = (total / len(geodesics1)) ** power
            for pair in range(n):
                votes[rows[i, pair], columns[i, pair]] += weight[pair] * worth
            n_voting += 1
        triplet_weights[i] = total
    return n_voting


def mutual_pairs(points1: np.ndarray, points2: np.ndarray, triplets1: np.ndarray, triplets2: np.ndarray) -> np.ndarray:
    """Which sample of the target each triplet pairs each source sample with, (I, N1) int32, -1 for none.

    The mutually nearest in the canonical plane are paired. Parameters are those of :func:`vote`.
    """
    partners = np.full((len(triplets1), len(points1)), np.int32(-1))
    for chunk, pairs in candidate_pairs(points1, points2, triplets1, triplets2, 0, False):
        counts = pairs.counts[: len(triplets1[chunk])]
        i, pair = np.nonzero(np.arange(len(points2)) < counts[:, None])
        partners[chunk][i, pairs.rows[i, pair]] = pairs.columns[i, pair]
    return partners
