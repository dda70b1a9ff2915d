"""Halves of the shipped bodies, matched with whole ones: right, and nothing on what is missing."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match import examples
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.locating import Pair
from mobius_match.mesh.topology import components
from mobius_match.partial import is_part, part_places
from mobius_match.voting.agreement import BATCH, agreement, as_far
from tests.shapes import bent, grid, lump

NEAR = 0.05
"""Per diameter of the whole."""

HALVES = {
    "person, upper half": ("person", 1, 1.0),
    "person, lower half": ("person", 1, -1.0),
    "quadruped, half": ("quadruped", None, -1.0),
}


def cut(vertices, faces, axis, side):
    """The faces on one side of the middle, across the longest axis if none is given; numbers of their vertices."""
    axis = np.ptp(vertices, axis=0).argmax() if axis is None else axis
    height = side * (vertices[:, axis] - vertices[:, axis].mean())
    part = faces[(height[faces] > 0).all(axis=1)]
    _, label = components(part)
    part = part[label == np.bincount(label).argmax()]
    kept = np.unique(part)
    return vertices[kept], np.searchsorted(kept, part), kept


@pytest.fixture(scope="module")
def wholes():
    return {name: tuple(mm.prepare(path) for path in examples.paths(name)) for name in examples.names()}


@pytest.fixture(scope="module", params=HALVES)
def half(request, wholes):
    """A half of a body, the numbers of its vertices there, the body, and the body in its other pose."""
    name, axis, side = HALVES[request.param]
    whole, other = wholes[name]
    vertices, faces, kept = cut(whole.mesh.vertices, whole.mesh.faces, axis, side)
    return mm.prepare((vertices, faces)), kept, whole, other, name


def true_places(name, reverse, other):
    faces, barycentric = examples.truth(name, reverse=reverse)
    return np.einsum("ijk,ij->ik", other.mesh.vertices[other.mesh.faces[faces]], barycentric)


def right(surface, found, places):
    """Share of vertices (q,) that are within 5 % of the diameter of places (q, 3), along the surface."""
    solve = geodesic_solver(surface.mesh.vertices, surface.mesh.faces)
    nearest = np.linalg.norm(surface.mesh.vertices[:, None] - places, axis=2).argmin(axis=0)
    return np.mean([solve(int(a))[b] <= NEAR * surface.diameter for a, b in zip(found, nearest, strict=True)])


def test_half_to_the_other_pose(half, wholes):
    part, kept, _, other, name = half
    result = mm.match(part, other)
    assert len(result) >= 60
    assert right(other, result.pairs[:, 1], true_places(name, False, other)[kept[result.pairs[:, 0]]]) >= 0.9
    assert any("matched as a part" in warning for warning in result.warnings)


def test_other_pose_to_half(half, wholes):
    part, kept, whole, other, name = half
    result = mm.match(other, part)
    assert len(result) >= 20
    places = true_places(name, True, whole)[result.pairs[:, 0]]
    assert right(whole, kept[result.pairs[:, 1]], places) >= 0.9
    # Nothing whose true place is on what was cut off.
    gaps = np.linalg.norm(whole.mesh.vertices[kept][:, None] - places, axis=2).min(axis=0)
    assert (gaps <= NEAR * whole.diameter).all()


def test_half_to_its_own_whole(half):
    part, kept, whole, _, _ = half
    result = mm.match(part, whole)
    assert len(result) >= 80
    assert right(whole, result.pairs[:, 1], whole.mesh.vertices[kept[result.pairs[:, 0]]]) >= 0.97
    dense = result.dense()
    assert np.linalg.norm(dense.positions - part.mesh.vertices, axis=1).mean() < 0.005 * np.sqrt(whole.area)
    # What was cut off has no counterpart, what was kept has.
    covered = np.zeros(len(whole.mesh.vertices), bool)
    covered[kept] = True
    assert dense.inverse.found[covered].mean() > 0.95
    gap = np.linalg.norm(whole.mesh.vertices[:, None] - part.mesh.vertices, axis=2).min(axis=1)
    assert not dense.inverse.found[gap > 0.05 * np.sqrt(whole.area)].any()


def test_half_of_another_size(wholes):
    """A quarter too large: found all the same, and the note says how large."""
    whole, other = wholes["quadruped"]
    vertices, faces, kept = cut(whole.mesh.vertices, whole.mesh.faces, None, -1.0)
    part = mm.prepare((1.25 * vertices, faces))
    places, note = part_places(part, other, 0)
    assert "at 0.83 times its size" in note
    sure = places.chances >= 0.5
    assert sure.sum() >= 50
    true = true_places("quadruped", False, other)[kept[part.samples[sure]]]
    assert right(other, places.points.nearest[sure], true) >= 0.9


def test_orientation_of_maps(wholes):
    """1 for the surface on itself, -1 for its mirror image, about 0 for any map."""
    whole, _ = wholes["person"]
    turned = np.stack([-whole.mesh.vertices[:, 0], *whole.mesh.vertices[:, 1:].T], axis=1)
    # The same faces: what looked outwards looks inwards.
    mirrored = replace(whole, mesh=replace(whole.mesh, vertices=turned, faces=whole.mesh.faces[:, ::-1]))
    same = np.arange(len(whole.proxy))
    assert Pair(whole, whole).orientation(same) == 1
    assert Pair(whole, mirrored).orientation(same) == -1
    assert abs(Pair(whole, whole).orientation(np.random.default_rng(0).permutation(same))) < 0.1


@pytest.mark.parametrize("name", examples.names())
def test_whole_surfaces_are_no_parts(name, wholes):
    first, second = wholes[name]
    assert not is_part(first, second) and not is_part(second, first)
    assert part_places(first, second, 0) == (None, "")


def test_a_part_of_nothing_there():
    """A flat sheet is found nowhere on the lump, which is nowhere flat; it may be the whole in other units."""
    whole = mm.prepare(lump())
    sheet, squares = bent(grid(16, 13))
    part = mm.prepare((sheet * np.sqrt(whole.area / 9 / 260), squares))
    places, note = part_places(part, whole, 0)
    assert places is None
    assert "matched as a whole" in note


@pytest.mark.parametrize("threads", [1, 3])
def test_agreement_is_the_formula(threads):
    generator = np.random.default_rng(0)
    first, second = generator.random((5, 7), np.float32), generator.random((6, 9), np.float32)
    costs = generator.random((7, 9), np.float32)
    triplets = tuple(generator.integers(0, len(side), (2 * BATCH + 1, 3)) for side in (first, second))
    with ThreadPoolExecutor(threads) as pool:
        totals = agreement(first, second, costs, *triplets, 0.3, pool)
    apart = np.abs(first[triplets[0]][..., None] - second[triplets[1]][:, :, None]).sum(axis=1) + costs
    np.testing.assert_allclose(totals, np.exp(-apart.min(axis=2) / 0.3).mean(axis=1), rtol=1e-5)


def test_as_far_is_the_formula():
    generator = np.random.default_rng(0)
    first, second = generator.random((5, 7), np.float32), generator.random((5, 9), np.float32)
    costs = generator.random((7, 9), np.float32)
    apart = np.minimum(np.abs(first[:, :, None] - second[:, None]), 0.4).sum(axis=0)
    np.testing.assert_array_equal(as_far(first, second, 0.4, 2.0, costs), (2 * apart + costs).argmin(axis=1))


def test_a_copy_in_other_units_is_the_whole():
    vertices, faces = bent(grid(20, 17))
    result = mm.match((vertices, faces), (3 * vertices + 1, faces), seed=0)
    np.testing.assert_array_equal(result.pairs[:, 0], result.pairs[:, 1])
    np.testing.assert_array_equal(result.dense().vertices, np.arange(len(vertices)))
    assert not any("part of it" in line for line in result.warnings)
