"""Explanations: grouping by hand, the identity's perfect score, and the choice on a nearly symmetric shape."""

from dataclasses import replace

import numpy as np
import pytest
from mobius_match.alignments.groups import cluster_triplets

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment, register_iteratively
from mobius_match.alignments.candidates import HARD, alignments
from mobius_match.alignments.coarse_map import coarse_map, refined_targets
from mobius_match.alignments.cost import WEIGHTS, cost_terms
from mobius_match.alignments.selection import rerank_by_registration
from mobius_match.evaluation import examples
from mobius_match.settings import MatchSettings
from mobius_match.voting.votes import cast_votes
from tests.shapes import lump, renumbered


@pytest.fixture(scope="module")
def surface():
    return mm.prepare(lump(4))


def test_triplets_are_grouped_by_where_they_send_the_samples():
    """Four points on a line, a step of 1 apart: two triplets send them to their places, two turn them round."""
    distances = np.abs(np.arange(4)[:, None] - np.arange(4)) * 1.0
    pairs = np.array([[0, 1, 2, 3], [3, 2, 1, 0], [0, 1, -1, -1], [3, -1, -1, 0], [1, 0, 3, 2]])
    groups = cluster_triplets(pairs, distances, np.array([10.0, 9.0, 8.0, 7.0, 1.0]))
    assert [group.tolist() for group in groups] == [[0, 2], [1, 3]], "the last is too weak to be examined"


def test_triplets_that_share_no_pair_tell_different_things():
    pairs = np.array([[0, -1], [-1, 1]])
    groups = cluster_triplets(pairs, np.zeros((2, 2)), np.ones(2))
    assert [group.tolist() for group in groups] == [[0], [1]]
    assert cluster_triplets(np.empty((0, 3), int), np.zeros((3, 3)), np.empty(0)) == []


def test_identity_spreads_to_the_identity_and_has_nothing_against_it(surface):
    matches = np.stack([np.arange(40), np.arange(40)], axis=1)
    image = coarse_map(surface, surface, matches).argmax(axis=1)
    np.testing.assert_array_equal(image, np.arange(len(surface.proxy)))
    evidence = cost_terms(surface, surface, image)
    assert set(evidence) | {"landmarks"} == set(WEIGHTS)
    for kind, value in evidence.items():
        assert abs(value) < 0.02, kind


def test_wrong_maps_have_evidence_of_every_kind_against_them(surface):
    image = np.random.default_rng(0).permutation(len(surface.proxy))
    evidence = cost_terms(surface, surface, image)
    assert evidence["distances"] > 0.1
    assert evidence["laplacian"] > 0.5
    assert evidence["mean curvature"] > 0.8
    assert evidence["gauss curvature"] > 0.8


def test_targets_get_finer_than_samples():
    """Any vertex finds its copy or one beside it, whether it was a sample or not."""
    shape = lump(4)
    copy, new = renumbered(shape)
    first, second = mm.prepare(shape), mm.prepare(copy)
    found = alignments(first, second, cast_votes(first, second, MatchSettings()))
    vertices = np.arange(0, len(shape[0]), 5)
    error = np.linalg.norm(
        copy[0][refined_targets(first, second, found[0].image, vertices)] - shape[0][vertices], axis=1
    )
    edge = np.linalg.norm(shape[0][shape[1][:, 0]] - shape[0][shape[1][:, 1]], axis=1).mean()
    assert error.mean() < 0.5 * edge
    np.testing.assert_array_equal(np.sort(new), np.arange(len(new)))


@pytest.mark.parametrize("seed", range(3))
def test_person_is_not_turned_round(seed):
    """The mirrored and the turned person have their triplets too; they lose, and are told as alternatives."""
    result = mm.match(*examples.paths("person"), seed=seed)
    assert all(one.margin > 0 for one in result.alternatives)
    assert [one.margin for one in result.alternatives] == sorted(one.margin for one in result.alternatives)
    target = mm.read_mesh(examples.paths("person")[1])
    faces, barycentric = examples.truth("person")
    truth = np.einsum("ijk,ij->ik", target.vertices[target.faces[faces]], barycentric)
    height = np.ptp(target.vertices, axis=0).max()
    error = np.linalg.norm(target.vertices[result.pairs[:, 1]] - truth[result.pairs[:, 0]], axis=1) / height
    assert np.mean(error < 0.05) > 0.95


