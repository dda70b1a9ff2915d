"""The voting kernel against Algorithm 2 written once more in plain numpy, exactly."""

import math

import numpy as np
import pytest

from mobius_match.voting import nearest
from mobius_match.voting.kernel import FAR, TURN, coordinates, mutual_pairs, to_canonical, vote, vote_weighted
from mobius_match.voting.mobius import CANONICAL_TRIANGLE, INFINITY, apply, from_three_points, homogeneous
from mobius_match.voting.proposals import uniform_triplets
from mobius_match.voting.sweep import SEEDS, SWEEP_FROM, sweep

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)


def canonical_twin(points, triplet):
    """Equations 3 and 4 for homogeneous points, up to the rotation that makes y1 - y3 real, (2, p) float32."""
    z = np.array([complex(p) if q else 1e100 for p, q in points])
    z1, z2, z3 = (complex(z[t]) for t in triplet)
    if len({z1, z2, z3}) < 3:
        return None
    side = abs(Y1 - Y3)
    corner = Y3 * (side / (Y1 - Y3))
    r = (Y1 - Y2) / (Y2 - Y3) * (z2 - z3) / (z1 - z2)
    u, v = z - z1, z3 - z
    with np.errstate(all="ignore"):
        # Real arithmetic, one operation at a time: the order of rounding matters for the last digit.
        x, y = r.real * u.real - r.imag * u.imag + v.real, r.real * u.imag + r.imag * u.real + v.imag
        real, imag, square = v.real * x + v.imag * y, v.imag * x - v.real * y, x * x + y * y
        finite = square * FAR > np.abs(real) + np.abs(imag)
        scale = side / square
        image = np.where(finite, [corner.real + real * scale, corner.imag + imag * scale], [[FAR], [0.0]])
    return image.astype(np.float32)


def sphere_twin(plane):
    x, y = plane.astype(np.float64)
    square = x * x + y * y
    scale = 1 / (1 + square)
    return np.stack([2 * x * scale, 2 * y * scale, (square - 1) * scale]).astype(np.float32)


def squared_twin(first, second):
    """All squared distances (N1, N2); the order of summation matters for the last bit."""
    squares = [(second[axis][None, :] - first[axis][:, None]) ** 2 for axis in range(len(first))]
    return squares[0] + squares[1] if len(first) == 2 else (squares[0] + squares[1]) + squares[2]


def pairs_twin(first, second):
    """Mutually nearest pairs and their squared distances: a column and its first nearest row that is not taken yet."""
    squared = squared_twin(first, second)
    pairs, least = {}, squared.min(axis=1)
    for j, k in enumerate(squared.argmin(axis=0)):
        if squared[k, j] == least[k] and k not in pairs:
            pairs[int(k)] = j
    return [(k, j, squared[k, j]) for k, j in pairs.items()]


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


def padded(points):
    """Points (2 or 3, N) as the search takes them: three rows, whole blocks."""
    result = np.zeros((3, nearest.padded(points.shape[1])), np.float32)
    result[: len(points)] = points[:, np.minimum(np.arange(result.shape[1]), points.shape[1] - 1)]
    return result


def search(first, second, sweeping=False):
    """The pairs that the search finds, {(row, column, squared distance)}; all points are compared, or it sweeps."""
    (dimension, n1), n2 = first.shape, second.shape[1]
    sets, least, pairs = (
        (padded(first), n1, padded(second), n2),
        nearest.room_for_least(n1, n2),
        nearest.room_for_pairs(n2),
    )
    if sweeping:
        n = sweep(*sets, dimension == 3, least, pairs)
    else:
        n = nearest.mutually_nearest(*sets, dimension == 3, 0, least, pairs)
    found = list(zip(*(array[:n].tolist() for array in pairs), strict=True))
    assert len(set(found)) == n
    return set(found)


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
    triplet_weights = np.full(400, np.nan)
    n_voting = vote_weighted(*problem, *weigh, 0, spherical, votes, triplet_weights)
    assert np.isfinite(triplet_weights).all()
    expected, n_expected = vote_twin(*problem, 0, 0.01, spherical, weigh)
    assert n_voting == n_expected
    np.testing.assert_array_equal(votes > 0, expected > 0)  # the same pairs, every one
    np.testing.assert_allclose(votes, expected, rtol=1e-12)  # powers and products differ in the last bits


