"""Sections 6 and 7: Algorithm 2, the voting loop, for a batch of triplets.

:func:`vote` is Algorithm 2 line by line; the functions before it are its lines. :func:`vote_weighted` differs in what a
vote is worth. All of them take arrays and numbers only. Points of the extended plane come as homogeneous pairs (p, q),
z = p / q; infinity is (1, 0).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._core.compiling import inlined, jit
from .mobius import CANONICAL_TRIANGLE
from .nearest import Least, Pairs, mutually_nearest, padded, room_for_least, room_for_pairs
from .sweep import SWEEP_FROM, sweep

INFINITE = 1e100  # stands for infinity among the samples: less any other sample it is the same, to the last digit
FAR = 1e15  # stands for infinity in the canonical plane; its square still fits a float32

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)
SIDE = abs(Y1 - Y3)
TURN = SIDE / (Y1 - Y3)
"""The canonical triangle is turned so that y1 - y3 is real, which spares products and leaves all distances."""
CORNER = Y3 * TURN
RATIO = (Y1 - Y2) / (Y2 - Y3)


@jit
def coordinates(points: np.ndarray) -> np.ndarray:
    """Homogeneous points (N, 2) as the real and imaginary parts of z, (2, padded)."""
    result = np.empty((2, padded(len(points))))
    for k in range(result.shape[1]):
        p, q = points[min(k, len(points) - 1), 0], points[min(k, len(points) - 1), 1]
        z = p / q if q != 0 else complex(INFINITE, 0)
        result[0, k], result[1, k] = z.real, z.imag
    return result


@jit
def corners(triplets: np.ndarray, i: int) -> tuple[int, int, int]:
    """The samples of a triplet."""
    return triplets[i, 0], triplets[i, 1], triplets[i, 2]


@jit
def to_canonical(points: np.ndarray, triplets: np.ndarray, i: int, image: np.ndarray) -> bool:
    """Apply the map m with m(z_j) = y_j (equations 3 and 4) to all points; False if two of the z_j are equal.

    Only differences of points are used, which are exact: samples may differ by 1e-10 of the plane's extent. With
    u = z - z_1, v = z_3 - z and r = (y_1 - y_2) / (y_2 - y_3) * z_23 / z_12, m(z) = y_3 + (y_1 - y_3) v / (r u + v).
    """
    one, two, three = corners(triplets, i)
    x1, y1 = points[0, one], points[1, one]
    x2, y2 = points[0, two], points[1, two]
    x3, y3 = points[0, three], points[1, three]
    z12, z23, z31 = complex(x1 - x2, y1 - y2), complex(x2 - x3, y2 - y3), complex(x3 - x1, y3 - y1)
    if z12 == 0 or z23 == 0 or z31 == 0:
        return False
    r = RATIO * z23 / z12
    for k in range(points.shape[1]):
        ux, uy = points[0, k] - x1, points[1, k] - y1
        vx, vy = x3 - points[0, k], y3 - points[1, k]
        dx, dy = r.real * ux - r.imag * uy + vx, r.real * uy + r.imag * ux + vy
        real, imag, square = vx * dx + vy * dy, vy * dx - vx * dy, dx * dx + dy * dy
        scale = SIDE / square
        finite = square * FAR > abs(real) + abs(imag)
        image[0, k] = CORNER.real + real * scale if finite else FAR
        image[1, k] = CORNER.imag + imag * scale if finite else 0.0
    return True


@jit
def to_sphere(points: np.ndarray) -> None:
    """Stereographic projection of canonical points, in place, to the unit sphere."""
    for k in range(points.shape[1]):
        x, y = np.float64(points[0, k]), np.float64(points[1, k])
        square = x * x + y * y
        scale = 1 / (1 + square)
        points[0, k], points[1, k], points[2, k] = 2 * x * scale, 2 * y * scale, (square - 1) * scale


class Workspace(NamedTuple):
    """Room for one triplet's images, and for the search for nearest neighbours and its result."""

    image1: np.ndarray
    image2: np.ndarray
    least: Least
    pairs: Pairs


@jit
def workspace(n1: int, n2: int) -> Workspace:
    """Scratch for sets of n1 and n2 points."""
    image1, image2 = np.zeros((3, padded(n1)), np.float32), np.zeros((3, padded(n2)), np.float32)
    return Workspace(image1, image2, room_for_least(n1, n2), room_for_pairs(n2))


@inlined
def candidates(
    points1: np.ndarray,
    n1: int,
    points2: np.ndarray,
    n2: int,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    i: int,
    least_pairs: int,
    spherical: bool,
    space: Workspace,
) -> int:
    """The candidate correspondence c of a triplet: move both sets to the canonical domain, pair the mutually nearest.

    Writes ``space.pairs`` and returns the number n of pairs; a number below ``least_pairs`` where there are not so
    many, -1 where the triplet has no transformation.
    """
    image1, image2, least, pairs = space
    n = -1  # one way out: with several, the references of all arrays would be counted for every triplet
    if to_canonical(points1, triplets1, i, image1) and to_canonical(points2, triplets2, i, image2):
        if spherical:
            to_sphere(image1)
            to_sphere(image2)
        if min(n1, n2) < SWEEP_FROM:
            n = mutually_nearest(image1, n1, image2, n2, spherical, least_pairs, least, pairs)
        else:
            n = sweep(image1, n1, image2, n2, spherical, least, pairs)
    return n


