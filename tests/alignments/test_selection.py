"""The evidence for alignments, their probabilities, and the choice."""

from dataclasses import fields, replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment, register_iteratively
from mobius_match.alignments.candidates import Candidates
from mobius_match.alignments.evidence import evidence, log_odds
from mobius_match.alignments.parameters import AlignmentParameters, Evidence
from mobius_match.alignments.poses import rigid_images
from mobius_match.alignments.selection import (
    choice_warnings,
    choose_alignment,
    probabilities,
    with_probabilities,
)
from mobius_match.geometry.rotations import rigid_residual
from mobius_match.registration.sparse import register
from tests.shapes import ellipsoid, lump

PARAMETERS = AlignmentParameters()
SELECTION = PARAMETERS.selection
NOTHING_FURTHER = replace(PARAMETERS, selection=replace(SELECTION, sure_above=0.0))


@pytest.fixture(scope="module")
def surface(lump_surface):
    return lump_surface


@pytest.fixture(scope="module")
def opposite(surface):
    """The map of the proxy that sends each point to the one on the other side."""
    places = surface.mesh.vertices[surface.proxy]
    return surface.proxy[np.linalg.norm(places[:, None] + places, axis=2).argmin(axis=1)]


def evidence_for(surface, image, target=None):
    target = target or surface
    registration = register(surface, target, image, PARAMETERS.registration)
    return evidence(surface, target, registration)


def test_nothing_speaks_against_the_identity(surface):
    found = evidence_for(surface, surface.proxy)
    assert found.values().max() < 0.02
    assert found.values().min() >= -1e-6


def test_every_term_is_bounded_and_larger_for_a_wrong_map(surface, opposite):
    right, wrong = evidence_for(surface, surface.proxy), evidence_for(surface, opposite)
    for name in (one.name for one in fields(Evidence)):
        assert getattr(right, name) < getattr(wrong, name) < 3, name
    assert log_odds([right], PARAMETERS.choice) > log_odds([wrong], PARAMETERS.choice) + 2


def test_evidence_does_not_depend_on_units_and_motions(surface):
    moved = mm.prepare((3 * surface.mesh.vertices[:, [1, 2, 0]] + 5, surface.mesh.faces))
    here, there = evidence_for(surface, surface.proxy), evidence_for(surface, moved.proxy, moved)
    np.testing.assert_allclose(there.values(), here.values(), atol=0.02)


def test_probabilities_leave_room_for_none():
    assert probabilities(np.array([0.0])) == pytest.approx([0.5])
    assert probabilities(np.array([0.0, 0.0, 0.0])) == pytest.approx([0.25] * 3)
    assert probabilities(np.array([-800.0, -900.0])).max() == 0.0
    assert probabilities(np.array([900.0, 800.0])) == pytest.approx([1, 0])
    found = probabilities(np.log([3.0, 2.0]))
    assert found == pytest.approx([3 / 6, 2 / 6])


def test_landmarks_that_are_missed_count_against_an_alignment(surface):
    one = Alignment(surface.proxy, {}, 1.0, 0.5, evidence=evidence_for(surface, surface.proxy))
    missed = replace(one, cost_terms={"landmarks": 0.5})
    first, second = with_probabilities([missed, one], PARAMETERS)
    assert (first.cost_terms, second.cost_terms) == ({}, {"landmarks": 0.5})
    weight = PARAMETERS.cost.weights.landmarks
    assert np.log(first.probability / second.probability) == pytest.approx(0.5 * weight)
    assert with_probabilities([], PARAMETERS) == []


def test_the_right_alignment_is_chosen_though_it_costs_more(surface, opposite):
    candidates = Candidates(surface, surface, NOTHING_FURTHER)
    right = Alignment(surface.proxy, {}, 1.1, 0.4)
    costly = Alignment(np.roll(surface.proxy, 9), {}, 1.0 + SELECTION.contest_margin + 0.1, 0.1)
    found = choose_alignment(candidates, [Alignment(opposite, {}, 1.0, 0.5), right, costly])
    assert found[0].image is right.image
    assert found[0].probability > 0.5 > found[1].probability
    assert found[0].registration is found[0].registered(surface, surface, PARAMETERS)
    assert found[2] is costly, "costs too much to be registered"
    assert found[2].probability == 0
    assert choose_alignment(replace(candidates, parameters=NOTHING_FURTHER), [right])[0].image is right.image


