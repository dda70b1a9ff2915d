"""Alignments: clusters by hand, the identity's perfect score, and the choice on a nearly symmetric shape."""

from dataclasses import asdict, fields, replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment, register_iteratively
from mobius_match.alignments.candidates import Candidates, distinct_alignments
from mobius_match.alignments.clusters import agreed_matches, cluster_triplets, most_consistent_half
from mobius_match.alignments.coarse_map import coarse_map, quick_image, refined_targets
from mobius_match.alignments.cost import cost_terms, total_cost
from mobius_match.alignments.parameters import AlignmentParameters, CostWeights
from mobius_match.landmarks.constraints import landmark_constraints
from mobius_match.settings import MatchSettings
from mobius_match.voting.votes import cast_votes
from tests.shapes import ellipsoid, lump, renumbered, true_places

PARAMETERS = AlignmentParameters()
SELECTION = PARAMETERS.selection


@pytest.fixture(scope="module")
def surface(lump_surface):
    return lump_surface


@pytest.fixture(scope="module")
def identical_samples():
    """The first samples of a surface, matched with themselves."""
    return np.stack([np.arange(40), np.arange(40)], axis=1)


def test_triplets_are_clustered_by_where_they_send_the_samples():
    """Four points on a line, a step of 1 apart: two triplets send them to their places, two reverse their order."""
    distances = np.abs(np.arange(4)[:, None] - np.arange(4)) * 1.0
    pairs = np.array([[0, 1, 2, 3], [3, 2, 1, 0], [0, 1, -1, -1], [3, -1, -1, 0], [1, 0, 3, 2]])
    clusters = cluster_triplets(pairs, distances, np.array([10.0, 9.0, 8.0, 7.0, 1.0]), 0.2, 0.6, 8)
    assert [cluster.tolist() for cluster in clusters] == [[0, 2], [1, 3]], "the last triplet's weight is too small"


def test_triplets_without_a_common_sample_are_not_clustered():
    pairs = np.array([[0, -1], [-1, 1]])
    clusters = cluster_triplets(pairs, np.zeros((2, 2)), np.ones(2), 0.2, 0.6, 8)
    assert [cluster.tolist() for cluster in clusters] == [[0], [1]]
    assert cluster_triplets(np.empty((0, 3), int), np.zeros((3, 3)), np.empty(0), 0.2, 0.6, 8) == []


def test_matches_of_a_cluster_are_elected_by_squared_weights():
    """Sample 0: 3 squared beats 2 squared twice. Sample 1 gets what is left of the targets. Sample 2 has no pair."""
    pairs, weights = np.array([[0, 1, -1], [1, 0, -1], [1, -1, -1]]), np.array([3.0, 2.0, 2.0])
    np.testing.assert_array_equal(agreed_matches(pairs, weights, 2, 60), [[0, 0], [1, 1]])
    np.testing.assert_array_equal(agreed_matches(pairs, weights, 2, 1), [[0, 0]])


def test_the_consistent_half_of_a_cluster_is_the_one_nearest_to_its_centre():
    distances = np.abs(np.arange(5)[:, None] - np.arange(5)) * 1.0
    pairs = np.array([[0, 1], [4, 4], [0, 2], [3, 3], [0, 1], [4, 3]])
    np.testing.assert_array_equal(most_consistent_half(pairs, distances, np.array([0, 1, 2, 3, 4])), [0, 2, 4])
    np.testing.assert_array_equal(most_consistent_half(pairs, distances, np.array([1, 2, 5, 3])), [1, 5])


def test_the_identity_has_a_coarse_map_of_no_cost(surface, identical_samples):
    image = coarse_map(surface, surface, identical_samples, PARAMETERS.coarse_map).argmax(axis=1)
    np.testing.assert_array_equal(image, np.arange(len(surface.proxy)))
    terms = cost_terms(surface, surface, image, PARAMETERS.cost)
    assert set(terms) | {"landmarks"} == {field.name for field in fields(CostWeights)}
    for kind, value in terms.items():
        assert abs(value) < 0.02, kind


def test_a_quick_image_is_that_of_the_coarse_map_nearly_everywhere(surface, identical_samples):
    image = quick_image(surface, surface, identical_samples, PARAMETERS.coarse_map)
    places = surface.mesh.vertices[surface.proxy]
    thinned = places[:: PARAMETERS.coarse_map.quick_thinning]
    error = np.linalg.norm(places[image] - thinned, axis=1) / np.sqrt(surface.area)
    assert error.mean() < 0.02


def test_landmarks_decide_between_symmetric_coarse_maps():
    """Half a turn about its long axis takes an ellipsoid to itself, and its tip, the only match, stays in place."""
    vertices, faces = ellipsoid()
    surface = mm.prepare((vertices, faces))
    opposite = np.linalg.norm(vertices[:, None] - vertices * [-1, -1, 1], axis=2).argmin(axis=0)
    tip = int(np.abs(surface.mesh.vertices[surface.samples, 2]).argmax())
    known = surface.samples[[10, 40, 70]]
    for images in (np.arange(len(vertices)), opposite):
        constraints, _ = landmark_constraints(np.column_stack([known, images[known]]), surface, surface)
        plan = coarse_map(surface, surface, np.array([[tip, tip]]), PARAMETERS.coarse_map, constraints)
        found, places = vertices[surface.proxy[plan.argmax(axis=1)]], vertices[images[surface.proxy]]
        assert np.linalg.norm(found - places, axis=1).mean() < 0.02 * np.sqrt(surface.area)


