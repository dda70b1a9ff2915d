"""The voting kernel against Algorithm 2 written once more in plain Python and numpy, exactly."""

import cmath
import math

import numpy as np
import pytest

from mobius_match.mobius import CANONICAL_TRIANGLE, INFINITY, apply, from_three_points, homogeneous
from mobius_match.voting.kernel import FAR, mutually_nearest, to_canonical, vote, vote_weighted
from mobius_match.voting.proposals import uniform_triplets


def canonical_twin(points, triplet):
    """Equations 3 and 4 for homogeneous points, (2, p) float32."""
    y1, y2, y3 = (complex(y) for y in CANONICAL_TRIANGLE)
    (p1, q1), (p2, q2), (p3, q3) = (tuple(map(complex, points[t])) for t in triplet)
    z12, z23 = p1 * q2 - p2 * q1, p2 * q3 - p3 * q2
    if z12 == 0 or z23 == 0 or p3 * q1 - p1 * q3 == 0:
        return None
    image = np.empty((2, len(points)), np.float32)
    for k, (p, q) in enumerate(points.tolist()):
        from_z1, to_z3 = p * q1 - p1 * q, p3 * q - p * q3
        numerator = (y1 - y2) * y3 * z23 * from_z1 + (y2 - y3) * y1 * z12 * to_z3
        denominator = (y1 - y2) * z23 * from_z1 + (y2 - y3) * z12 * to_z3
        size = denominator.real**2 + denominator.imag**2
        product = numerator * denominator.conjugate()
        real = numerator.real * denominator.real + numerator.imag * denominator.imag
        imag = numerator.imag * denominator.real - numerator.real * denominator.imag
        assert cmath.isclose(product, complex(real, imag), rel_tol=1e-9, abs_tol=1e-300)
        finite = size * FAR > abs(real) and size * FAR > abs(imag)
        image[:, k] = (real / size, imag / size) if finite else (FAR, 0.0)
    return image


def sphere_twin(plane):
    x, y = plane.astype(np.float64)
    square = x * x + y * y
    return np.stack([2 * x / (1 + square), 2 * y / (1 + square), (square - 1) / (1 + square)]).astype(np.float32)


def pairs_twin(first, second):
    """Mutually nearest pairs and their squared distances, by a dense matrix and its row and column minima."""
    axes = (second[axis][None, :] - first[axis][:, None] for axis in range(len(first)))
    squared = np.sum([difference * difference for difference in axes], axis=0, dtype=np.float32)
    if len(first) == 3:  # the order of summation matters for the last bit
        dx, dy, dz = (second[axis][None, :] - first[axis][:, None] for axis in range(3))
        squared = (dx * dx + dy * dy) + dz * dz
    row, column = squared.argmin(axis=1), squared.argmin(axis=0)
    return [(k, j, squared[k, j]) for k, j in enumerate(row) if column[j] == k]


def vote_twin(points1, points2, triplets1, triplets2, least_pairs, epsilon, spherical, weigh=None):
    """Algorithm 2, and its weighed form if ``weigh`` is (geodesics1, geodesics2, similarity, scale, power)."""
    votes, n_voting = np.zeros((len(points1), len(points2))), 0
    for t1, t2 in zip(triplets1, triplets2, strict=True):
        z, w = canonical_twin(points1, t1), canonical_twin(points2, t2)
        if z is None or w is None:
            continue
        candidates = pairs_twin(sphere_twin(z), sphere_twin(w)) if spherical else pairs_twin(z, w)
        if len(candidates) < least_pairs:
            continue
        n_voting += 1
        if weigh is None:
            energy = 0.0
            for _, _, squared in candidates:
                squared = float(squared)
                energy += math.sqrt(squared / max(4.0 - squared, 1e-12) if spherical else squared)
            for k, j, _ in candidates:
                votes[k, j] += 1 / (epsilon + energy / len(candidates))
            continue
        geodesics1, geodesics2, similarity, scale, power = weigh
        weights = []
        for k, j, _ in candidates:
            difference = sum(abs(geodesics1[a, k] - geodesics2[b, j]) / 3 for a, b in zip(t1, t2, strict=True))
            weights.append(similarity[k, j] * math.exp(-((difference / scale) ** 2)))
        for (k, j, _), weight in zip(candidates, weights, strict=True):
            votes[k, j] += weight * (sum(weights) / len(points1)) ** power
    return votes, n_voting


@pytest.fixture
def problem():
    """Points around the plane, infinity and a doubled point among them, and triplets of both sides."""
    rng = np.random.default_rng(7)
    z = rng.normal(size=30) + 1j * rng.normal(size=30)
    transformation = np.array([[1.0, 0.3j], [0.2, 1.1]])
    w = apply(transformation, z)[rng.permutation(30)][:26] + 0.02 * rng.normal(size=26)
    z[4], w[9] = INFINITY, INFINITY
    z[11] = z[12]
    triplets = uniform_triplets(rng, 400, len(z), len(w))
    return homogeneous(z), homogeneous(w), *triplets


