"""The voting kernel against its twin in plain numpy, exactly."""

import numpy as np
import pytest

from mobius_match.voting.kernel import mutual_pairs, vote, vote_weighted
from mobius_match.voting.mobius import INFINITY, apply, homogeneous
from mobius_match.voting.proposals import uniform_triplets
from mobius_match.voting.sweep import SWEEP_FROM
from tests.voting.twins import canonical_twin, pairs_twin, vote_twin


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
