"""Triplets that swap two samples, and how alike samples of one surface are."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.matching.symmetry.parameters import SymmetryParameters
from mobius_match.matching.symmetry.swaps import cast_swap_votes, self_similarity, swap_triplets
from mobius_match.settings import MatchSettings
from mobius_match.voting.parameters import VotingParameters
from tests.shapes import lump

PARAMETERS = SymmetryParameters()
VOTING = VotingParameters()


def path_graph(n=7, step=0.4):
    return np.abs(np.arange(n)[:, None] - np.arange(n)) * step


def test_triplets_swap_two_samples_and_agree_in_their_distances():
    geodesics = path_graph()
    allowed = np.ones((7, 7), bool)
    allowed[0, 1] = allowed[1, 0] = False
    here, there = swap_triplets(np.random.default_rng(0), 500, geodesics, allowed, VOTING)
    assert len(here) == len(there) == 500
    np.testing.assert_array_equal(here[:, :2], there[:, 1::-1])
    for side in (here, there):
        assert all(len(set(triplet)) == 3 for triplet in side.tolist())
    for a, b in ((0, 1), (0, 2), (1, 2)):
        lengths, images = geodesics[here[:, a], here[:, b]], geodesics[there[:, a], there[:, b]]
        assert (lengths >= VOTING.least_spread).all()
        assert (np.abs(lengths - images) <= VOTING.length_tolerance * lengths).all()
    assert allowed[here, there].all()


def test_the_only_symmetry_of_a_path_is_to_turn_it_round():
    """Of four points on a line no two distances agree by tolerance alone."""
    here, there = swap_triplets(np.random.default_rng(0), 300, path_graph(4), np.ones((4, 4), bool), VOTING)
    assert len(here) == 300
    centres = here[:, 0] + here[:, 1]
    np.testing.assert_array_equal(here[:, 2] + there[:, 2], centres)


def test_where_nothing_fits_the_search_ends():
    for geodesics, allowed in ((path_graph(step=0.01), np.ones((7, 7), bool)), (path_graph(), np.eye(7, dtype=bool))):
        here, there = swap_triplets(np.random.default_rng(0), 20, geodesics, allowed, VOTING)
        assert here.shape == there.shape == (0, 3)


def test_similarity_is_measured_against_other_samples():
    """Samples 0 and 1 are alike, and 2 and 3; a sample's likeness to itself would make the width 0."""
    signatures = np.array([[1.0, 2], [1.01, 2], [3, 1], [3.03, 1]])
    similarity = self_similarity(signatures, 1.5)
    np.testing.assert_array_equal(np.diag(similarity), 1.0)
    np.testing.assert_array_equal(similarity, similarity.T)
    assert min(similarity[0, 1], similarity[2, 3]) == pytest.approx(np.exp(-((1 / 1.5) ** 2)), rel=0.05)
    assert similarity[:2, 2:].max() < 1e-6


def test_votes_count_triplets_and_leave_out_the_identity():
    surface = mm.prepare(lump(3), samples=40)
    votes = cast_swap_votes(surface, MatchSettings(votes=999, samples=40, seed=2), PARAMETERS, VOTING)
    assert 900 <= votes.n_voting <= votes.n_triplets <= 999
    np.testing.assert_array_equal(np.diag(votes.matrix), 0.0)
    assert votes.matrix.max() > 0
    assert (np.diff(votes.triplet_weights) <= 0).all()
    again = cast_swap_votes(surface, MatchSettings(votes=999, samples=40, seed=2, jobs=1), PARAMETERS, VOTING)
    np.testing.assert_array_equal(votes.matrix, again.matrix)
    np.testing.assert_array_equal(votes.best_source, again.best_source)
    other = cast_swap_votes(surface, MatchSettings(votes=999, samples=40, seed=3), PARAMETERS, VOTING)
    assert (votes.matrix != other.matrix).any()


def test_an_error_in_progress_ends_the_voting():
    def interrupt(stage, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cast_swap_votes(mm.prepare(lump(2), samples=20), MatchSettings(votes=1000), PARAMETERS, VOTING, interrupt)