@pytest.mark.parametrize("spherical", [False, True])
@pytest.mark.parametrize("least_pairs", [0, 9])
def test_vote_equals_its_twin(problem, spherical, least_pairs):
    votes = np.zeros((30, 26))
    n_voting = vote(*problem, least_pairs, 0.01, spherical, votes)
    expected, n_expected = vote_twin(*problem, least_pairs, 0.01, spherical)
    assert n_voting == n_expected
    assert 0 < n_voting <= 400
    np.testing.assert_array_equal(votes, expected)


@pytest.mark.parametrize("spherical", [False, True])
def test_weighted_vote_equals_its_twin(problem, spherical):
    rng = np.random.default_rng(1)
    geodesics1, geodesics2 = rng.random((30, 30)), rng.random((26, 26))
    similarity = rng.random((30, 26))
    votes = np.zeros((30, 26))
    weigh = (geodesics1, geodesics2, similarity, 0.5, 3.0)
    totals = np.full(400, np.nan)
    n_voting = vote_weighted(*problem, *weigh, 0, spherical, votes, totals)
    assert np.isfinite(totals).all()
    expected, n_expected = vote_twin(*problem, 0, 0.01, spherical, weigh)
    assert n_voting == n_expected
    np.testing.assert_array_equal(votes > 0, expected > 0)
    np.testing.assert_array_equal(votes > 0, expected > 0)  # the same pairs, every one
    np.testing.assert_allclose(votes, expected, rtol=1e-13)  # powers differ in the last bit


def test_threshold_is_reached_by_exactly_k_pairs():
    """Six points against themselves with the true triplet are six pairs: K = 6 votes and K = 7 does not."""
    points = homogeneous(np.array([0, 1, 2j, -1.5, 1 + 1j, -2j]))
    triplet = np.array([[0, 1, 2]])
    for least_pairs, expected in ((6, 1), (7, 0)):
        votes = np.zeros((6, 6))
        assert vote(points, points, triplet, triplet, least_pairs, 0.5, False, votes) == expected
        np.testing.assert_allclose(votes, expected * 2.0 * np.eye(6))


def test_doubled_point_in_a_triplet_does_not_vote():
    points = homogeneous(np.array([0, 0, 1, 2j]))
    votes = np.zeros((4, 4))
    assert vote(points, points, np.array([[0, 1, 2]]), np.array([[0, 2, 3]]), 0, 0.1, False, votes) == 0
    assert not votes.any()


def test_to_canonical_is_the_group_element():
    """The kernel's map is the one that mobius.py finds, infinity in and out included."""
    rng = np.random.default_rng(3)
    z = np.append(rng.normal(size=20) + 1j * rng.normal(size=20), INFINITY)
    for triplet in ([0, 5, 9], [20, 3, 4], [7, 20, 2], [1, 8, 20]):
        image = np.empty((2, 21), np.float32)
        assert to_canonical(homogeneous(z), np.array(triplet), image)
        expected = apply(from_three_points(z[triplet], CANONICAL_TRIANGLE), z)
        np.testing.assert_allclose(image[0] + 1j * image[1], expected, rtol=1e-5, atol=1e-6)


def test_two_points_that_differ_in_the_tenth_digit_stay_apart():
    """Flattened samples may be that close; the canonical frame must pull them apart, as it does in exact arithmetic."""
    z = 0.7 + np.array([0, 1e-10, 2.5e-10j, -1e-10, 0.3, 1e-10 + 1e-10j])
    image = np.empty((2, 6), np.float32)
    assert to_canonical(homogeneous(z), np.array([0, 1, 2]), image)
    exact = apply(from_three_points((z[:3] - 0.7) * 1e10, CANONICAL_TRIANGLE), (z - 0.7) * 1e10)
    np.testing.assert_allclose(image[0] + 1j * image[1], exact, rtol=1e-5, atol=1e-5)


def test_a_pole_in_the_canonical_plane_is_far_and_pairs_with_another():
    """Points that go to infinity on both sides are each other's nearest."""
    points = homogeneous(np.array([1, -1, 1j, 0.2, -0.4j]))
    pole = apply(np.linalg.inv(from_three_points(np.array([1, -1, 1j]), CANONICAL_TRIANGLE)), np.array([INFINITY]))
    points = np.concatenate([points, homogeneous(pole)])
    plane = np.empty((2, 6), np.float32)
    assert to_canonical(points, np.array([0, 1, 2]), plane)
    assert np.hypot(*plane[:, 5].astype(float)) > 1e6
    scratch = (np.empty(6, np.float32), np.empty(6, np.float32), np.empty(6, np.float32))
    partner = np.empty(6, np.int32)
    assert mutually_nearest(plane, plane, *scratch, partner) == 6
    np.testing.assert_array_equal(partner, np.arange(6))


def test_of_equally_near_points_the_lowest_number_is_taken():
    first = np.array([[0, 0], [0, 0]], np.float32)
    second = np.array([[1, -1, 1], [0, 0, 0]], np.float32)
    partner = np.empty(2, np.int32)
    n = mutually_nearest(
        first, second, np.empty(3, np.float32), np.empty(2, np.float32), np.empty(3, np.float32), partner
    )
    assert n == 1
    np.testing.assert_array_equal(partner, [0, -1])
