"""How many triplets are drawn: until the votes have settled, or as many as were asked for."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.settings import make_settings
from mobius_match.voting.parameters import VotingParameters
from mobius_match.voting.votes import cast_votes, signature_similarity
from tests.shapes import lump, tube


@pytest.fixture(scope="module")
def surface():
    return mm.prepare(lump(4))


def test_easy_pairs_end_early_and_hard_ones_go_on_to_the_bound(surface):
    settings = make_settings()
    easy, hard = cast_votes(surface, surface, settings), cast_votes(surface, mm.prepare(tube(40, 60)), settings)
    assert easy.n_triplets < hard.n_triplets <= settings.number_of_votes()
    assert easy.n_triplets >= settings.number_of_votes() // 2  # one round alone has nothing to compare with


def test_a_given_number_is_kept_to(surface):
    for number in (1, 777, 30_000):
        assert cast_votes(surface, surface, make_settings(votes=number)).n_triplets == number


def test_the_number_that_was_drawn_gives_the_same_votes_and_more_keep_the_leaders(surface):
    early = cast_votes(surface, surface, make_settings())
    again = cast_votes(surface, surface, make_settings(votes=early.n_triplets))
    np.testing.assert_array_equal(early.matrix, again.matrix)
    late = cast_votes(surface, surface, make_settings(votes=60_000))
    leading = late.matrix.max(axis=1)
    same = early.matrix.argmax(axis=1) == late.matrix.argmax(axis=1)
    assert leading[same].sum() > (VotingParameters().settled_share - 0.03) * leading.sum()


@pytest.mark.parametrize("jobs", [2, 5])
def test_where_it_ends_does_not_depend_on_the_threads(jobs):
    pair = [mm.prepare(path) for path in examples.paths("quadruped")]
    one, many = (cast_votes(*pair, make_settings(jobs=number)) for number in (1, jobs))
    assert one.n_triplets == many.n_triplets
    np.testing.assert_array_equal(one.matrix, many.matrix)


def test_progress_is_whole_where_votes_settle_early(surface):
    calls = []
    cast_votes(surface, surface, make_settings(), lambda *call: calls.append(call))
    voting = [(done, total) for stage, done, total in calls if stage == "voting"]
    assert voting[-1][0] == voting[-1][1]
    assert [done for done, _ in voting] == sorted(done for done, _ in voting)


def test_an_infinite_width_leaves_descriptors_out(surface):
    signatures = surface.signatures
    np.testing.assert_array_equal(signature_similarity(signatures, signatures, np.inf), 1.0)
    similarity = signature_similarity(signatures, signatures[::-1], 2.0)
    assert (similarity[:, ::-1].diagonal() == 1.0).all()
    assert similarity.min() < 0.5