def test_where_all_drawn_triplets_are_wrong_the_ends_of_limbs_tell(monkeypatch):
    """Votes that send every sample elsewhere leave the right explanation to be found, and it wins."""
    source, target = (mm.prepare(path) for path in examples.paths("person"))
    votes = cast_votes(source, target, MatchSettings())
    right = alignments(source, target, votes)[0]
    generator = np.random.default_rng(0)
    wrong = np.array([generator.permutation(len(target.samples))[:3] for _ in votes.triplet_weights])
    monkeypatch.setattr("mobius_match.alignments.candidates.UNSURE", 0.0)  # as where shapes differ
    found = alignments(source, target, replace(votes, best_target=wrong))
    places = target.mesh.vertices / np.ptp(target.mesh.vertices, axis=0).max()
    apart = [np.linalg.norm(places[one.image] - places[right.image], axis=1).mean() for one in found]
    assert apart[0] < 0.03
    assert found[0].share == 0
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    assert min(apart[1:]) > 0.05, "none is told twice"


def test_a_map_that_began_badly_settles_nearer_to_the_truth(surface):
    """Every vertex of the proxy sent to another one within a fifth of sqrt(area)."""
    generator = np.random.default_rng(0)
    places, scale = surface.mesh.vertices[surface.proxy], np.sqrt(surface.area)
    image = np.array(
        [
            generator.choice(np.flatnonzero(np.linalg.norm(surface.mesh.vertices - p, axis=1) < 0.2 * scale))
            for p in places
        ]
    )
    explanation = Alignment(image, {}, 0.0, 1.0)
    once, at_last = explanation.registered(surface, surface), register_iteratively(surface, surface, explanation)

    def error(registration):
        return np.linalg.norm(registration.positions - places, axis=1).mean() / scale

    assert error(at_last) < 0.8 * error(once)
    assert error(at_last) < 0.02
    differing = rerank_by_registration(surface, surface, [replace(explanation, cost=HARD + 1)])[0]
    expected = register_iteratively(surface, surface, replace(explanation, shapes_differ=True))
    np.testing.assert_array_equal(differing.registration.positions, expected.positions)
    assert differing.shapes_differ
    assert not rerank_by_registration(surface, surface, [replace(explanation, cost=HARD - 1)])[0].shapes_differ
    assert register_iteratively(surface, surface, differing) is differing.registration


def test_uniform_votes_have_no_explanations():
    result = mm.match(lump(2), lump(2), preset="paper", votes=2000, samples=20)
    assert result.alternatives == ()
    assert len(result.votes.triplet_weights) == 0


def test_contenders_are_compared_once_more_by_how_much_they_stretch(surface):
    """A map to places that are mixed up locally stretches; though it was a little better before, it loses."""
    generator = np.random.default_rng(0)
    vertices = surface.mesh.vertices[surface.proxy]
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2).argsort(axis=1)[:, :60]
    mixed = surface.proxy[near[np.arange(len(near)), generator.integers(60, size=len(near))]]
    turned = surface.proxy[np.linalg.norm(vertices[:, None] + vertices, axis=2).argmin(axis=1)]
    right = Alignment(surface.proxy, {}, 1.1, 0.4)
    rivals = [Alignment(turned, {}, 1.0, 0.5), right, Alignment(mixed, {}, 3.0, 0.1)]
    judged = rerank_by_registration(surface, surface, rivals)
    assert judged[0].image is right.image
    assert judged[0].cost_terms["strain"] < judged[1].cost_terms["strain"]
    assert judged[0].registration is judged[0].registered(surface, surface)
    assert judged[2] is rivals[2], "too far behind to be looked at"
    alone = rerank_by_registration(surface, surface, [right])[0]
    assert (alone.cost, alone.image is right.image) == (right.cost, True)
    assert rerank_by_registration(surface, surface, []) == []


def test_contenders_are_bent_in_haste_and_with_care(surface, monkeypatch):
    """Both weigh the same, but who is hopeless in haste is left at that; the winner keeps what was bent with care."""
    right = Alignment(surface.proxy, {}, 0.0, 1.0)
    rivals = [right, *(replace(right, image=np.roll(surface.proxy, i), cost=0.1) for i in (5, 9))]
    strains = iter([2.0, 4.0, 6.0, 20.0, 30.0])
    monkeypatch.setattr("mobius_match.alignments.selection.register_coarsely", lambda *_: "in haste")
    monkeypatch.setattr(
        "mobius_match.alignments.selection.strain", lambda _, __, bent: calls.append(bent) or next(strains)
    )
    calls = []
    judged = rerank_by_registration(surface, surface, rivals)
    assert [one == "in haste" for one in calls] == [True, True, True, False, False]
    assert [one.cost_terms["strain"] for one in judged] == [0, 6 - 2, (4 - 2 + 30 - 20) / 2]
    assert judged[0].image is right.image
    assert judged[0].registration is calls[3]
