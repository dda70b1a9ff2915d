"""Sections 6 and 7: Algorithm 2, the voting loop, for a batch of triplets.

:func:`vote` is Algorithm 2 line by line; the functions before it are its lines. :func:`vote_weighted` differs in what a
vote is worth. All of them take arrays and numbers only. Points of the extended plane come as homogeneous pairs (p, q),
z = p / q, so that infinity (1, 0) needs no case of its own.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from ..mobius import CANONICAL_TRIANGLE

jit = numba.njit(cache=True, nogil=True, error_model="numpy")

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)
LARGEST = np.int32(np.iinfo(np.int32).max)
FAR = 1e15  # stands for infinity in the canonical plane; its square still fits a float32


@jit
def to_canonical(points: np.ndarray, triplet: np.ndarray, image: np.ndarray) -> bool:
    """Apply the map m with m(z_j) = y_j (equations 3 and 4) to all points; False if two of the z_j are equal.

    The map to 0, 1, infinity is written with differences of points, which are exact, and followed by the inverse of the
    same map of the y_j: samples may differ by 1e-10 of the plane's extent.
    """
    p1, q1 = points[triplet[0], 0], points[triplet[0], 1]
    p2, q2 = points[triplet[1], 0], points[triplet[1], 1]
    p3, q3 = points[triplet[2], 0], points[triplet[2], 1]
    z12, z23, z31 = p1 * q2 - p2 * q1, p2 * q3 - p3 * q2, p3 * q1 - p1 * q3
    if z12 == 0 or z23 == 0 or z31 == 0:
        return False
    a, b, c, d = (Y1 - Y2) * Y3 * z23, (Y2 - Y3) * Y1 * z12, (Y1 - Y2) * z23, (Y2 - Y3) * z12
    for k in range(len(points)):
        p, q = points[k, 0], points[k, 1]
        from_z1, to_z3 = p * q1 - p1 * q, p3 * q - p * q3
        numerator = a * from_z1 + b * to_z3
        denominator = c * from_z1 + d * to_z3
        size = denominator.real**2 + denominator.imag**2
        real = numerator.real * denominator.real + numerator.imag * denominator.imag
        imag = numerator.imag * denominator.real - numerator.real * denominator.imag
        if size * FAR > abs(real) and size * FAR > abs(imag):
            image[0, k], image[1, k] = real / size, imag / size
        else:
            image[0, k], image[1, k] = FAR, 0.0
    return True


@jit
def to_sphere(plane: np.ndarray, sphere: np.ndarray) -> None:
    """Stereographic projection of canonical points (2, p) to the unit sphere (3, p)."""
    for k in range(plane.shape[1]):
        x, y = np.float64(plane[0, k]), np.float64(plane[1, k])
        square = x * x + y * y
        sphere[0, k] = 2 * x / (1 + square)
        sphere[1, k] = 2 * y / (1 + square)
        sphere[2, k] = (square - 1) / (1 + square)


@jit
def mutually_nearest(
    first: np.ndarray,
    second: np.ndarray,
    row: np.ndarray,
    row_least: np.ndarray,
    column_least: np.ndarray,
    partner: np.ndarray,
) -> int:
    """Pair the points of ``first`` (2 or 3, N1) and ``second`` (2 or 3, N2) that are each other's nearest.

    Writes to ``partner`` (N1,) int32 the paired point of ``second``, -1 for none, and to ``row_least`` (N1,) the
    squared distance; returns the number of pairs. ``row`` (N2,) and ``column_least`` (N2,) are scratch. Of equally near
    points the lowest number is the nearest.
    """
    # Squared distances are not negative, so their bits order as integers, whose minima use vector instructions.
    bits, rows, columns = row.view(np.int32), row_least.view(np.int32), column_least.view(np.int32)
    xs, ys, zs = second[0], second[1], second[-1]
    columns[:] = LARGEST
    for k in range(first.shape[1]):
        x, y, z = first[0, k], first[1, k], first[-1, k]
        if len(first) == 2:
            for j in range(len(row)):
                dx, dy = xs[j] - x, ys[j] - y
                row[j] = dx * dx + dy * dy
        else:
            for j in range(len(row)):
                dx, dy, dz = xs[j] - x, ys[j] - y, zs[j] - z
                row[j] = dx * dx + dy * dy + dz * dz
        least = LARGEST
        for j in range(len(row)):
            least = min(least, bits[j])
            columns[j] = min(columns[j], bits[j])
        nearest = LARGEST
        for j in range(len(row)):
            nearest = min(nearest, np.int32(j) if bits[j] == least else LARGEST)
        rows[k] = least
        partner[k] = nearest
    n_pairs = 0
    for k in range(len(partner)):
        j = partner[k]
        if rows[k] == columns[j]:
            columns[j] = -1  # taken
            n_pairs += 1
        else:
            partner[k] = -1
    return n_pairs


@jit
def scratch(n1: int, n2: int) -> tuple[np.ndarray, ...]:
    """Room for one triplet's images in the plane and on the sphere, and for the search for nearest neighbours."""
    return (
        np.empty((2, n1), np.float32),
        np.empty((2, n2), np.float32),
        np.empty((3, n1), np.float32),
        np.empty((3, n2), np.float32),
        np.empty(n2, np.float32),
        np.empty(n2, np.float32),
    )


