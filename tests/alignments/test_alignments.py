"""Alignments: clusters by hand, the identity's perfect score, and the choice on a nearly symmetric shape."""

from dataclasses import asdict, fields, replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment, register_iteratively
from mobius_match.alignments.candidates import candidate_alignments, distinct_alignments
from mobius_match.alignments.clusters import agreed_matches, cluster_triplets, most_consistent_half
from mobius_match.alignments.coarse_map import coarse_map, quick_image, refined_targets
from mobius_match.alignments.cost import cost_terms, total_cost
from mobius_match.alignments.parameters import AlignmentParameters, CostWeights
from mobius_match.alignments.selection import ambiguity_warnings, rerank_by_registration
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
    found = candidate_alignments(source, target, cast_votes(source, target, MatchSettings()), PARAMETERS)
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


def test_alternatives_are_sorted_by_how_much_more_they_cost(shipped_match):
    margins = [one.margin for one in shipped_match("person").alternatives]
    assert len(margins) > 0
    assert min(margins) > 0
    assert margins == sorted(margins)


def test_extremities_give_the_right_alignment_where_all_drawn_triplets_are_wrong(person):
    """Votes that send every sample to a random one."""
    source, target = person
    votes = cast_votes(source, target, MatchSettings())
    right = candidate_alignments(source, target, votes, PARAMETERS)[0]
    generator = np.random.default_rng(0)
    wrong = np.array([generator.permutation(len(target.samples))[:3] for _ in votes.triplet_weights])
    always = replace(PARAMETERS, selection=replace(SELECTION, different_above=0.0))  # as where shapes differ
    found = candidate_alignments(source, target, replace(votes, best_target=wrong), always)
    places = target.mesh.vertices / np.ptp(target.mesh.vertices, axis=0).max()
    apart = [np.linalg.norm(places[one.image] - places[right.image], axis=1).mean() for one in found]
    assert apart[0] < 0.03
    assert found[0].share == 0
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    assert min(apart[1:]) > 0.05, "no alignment is listed twice"


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


def test_shapes_that_differ_are_registered_iteratively():
    surface = mm.prepare(lump(3))
    rough = Alignment(np.roll(surface.proxy, 3), {}, SELECTION.different_above + 1, 1.0)
    (differing,) = rerank_by_registration(surface, surface, [rough], PARAMETERS)
    expected = register_iteratively(surface, surface, replace(rough, shapes_differ=True), PARAMETERS)
    np.testing.assert_array_equal(differing.registration.positions, expected.positions)
    assert differing.shapes_differ
    assert register_iteratively(surface, surface, differing, PARAMETERS) is differing.registration
    similar = replace(rough, cost=SELECTION.different_above - 1)
    (similar,) = rerank_by_registration(surface, surface, [similar], PARAMETERS)
    assert not similar.shapes_differ


def test_uniform_votes_have_no_alternatives():
    result = mm.match(lump(2), lump(2), preset="paper", votes=2000, samples=20)
    assert result.alternatives == ()
    assert len(result.votes.triplet_weights) == 0


def test_contenders_are_ranked_again_by_their_strain(surface):
    """A map to places that are mixed up locally strains the source: it loses, though it cost a little less before."""
    generator = np.random.default_rng(0)
    vertices = surface.mesh.vertices[surface.proxy]
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2).argsort(axis=1)[:, :60]
    mixed = surface.proxy[near[np.arange(len(near)), generator.integers(60, size=len(near))]]
    turned = surface.proxy[np.linalg.norm(vertices[:, None] + vertices, axis=2).argmin(axis=1)]
    right = Alignment(surface.proxy, {}, 1.1, 0.4)
    rivals = [Alignment(turned, {}, 1.0, 0.5), right, Alignment(mixed, {}, 3.5, 0.1)]
    ranked = rerank_by_registration(surface, surface, rivals, PARAMETERS)
    assert ranked[0].image is right.image
    assert ranked[0].cost_terms["strain"] < ranked[1].cost_terms["strain"]
    assert ranked[0].registration is ranked[0].registered(surface, surface, PARAMETERS)
    assert ranked[2] is rivals[2], "costs too much to be registered"
    alone = rerank_by_registration(surface, surface, [right], PARAMETERS)[0]
    assert (alone.cost, alone.image is right.image) == (right.cost, True)
    assert rerank_by_registration(surface, surface, [], PARAMETERS) == []


def test_contenders_are_registered_coarsely_and_fully(surface, monkeypatch):
    """Both strains weigh half. What is hopeless after the coarse one gets no full one; the winner keeps its own."""
    right = Alignment(surface.proxy, {}, 0.0, 1.0)
    rivals = [right, *(replace(right, image=np.roll(surface.proxy, i), cost=0.1) for i in (5, 9))]
    strains = iter([2.0, 3.5, 6.0, 20.0, 30.0])
    monkeypatch.setattr("mobius_match.alignments.selection.register_coarsely", lambda *_: "coarse")
    monkeypatch.setattr(
        "mobius_match.alignments.selection.strain", lambda *given: calls.append(given[2]) or next(strains)
    )
    calls = []
    ranked = rerank_by_registration(surface, surface, rivals, PARAMETERS)
    assert [one == "coarse" for one in calls] == [True, True, True, False, False]
    assert [one.cost_terms["strain"] for one in ranked] == [0, 6 - 2, (3.5 - 2 + 30 - 20) / 2]
    assert ranked[0].image is right.image
    assert ranked[0].registration is calls[3]


def test_a_close_choice_and_landmarks_that_fit_nowhere_are_warned_of(surface):
    best = Alignment(surface.proxy, {}, 1.0, 0.5)
    close = SELECTION.ambiguous_margin
    near, far = replace(best, cost=1.0 + 0.9 * close), replace(best, cost=1.0 + 1.1 * close)
    for clear in ([], [best], [best, far]):
        assert ambiguity_warnings(clear, PARAMETERS) == []
    (warning,) = ambiguity_warnings([best, near, far], PARAMETERS)
    assert f"margin {0.9 * close:.2f}" in warning
    (warning,) = ambiguity_warnings([replace(best, cost_terms={"landmarks": 0.2}), near], PARAMETERS)
    assert "landmarks agree with none" in warning