def test_where_no_alignment_is_sure_others_are_looked_for(surface, opposite):
    (wrong, *others) = [Alignment(opposite, {}, 1.0, 1.0)]
    found = choose_alignment(Candidates(surface, surface, PARAMETERS), [wrong, *others])
    places = surface.mesh.vertices / surface.scale
    assert np.linalg.norm(places[found[0].image] - places[surface.proxy], axis=1).mean() < 0.03
    assert any(one.image is wrong.image for one in found[1:])


def test_shapes_that_differ_are_registered_iteratively():
    surface = mm.prepare(lump(3))
    candidates = Candidates(surface, surface, NOTHING_FURTHER)
    rough = Alignment(np.roll(surface.proxy, 3), {}, SELECTION.different_above + 1, 1.0)
    (differing,) = choose_alignment(candidates, [rough])
    expected = register_iteratively(surface, surface, replace(rough, shapes_differ=True), PARAMETERS)
    np.testing.assert_array_equal(differing.registration.positions, expected.positions)
    assert differing.shapes_differ
    assert register_iteratively(surface, surface, differing, PARAMETERS) is differing.registration
    (similar,) = choose_alignment(candidates, [replace(rough, cost=SELECTION.different_above - 1)])
    assert not similar.shapes_differ


def test_a_doubtful_choice_and_landmarks_that_fit_nowhere_are_warned_of(surface):
    sure = Alignment(surface.proxy, {}, 1.0, 0.5, probability=SELECTION.doubted_below)
    assert choice_warnings([], PARAMETERS) == []
    assert choice_warnings([sure, replace(sure, probability=0.2)], PARAMETERS) == []
    for chances, words in (
        ((0.45, 0.4), "ambiguous: .* 0.45 and 0.40"),
        ((0.4, 0.1), "doubtful: .* 0.40"),
        ((0.05, 0.04), "may not belong together: .* 0.05"),
    ):
        (warning,) = choice_warnings([replace(sure, probability=chance) for chance in chances], PARAMETERS)
        assert np.char.find(warning, words.split(":")[0]) >= 0
        assert all(part in warning for part in words.split(".* ")[1].split(" and "))
    (warning,) = choice_warnings([replace(sure, cost_terms={"landmarks": 0.2})], PARAMETERS)
    assert "landmarks agree with none" in warning


def test_a_rigid_motion_explains_a_moved_copy_and_no_mirror_image():
    points = np.random.default_rng(0).standard_normal((50, 3)) * [3, 2, 1]
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    assert rigid_residual(points, 4 * points @ turn + 7) == pytest.approx(0, abs=1e-12)
    assert rigid_residual(points, points * [1, 1, -1]) > 0.1
    assert rigid_residual(points, np.zeros((50, 3))) == 1


def test_motions_lay_a_turned_ellipsoid_over_itself_in_all_ways():
    """An ellipsoid of three different axes has four rotations onto itself."""
    vertices, faces = ellipsoid((1.0, 0.7, 0.45))
    source = mm.prepare((vertices, faces))
    turned = mm.prepare((2 * vertices[:, [2, 0, 1]], faces))
    images = rigid_images(source, turned, PARAMETERS.poses)
    assert len(images) == 4
    places, there = vertices[source.proxy], vertices[turned.proxy]
    gaps = [
        min(
            np.linalg.norm(places * signs - there[image], axis=1).mean()
            for signs in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
        )
        for image in images
    ]
    assert max(gaps) < 0.05


def test_the_symmetry_of_an_ellipsoid_is_named():
    """Three half turns and the identity take it to itself; the four alignments share the probability."""
    result = mm.match(ellipsoid((1.0, 0.7, 0.45), 3), ellipsoid((2.0, 1.4, 0.9), 4), seed=0)
    assert result.symmetry == {"order": 4}
    assert result.probability > 0.9
    assert result.confidence.max() > 0.8
    assert any("look the same in 4 alignments" in warning for warning in result.warnings)
    assert result.to_dict()["symmetry"] == {"order": 4}


def test_alignments_that_end_in_one_registration_count_once(surface):
    """A map that is mixed up within small neighbourhoods ends where the right one does."""
    vertices = surface.mesh.vertices[surface.proxy]
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2).argsort(axis=1)[:, :8]
    generator = np.random.default_rng(0)
    mixed = surface.proxy[near[np.arange(len(near)), generator.integers(8, size=len(near))]]
    right = Alignment(surface.proxy, {}, 1.0, 0.5)
    found = choose_alignment(Candidates(surface, surface, NOTHING_FURTHER), [right, Alignment(mixed, {}, 1.1, 0.5)])
    assert [one.order for one in found] == [1]
    alone = choose_alignment(Candidates(surface, surface, NOTHING_FURTHER), [right])
    assert found[0].probability == pytest.approx(alone[0].probability, abs=0.02)