@jit
def candidates(
    points1: np.ndarray,
    points2: np.ndarray,
    triplet1: np.ndarray,
    triplet2: np.ndarray,
    spherical: bool,
    space: tuple[np.ndarray, ...],
    squared: np.ndarray,
    partner: np.ndarray,
) -> int:
    """The candidate correspondence c of a triplet: move both sets to the canonical domain, pair the mutually nearest.

    Writes ``partner`` and ``squared`` as :func:`mutually_nearest` does, and returns the number n of pairs; -1 where
    the triplet has no transformation.
    """
    plane1, plane2, sphere1, sphere2, row, column_least = space
    if not to_canonical(points1, triplet1, plane1) or not to_canonical(points2, triplet2, plane2):
        return -1
    if spherical:
        to_sphere(plane1, sphere1)
        to_sphere(plane2, sphere2)
        return mutually_nearest(sphere1, sphere2, row, squared, column_least, partner)
    return mutually_nearest(plane1, plane2, row, squared, column_least, partner)


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
    n1 = len(points1)
    space = scratch(n1, len(points2))
    squared, partner = np.empty(n1, np.float32), np.empty(n1, np.int32)
    n_voting = 0
    for i in range(len(triplets1)):
        n = candidates(points1, points2, triplets1[i], triplets2[i], spherical, space, squared, partner)
        if n >= least_pairs:
            energy = 0.0
            for k in range(n1):
                if partner[k] >= 0:
                    energy += deformation(squared[k], spherical)
            for k in range(n1):
                if partner[k] >= 0:
                    votes[k, partner[k]] += 1 / (epsilon + energy / n)
            n_voting += 1
    return n_voting


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
    totals: np.ndarray,
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
    n1 = len(points1)
    space = scratch(n1, len(points2))
    squared, partner, weight = np.empty(n1, np.float32), np.empty(n1, np.int32), np.zeros(n1)
    n_voting = 0
    totals[:] = 0.0
    for i in range(len(triplets1)):
        n = candidates(points1, points2, triplets1[i], triplets2[i], spherical, space, squared, partner)
        if n >= least_pairs:
            total = 0.0
            for k in range(n1):
                if partner[k] >= 0:
                    difference = 0.0
                    for corner in range(3):
                        here = geodesics1[triplets1[i, corner], k]
                        there = geodesics2[triplets2[i, corner], partner[k]]
                        difference += abs(here - there) / 3
                    weight[k] = similarity[k, partner[k]] * math.exp(-((difference / scale) ** 2))
                    total += weight[k]
            totals[i] = total
            worth = (total / n1) ** power
            for k in range(n1):
                if partner[k] >= 0:
                    votes[k, partner[k]] += weight[k] * worth
            n_voting += 1
    return n_voting


@jit
def explained_pairs(
    points1: np.ndarray, points2: np.ndarray, triplets1: np.ndarray, triplets2: np.ndarray
) -> np.ndarray:
    """Which sample of the target each triplet pairs each source sample with, (I, N1) int32, -1 for none.

    Parameters are those of :func:`vote`; the nearest in the plane are meant.
    """
    n1 = len(points1)
    space, squared = scratch(n1, len(points2)), np.empty(n1, np.float32)
    pairs = np.full((len(triplets1), n1), np.int32(-1))
    for i in range(len(triplets1)):
        candidates(points1, points2, triplets1[i], triplets2[i], False, space, squared, pairs[i])
    return pairs
