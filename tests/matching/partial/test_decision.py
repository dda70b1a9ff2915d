"""Open surfaces: wholes, parts, or neither. A cut through a larger shape is no edge of a disc."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.matching.parameters import Parameters
from mobius_match.matching.partial import decision
from mobius_match.matching.partial.coverage import Coverage
from mobius_match.matching.partial.part import PartMatch
from mobius_match.registration.sparse import register
from tests.shapes import bent, cap, disc, grid, icosphere, rotation

PARAMETERS = Parameters()


@pytest.fixture(scope="module")
def sheet():
    return mm.prepare(bent(grid(16, 13)))


@pytest.fixture(scope="module")
def source():
    return mm.prepare(cap(0))


@pytest.fixture(scope="module")
def ball():
    return mm.prepare(icosphere(2))


@pytest.mark.parametrize(
    ("as_part", "as_whole", "cost", "fit", "expected"),
    [
        (0.2, 0.64, 1.0, False, Coverage.PART),
        (0.2, 0.64, 1.0, True, Coverage.WHOLE),
        (0.2, 0.48, 1.0, False, Coverage.WHOLE),
        (0.2, 0.32, 2.0, False, Coverage.PART),
        (0.2, 0.12, 3.6, False, Coverage.BOTH_INCOMPLETE),
    ],
)
def test_coverage_of_two_surfaces_with_large_openings(monkeypatch, sheet, ball, as_part, as_whole, cost, fit, expected):
    """By the error of distances times the cost of the placement, or of the map that wholes are registered along."""
    match = PartMatch(*[object()] * 6)
    located = SimpleNamespace(match=lambda: match, placement=SimpleNamespace(cost=1.0))
    monkeypatch.setattr(decision, "part_error", lambda _: as_part)
    monkeypatch.setattr(decision, "whole_error", lambda *_: as_whole)
    monkeypatch.setattr(decision, "fit_as_wholes", lambda *_: fit)
    monkeypatch.setattr(decision, "part_notes", lambda _, compared: [compared])
    monkeypatch.setattr(decision, "registered_map_cost", lambda *_: cost)
    alignment = SimpleNamespace(registered=lambda *_: object())
    constants = PARAMETERS.partial, PARAMETERS.alignment
    coverage, found, notes = decision.choose_coverage(sheet, sheet, lambda: [located], [alignment], *constants)
    assert coverage is expected
    assert found is None if expected is not Coverage.PART else (found.points, found.cost) == (match.points, as_part)
    assert f"cost {cost * as_whole:.3g} as wholes, 0.2 as a part" in notes[0]
    assert any("both have large openings" in note for note in notes) == (expected is Coverage.BOTH_INCOMPLETE)
    assert decision.choose_coverage(sheet, ball, list, [alignment], *constants) == (Coverage.WHOLE, None, [])


def test_no_part_is_looked_for_where_the_wholes_agree(monkeypatch, sheet):
    monkeypatch.setattr(decision, "whole_error", lambda *_: 0.06)
    monkeypatch.setattr(decision, "registered_map_cost", lambda *_: 9.0)
    alignment = SimpleNamespace(registered=lambda *_: object())
    constants = PARAMETERS.partial, PARAMETERS.alignment
    coverage, found, notes = decision.choose_coverage(sheet, sheet, pytest.fail, [alignment], *constants)
    assert (coverage, found) == (Coverage.WHOLE, None)
    assert "distances agree to 6%" in notes[0]


def test_the_gap_between_rims(source, ball):
    arrays, surface = cap(0), source
    inside = arrays[1][(np.abs(arrays[0][arrays[1], :2]) < 0.6).all(axis=(1, 2))]
    used = np.unique(inside)
    smaller = mm.prepare((arrays[0][used], np.searchsorted(used, inside)))
    constants = PARAMETERS.alignment.registration
    same = register(surface, surface, surface.proxy, constants)
    assert decision.rim_gap(surface, surface, same) < 0.02
    within = register(smaller, surface, used[smaller.proxy], constants, whole=False)
    assert decision.rim_gap(smaller, surface, within) > 0.1
    assert decision.rim_gap(surface, ball, same) == np.inf


def displacements(pairs, kept=None):
    """Distances in the flat disc between matched vertices of the meshes of seeds 0 and 1."""
    one, two = disc(1500, seed=0)[0], disc(1500, seed=1)[0]
    return np.linalg.norm((one if kept is None else one[kept])[pairs[:, 0]] - two[pairs[:, 1]], axis=1)


@pytest.mark.parametrize(("size", "bend"), [(0.9, 0.5), (300.0, 0.0)])
def test_two_discs_of_other_sizes_are_not_parts_of_each_other(source, size, bend):
    vertices, faces = cap(1, bend=bend)
    result = mm.match(source, (size * vertices @ rotation(2), faces))
    assert not any("partial" in warning for warning in result.warnings)
    assert len(result.pairs) > 500
    assert displacements(result.pairs).mean() < 0.05
    dense = result.dense().vertex_map
    every = np.stack([np.flatnonzero(dense >= 0), dense[dense >= 0]], axis=1)
    assert len(every) > 0.98 * len(source.mesh.vertices)
    assert displacements(every).mean() < 0.05


def test_a_cut_through_a_disc_is_no_edge_of_it():
    vertices, faces = cap(0)
    faces = faces[(vertices[faces, 0] > -0.3).all(axis=1)]
    kept = np.unique(faces)
    fewer = replace(PARAMETERS.partial, triplets=4000, sizing_triplets=1000)
    parameters = Parameters(partial=fewer)
    result = mm.match((vertices[kept], np.searchsorted(kept, faces)), cap(1), parameters=parameters)
    assert any("treated as a partial scan" in warning for warning in result.warnings)
    assert len(result.pairs) > 50
    assert displacements(result.pairs, kept).max() < 0.2