def test_explained_pairs_equal_the_twin(problem):
    points1, points2, triplets1, triplets2 = problem
    explained = mutual_pairs(*problem)
    for row, t1, t2 in zip(explained, triplets1, triplets2, strict=True):
        z, w = canonical_twin(points1, t1), canonical_twin(points2, t2)
        pairs = [] if z is None else pairs_twin(z, w)
        assert {(k, j) for k, j in enumerate(row) if j >= 0} == {(k, j) for k, j, _ in pairs}


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


def canonical(z, triplet):
    """Images of points (p,) under the kernel's map, complex."""
    samples = coordinates(homogeneous(z))
    image = np.zeros((3, samples.shape[1]), np.float32)
    assert to_canonical(samples, np.array([triplet]), 0, image)
    np.testing.assert_array_equal(image[:, len(z) :], image[:, [len(z) - 1]] * np.ones(samples.shape[1] - len(z)))
    return image[0, : len(z)] + 1j * image[1, : len(z)]


def test_to_canonical_is_the_group_element_and_a_rotation():
    """The kernel's map is the one that mobius.py finds, infinity in and out included."""
    rng = np.random.default_rng(3)
    z = np.append(rng.normal(size=20) + 1j * rng.normal(size=20), INFINITY)
    assert abs(TURN) == pytest.approx(1)
    for triplet in ([0, 5, 9], [20, 3, 4], [7, 20, 2], [1, 8, 20]):
        expected = TURN * apply(from_three_points(z[triplet], CANONICAL_TRIANGLE), z)
        np.testing.assert_allclose(canonical(z, triplet), expected, rtol=1e-5, atol=1e-6)


def test_two_points_that_differ_in_the_tenth_digit_stay_apart():
    """Flattened samples may be that close; the canonical frame must pull them apart, as it does in exact arithmetic."""
    z = 0.7 + np.array([0, 1e-10, 2.5e-10j, -1e-10, 0.3, 1e-10 + 1e-10j])
    exact = apply(from_three_points((z[:3] - 0.7) * 1e10, CANONICAL_TRIANGLE), (z - 0.7) * 1e10)
    np.testing.assert_allclose(canonical(z, [0, 1, 2]), TURN * exact, rtol=1e-5, atol=1e-5)


def test_a_pole_in_the_canonical_plane_is_far_and_pairs_with_another():
    """Points that go to infinity on both sides are each other's nearest."""
    z = np.array([1, -1, 1j, 0.2, -0.4j])
    pole = apply(np.linalg.inv(from_three_points(z[:3], CANONICAL_TRIANGLE)), np.array([INFINITY]))
    image = canonical(np.append(z, pole), [0, 1, 2])
    assert abs(image[5]) > 1e6
    plane = np.stack([image.real, image.imag]).astype(np.float32)
    assert {(k, j) for k, j, _ in search(plane, plane)} == {(k, k) for k in range(6)}


def scattered(kind, rng, n, dimension):
    """Points as triplets leave them: all around, in clumps, on a line across the sweep, a few at infinity."""
    points = rng.normal(size=(2, n))
    if kind == "clumps":
        points = 0.002 * points + rng.normal(size=(2, 5))[:, rng.integers(0, 5, n)]
    elif kind == "line":
        points[0] = 0.3
    elif kind == "tails":
        points = points / rng.random(n) ** 3
        points[:, 3] = FAR, 0
    points = points.astype(np.float32)
    return points if dimension == 2 else sphere_twin(points)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", ["around", "clumps", "line", "tails"])
@pytest.mark.parametrize("sizes", [(1, 1), (5, 9), (64, 33), (401, 353), (350, 500)])
def test_search_finds_the_mutually_nearest(dimension, kind, sizes):
    """Both ways to search find what the twin finds, squared distances to the last bit."""
    rng = np.random.default_rng([*sizes, dimension])
    first, second = (scattered("around" if n < 9 else kind, rng, n, dimension) for n in sizes)
    expected = set(pairs_twin(first, second))
    assert search(first, second) == expected
    if min(sizes) > SEEDS:
        assert search(first, second, sweeping=True) == expected