@jit
def deformation(squared: float, spherical: bool) -> float:
    """Distance of a pair in the canonical domain, section 7: |z - w|, or |z - w| / |1 + conj(z) w| on the sphere.

    With s the chord between the points on the sphere the latter is s / sqrt(4 - s^2).
    """
    square = np.float64(squared)
    return math.sqrt(square / max(4.0 - square, 1e-12) if spherical else square)


@jit
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
    n1, n2 = len(points1), len(points2)
    samples1, samples2 = coordinates(points1), coordinates(points2)
    space = workspace(n1, n2)
    rows, columns, squared = space.pairs
    n_voting = 0
    for i in range(len(triplets1)):
        n = candidates(samples1, n1, samples2, n2, triplets1, triplets2, i, least_pairs, spherical, space)
        if n >= least_pairs:
            energy = 0.0
            for pair in range(n):
                energy += deformation(squared[pair], spherical)
            for pair in range(n):
                votes[rows[pair], columns[pair]] += 1 / (epsilon + energy / n)
            n_voting += 1
    return n_voting


@jit
def disagreement(
    geodesics1: np.ndarray,
    triplet1: tuple[int, int, int],
    k: int,
    geodesics2: np.ndarray,
    triplet2: tuple[int, int, int],
    j: int,
) -> float:
    """Mean difference of the distances of samples k and j to the points of the triplet on either side."""
    first = abs(geodesics1[triplet1[0], k] - geodesics2[triplet2[0], j])
    second = abs(geodesics1[triplet1[1], k] - geodesics2[triplet2[1], j])
    third = abs(geodesics1[triplet1[2], k] - geodesics2[triplet2[2], j])
    return (first + second + third) * (1 / 3)


@jit
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
    """Algorithm 2 with weighed pairs in place of the energy of section 7.

    A mutually nearest pair counts by how well its geodesic distances to the triplet's points agree on both surfaces,
    times the similarity of its descriptors; the triplet by the mean of its pairs' weights to a power. So a triplet
    that explains a part of the surface well has a say, and one that maps everything to a clump has none.

    Parameters
    ----------
    geodesics1, geodesics2
        (N1, N1) and (N2, N2) float64, distances between the samples per sqrt(area).
    similarity
        (N1, N2) float64 in [0, 1], of descriptors.
    scale
        Difference of distances per sqrt(area) at which a pair's weight is 1 / e.
    power
        The power that the sum of the weights, as a fraction of the samples, is raised to.
    totals
        (I,) float64, written to: the sum of the weights of each triplet, 0 for one that did not vote.

    The other parameters, and what is returned, are those of :func:`vote`.
    """
    n1, n2 = len(points1), len(points2)
    samples1, samples2 = coordinates(points1), coordinates(points2)
    space = workspace(n1, n2)
    rows, columns, _ = space.pairs
    weight = np.empty(n2)
    n_voting = 0
    triplet_weights[:] = 0.0
    for i in range(len(triplets1)):
        n = candidates(samples1, n1, samples2, n2, triplets1, triplets2, i, least_pairs, spherical, space)
        if n >= least_pairs:
            # The gathering first and alone: it overlaps, a call of exp between would keep it from that.
            triplet1, triplet2 = corners(triplets1, i), corners(triplets2, i)
            for pair in range(n):
                k, j = rows[pair], columns[pair]
                weight[pair] = disagreement(geodesics1, triplet1, k, geodesics2, triplet2, j) * (1 / scale)
            total = 0.0
            for pair in range(n):
                weight[pair] = similarity[rows[pair], columns[pair]] * math.exp(-(weight[pair] ** 2))
                total += weight[pair]
            triplet_weights[i] = total
            worth = (total / n1) ** power
            for pair in range(n):
                votes[rows[pair], columns[pair]] += weight[pair] * worth
            n_voting += 1
    return n_voting


@jit
def mutual_pairs(points1: np.ndarray, points2: np.ndarray, triplets1: np.ndarray, triplets2: np.ndarray) -> np.ndarray:
    """Which sample of the target each triplet pairs each source sample with, (I, N1) int32, -1 for none.

    Parameters are those of :func:`vote`; the nearest in the plane are meant.
    """
    n1, n2 = len(points1), len(points2)
    samples1, samples2 = coordinates(points1), coordinates(points2)
    space = workspace(n1, n2)
    explained = np.full((len(triplets1), n1), np.int32(-1))
    for i in range(len(triplets1)):
        n = candidates(samples1, n1, samples2, n2, triplets1, triplets2, i, 0, False, space)
        for pair in range(n):
            explained[i, space.pairs.rows[pair]] = space.pairs.columns[pair]
    return explained
