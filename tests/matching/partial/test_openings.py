"""How large the openings of surfaces are whose rims are known."""

from dataclasses import replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.matching.partial.coverage import may_be_part
from mobius_match.matching.partial.openings import openings
from mobius_match.matching.partial.parameters import PartialParameters
from tests.shapes import grid, icosphere, torus, tube


def test_a_tube_has_two_round_rims():
    surface = mm.prepare(tube(around=48, along=30, radius=1.0, length=4.0))
    found = openings(surface)
    assert found.longest * surface.scale == pytest.approx(2 * np.pi, rel=0.01)
    assert found.missing * surface.area == pytest.approx(2 * np.pi, rel=0.01)


@pytest.mark.parametrize("factor", [0.001, 0.6, 1000.0])
def test_openings_have_no_unit(factor):
    vertices, faces = grid(16, 13, holes=((4, 4), (9, 6)))
    first, second = (openings(mm.prepare((scale * vertices, faces))) for scale in (1.0, factor))
    assert (second.longest, second.missing) == pytest.approx((first.longest, first.missing))


def test_a_closed_surface_has_none():
    found = openings(mm.prepare(icosphere(2)))
    assert (found.longest, found.missing) == (0, 0)


def test_a_jagged_rim_encloses_what_a_smooth_one_does():
    """Every second triangle along the equator is missing: the rim is longer, and its cap hardly larger."""
    vertices, faces = icosphere(4)
    height = vertices[faces].mean(axis=1)[:, 2]
    surface = mm.prepare((vertices, faces[height > 0]))
    found = openings(surface)
    assert found.missing * surface.area == pytest.approx(np.pi, rel=0.03)
    assert found.missing <= found.longest**2 / (4 * np.pi)


def test_a_handle_cut_open_is_no_opening():
    surface = mm.prepare(torus())
    assert len(surface.loops) > 0
    found = openings(surface)
    assert (found.longest, found.missing) == (0, 0)
    uncut = replace(surface, loops=np.empty(0, np.int64))
    assert openings(uncut).longest > 0


def test_many_small_holes_make_no_part():
    """However long their rims are in total."""
    vertices, faces = icosphere(4)
    generator, kept = np.random.default_rng(0), np.ones(len(faces), bool)
    for centre in generator.permutation(len(faces)):
        around = np.isin(faces, faces[centre]).any(axis=1)
        if kept[around].all() and kept.sum() > 0.97 * len(faces):
            kept[centre] = False
    surface = mm.prepare((vertices, faces[kept]))
    assert surface.mesh.notes == ()
    rims = len(faces) - kept.sum()
    assert rims * openings(surface).longest > 10 * PartialParameters().opening
    assert not may_be_part(surface, PartialParameters())


def test_a_half_may_be_a_part():
    vertices, faces = icosphere(3)
    assert may_be_part(mm.prepare((vertices, faces[(vertices[faces][..., 2] >= 0).all(axis=1)])), PartialParameters())