def test_every_cost_term_is_large_for_a_random_map(surface):
    image = np.random.default_rng(0).permutation(len(surface.proxy))
    terms = cost_terms(surface, surface, image, PARAMETERS.cost)
    assert terms["distances"] > 0.1
    assert terms["laplacian"] > 0.5
    assert terms["mean_curvature"] > 0.8
    assert terms["gauss_curvature"] > 0.8


def test_the_total_cost_is_the_weighted_sum():
    weights = asdict(CostWeights())
    terms = {kind: 2.0**i for i, kind in enumerate(weights)}
    assert total_cost(terms, CostWeights()) == pytest.approx(sum(weights[kind] * terms[kind] for kind in terms))
    assert total_cost({}, CostWeights()) == 0


def test_targets_are_refined_beyond_the_samples():
    """Any vertex finds its copy or one beside it, whether it was a sample or not."""
    shape = lump(4)
    copy, new = renumbered(shape)
    source, target = mm.prepare(shape), mm.prepare(copy)
    found = Candidates(source, target, PARAMETERS).voted(cast_votes(source, target, MatchSettings()))
    vertices = np.arange(0, len(shape[0]), 5)
    targets = refined_targets(source, target, found[0].image, vertices, PARAMETERS.coarse_map)
    error = np.linalg.norm(copy[0][targets] - shape[0][vertices], axis=1)
    edge = np.linalg.norm(shape[0][shape[1][:, 0]] - shape[0][shape[1][:, 1]], axis=1).mean()
    assert error.mean() < 0.5 * edge
    assert error.max() < 2 * edge
    assert np.mean(targets == new[vertices]) > 0.75


@pytest.mark.parametrize("seed", range(3))
def test_the_person_is_not_matched_with_its_mirror_image(shipped_match, seed):
    """The mirrored and the turned person have triplets of their own, but cost more."""
    result = shipped_match("person", seed)
    vertices = result.target.mesh.vertices
    height = np.ptp(vertices, axis=0).max()
    truth = true_places("person")[result.pairs[:, 0]]
    error = np.linalg.norm(vertices[result.pairs[:, 1]] - truth, axis=1) / height
    assert np.mean(error < 0.05) > 0.95


def test_alternatives_are_sorted_by_their_probability(shipped_match):
    result = shipped_match("person")
    chances = [result.probability, *(one.probability for one in result.alternatives)]
    assert len(chances) > 1
    assert chances == sorted(chances, reverse=True)
    assert sum(chances) <= 1


def test_extremities_and_motions_give_the_right_alignment_where_all_drawn_triplets_are_wrong(person):
    """Votes that send every sample to a random one."""
    source, target = person
    candidates, votes = Candidates(source, target, PARAMETERS), cast_votes(source, target, MatchSettings())
    right = candidates.voted(votes)[0]
    generator = np.random.default_rng(0)
    random = np.array([generator.permutation(len(target.samples))[:3] for _ in votes.triplet_weights])
    wrong = candidates.voted(replace(votes, best_target=random))
    found = candidates.further(wrong)
    places = target.mesh.vertices / np.ptp(target.mesh.vertices, axis=0).max()
    apart = [np.linalg.norm(places[one.image] - places[right.image], axis=1).mean() for one in found]
    assert apart[0] < 0.03
    assert found[0].share == 0
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    assert min(apart[1:]) > 0.05, "no alignment is listed twice"
    assert candidates.further(found) == [], "those that are known are not found again"


def test_of_equal_alignments_the_cheapest_is_kept_with_the_largest_share(surface):
    opposite = surface.mesh.vertices[surface.proxy]
    opposite = surface.proxy[np.linalg.norm(opposite[:, None] + opposite, axis=2).argmin(axis=1)]
    found = [
        Alignment(surface.proxy, {}, 2.0, 0.5),
        Alignment(opposite, {}, 3.0, 0.1),
        Alignment(surface.proxy, {}, 1.0, 0.2),
    ]
    kept = distinct_alignments(surface, found, 0.1)
    assert [(one.cost, one.share) for one in kept] == [(1.0, 0.5), (3.0, 0.1)]
    assert kept[1].image is opposite


def test_iterative_registration_corrects_a_poor_map():
    """Every vertex of the proxy sent to another one within a fifth of sqrt(area)."""
    surface = mm.prepare(lump(3))
    generator = np.random.default_rng(0)
    places, scale = surface.mesh.vertices[surface.proxy], np.sqrt(surface.area)
    apart = np.linalg.norm(places[:, None] - surface.mesh.vertices, axis=2)
    poor = Alignment(np.array([generator.choice(np.flatnonzero(row < 0.2 * scale)) for row in apart]), {}, 0.0, 1.0)
    once = poor.registered(surface, surface, PARAMETERS)
    iterated = register_iteratively(surface, surface, poor, PARAMETERS)
    known = register_iteratively(surface, surface, replace(poor, registration=once), PARAMETERS)
    np.testing.assert_array_equal(known.positions, iterated.positions)

    def error(registration):
        return np.linalg.norm(registration.positions - places, axis=1).mean() / scale

    assert error(iterated) < 0.8 * error(once)
    assert error(iterated) < 0.02


def test_uniform_votes_have_no_alternatives():
    result = mm.match(lump(2), lump(2), preset="paper", votes=2000, samples=20)
    assert result.alternatives == ()
    assert len(result.votes.triplet_weights) == 0