@pytest.mark.parametrize("sweeping", [False, True])
def test_of_equally_near_points_each_is_in_one_pair(sweeping):
    """On a coarse grid, where most points are doubled, what is found is mutually nearest and no point comes twice."""
    rng = np.random.default_rng(5)
    first, second = (rng.integers(-6, 6, (2, n)).astype(np.float32) for n in (200, 190))
    found = search(first, second, sweeping)
    squared = squared_twin(first, second)
    assert len(found) > 50
    assert len({k for k, _, _ in found}) == len({j for _, j, _ in found}) == len(found)
    for k, j, distance in found:
        assert distance == squared[k, j] == squared[k].min() == squared[:, j].min()


def test_of_equally_near_points_the_lowest_number_is_taken():
    first = np.array([[0, 0], [0, 0]], np.float32)
    second = np.array([[1, -1, 1], [0, 0, 0]], np.float32)
    assert search(first, second) == {(0, 0, 1.0)}


@pytest.mark.parametrize("sizes", [(70, 70), (66, 128), (130, 90)])
def test_search_is_given_up_only_where_there_are_too_few_pairs(sizes):
    """Whatever number of pairs is asked for, sets that have it are found to, and all their pairs, and no others."""
    rng = np.random.default_rng(sizes)
    n1, n2 = sizes
    first = rng.normal(size=(2, n1))
    for noise in (0.01, 0.1, 1.0):  # from most points being in a pair to what chance pairs
        second = np.resize(first.T, (n2, 2)).T + noise * rng.normal(size=(2, n2))
        sets = [points.astype(np.float32) for points in (first, second)]
        expected = set(pairs_twin(*sets))
        for least_pairs in range(min(sizes) + 1):
            least, pairs = nearest.room_for_least(n1, n2), nearest.room_for_pairs(n2)
            arguments = padded(sets[0]), n1, padded(sets[1]), n2, False, least_pairs, least, pairs
            n = nearest.mutually_nearest(*arguments)
            if len(expected) < least_pairs:
                assert n < least_pairs
            else:
                assert set(zip(*(array[:n].tolist() for array in pairs), strict=True)) == expected


@pytest.mark.parametrize("spherical", [False, True])
def test_votes_equal_their_twin_where_most_triplets_are_given_up(spherical):
    rng = np.random.default_rng(4)
    z = rng.normal(size=70) + 1j * rng.normal(size=70)
    w = apply(np.array([[1.0, 0.3j], [0.2, 1.1]]), z + 0.03 * rng.normal(size=70))
    triplets = uniform_triplets(rng, 100, 70, 70)
    triplets[1][::5] = triplets[0][::5]  # right ones, some of which have enough pairs
    problem = homogeneous(z), homogeneous(w), *triplets
    votes = np.zeros((70, 70))
    n_voting = vote(*problem, 50, 0.01, spherical, votes)
    expected, n_expected = vote_twin(*problem, 50, 0.01, spherical)
    assert n_voting == n_expected
    assert 5 < n_voting < 20
    np.testing.assert_array_equal(votes, expected)


def test_many_samples_vote_as_their_twin():
    """From this number on the kernel sweeps."""
    rng = np.random.default_rng(2)
    n = SWEEP_FROM + 1
    z = rng.normal(size=n) + 1j * rng.normal(size=n)
    w = apply(np.array([[1.0, 0.3j], [0.2, 1.1]]), z + 0.01 * rng.normal(size=n))
    triplets = uniform_triplets(rng, 20, n, n)
    points = homogeneous(z), homogeneous(w)
    for spherical in (False, True):
        votes = np.zeros((n, n))
        n_voting = vote(*points, *triplets, 5, 0.01, spherical, votes)
        expected, n_expected = vote_twin(*points, *triplets, 5, 0.01, spherical)
        assert n_voting == n_expected > 0
        np.testing.assert_array_equal(votes > 0, expected > 0)
        np.testing.assert_allclose(votes, expected, rtol=1e-12)  # energies are summed in another order
