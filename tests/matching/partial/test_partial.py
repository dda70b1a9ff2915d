"""Halves of the shipped bodies, matched with whole ones: right, and nothing on what is missing."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.geometry.directions import directions
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.geometry.normals import vertex_normals
from mobius_match.matching.parameters import Parameters
from mobius_match.matching.partial.agreement import BATCH, Paths, agreement, images_by_triplets, match_by_distances
from mobius_match.matching.partial.decision import part_notes
from mobius_match.matching.partial.locate import Placement
from mobius_match.matching.partial.matches import match_probabilities, probability, support
from mobius_match.matching.partial.pair import PartPair
from mobius_match.matching.partial.parameters import PartialParameters
from mobius_match.matching.partial.part import locate_parts
from mobius_match.mesh.topology import components
from mobius_match.registration.parameters import RegistrationParameters
from mobius_match.registration.sparse import register
from tests.shapes import bent, grid, icosphere, lump, rotation

PARAMETERS, REGISTRATION = PartialParameters(), RegistrationParameters()

FEWER = replace(PARAMETERS, triplets=4000, sizing_triplets=1000)
"""Enough where it does not matter how good the matches are."""

NEAR = 0.05
"""Per diameter of the whole."""

HALVES = {
    "person, upper half": ("person", 1, 1.0),
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
def wholes(shipped):
    return {name: shipped(name) for name in examples.names()}


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
    assert any("treated as a partial scan" in warning for warning in result.warnings)


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
    assert dense.inverse.source_mapped[covered].mean() > 0.95
    gap = np.linalg.norm(whole.mesh.vertices[:, None] - part.mesh.vertices, axis=2).min(axis=1)
    assert not dense.inverse.source_mapped[gap > 0.05 * np.sqrt(whole.area)].any()


@pytest.mark.parametrize("factor", [1.25, 1000.0], ids=["a quarter larger", "in other units"])
def test_half_of_another_size(wholes, factor):
    """Found all the same, and the size is known."""
    whole, other = wholes["quadruped"]
    vertices, faces, kept = cut(whole.mesh.vertices, whole.mesh.faces, None, -1.0)
    part = mm.prepare((factor * vertices, faces))
    (located,) = locate_parts(part, other, FEWER, REGISTRATION, 0)
    assert located.size == pytest.approx(1 / factor, rel=0.06)
    places = located.match()
    sure = places.match_probabilities >= 0.5
    assert sure.sum() >= 50
    true = true_places("quadruped", False, other)[kept[part.samples[sure]]]
    assert right(other, places.points.nearest[sure], true) >= 0.9


def test_angles_agree_under_the_right_map_only(wholes):
    """Paths run alike under the right map, and not on the mirror image."""
    whole, _ = wholes["person"]
    turned = np.stack([-whole.mesh.vertices[:, 0], *whole.mesh.vertices[:, 1:].T], axis=1)
    # The same faces would look inwards.
    mirrored = replace(whole, mesh=replace(whole.mesh, vertices=turned, faces=whole.mesh.faces[:, ::-1]))
    same = np.arange(len(whole.proxy))
    agreement = PartPair(whole, whole, PARAMETERS, REGISTRATION).angle_agreement(same)
    assert np.median(agreement) == pytest.approx(1, abs=1e-5)
    assert agreement.mean() > 0.99  # a point on a thin edge may have no direction
    assert PartPair(whole, mirrored, PARAMETERS, REGISTRATION).angle_agreement(same).mean() < 0.8
    at_random = np.random.default_rng(0).permutation(same)
    assert PartPair(whole, whole, PARAMETERS, REGISTRATION).angle_agreement(at_random).mean() < 0.6


def test_a_part_keeps_its_area_and_is_measured_in_units_of_the_whole(wholes):
    """Half the size in the file and size 2 give what the file of the right size does."""
    whole, other = wholes["quadruped"]
    vertices, faces, _ = cut(whole.mesh.vertices, whole.mesh.faces, None, -1.0)
    part = mm.prepare((vertices, faces))
    mesh = replace(part.mesh, vertices=part.mesh.vertices / 2)
    smaller = replace(
        part,
        mesh=mesh,
        area=part.area / 4,
        distances=part.distances / 2,
        proxy_distances=part.proxy_distances / 2,
    )
    right = PartPair(part, other, PARAMETERS, REGISTRATION)
    pair = PartPair(smaller, other, PARAMETERS, REGISTRATION).scaled(2.0)
    assert (pair.part.area, pair.part.scale) == (smaller.area, np.sqrt(other.area) / 2)
    np.testing.assert_allclose(pair.part.normalized_distances, right.part.normalized_distances, rtol=1e-12)
    np.testing.assert_allclose(right.part.normalized_distances, part.distances / other.scale, rtol=1e-12)
    np.testing.assert_allclose(pair.paths1.lengths, right.paths1.lengths, rtol=1e-6)
    np.testing.assert_allclose(pair.curvatures1, right.curvatures1, rtol=1e-6, atol=1e-6)
    image = np.random.default_rng(0).integers(0, len(other.proxy), len(part.proxy))
    first, second = (
        register(one.part, other, other.proxy[image], REGISTRATION, schedule=REGISTRATION.schedule(4, 1), whole=False)
        for one in (pair, right)
    )
    np.testing.assert_allclose(first.residual, second.residual, atol=1e-9)
    assert pair.cost(first) == pytest.approx(right.cost(second), rel=1e-6)


def proxy_directions(vertices, faces, distances):
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    x, y = directions(vertices, vertex_normals(vertices, faces), edges, distances)
    return x + 1j * y


def test_directions_in_the_plane():
    """Away from the point that distances are from, to either side of it the other way."""
    vertices, faces = grid(15, 11)
    away = vertices - vertices[80]
    found = proxy_directions(vertices, faces, np.stack([np.linalg.norm(away, axis=1), vertices[:, 0]]))
    inside = ((vertices[:, :2] > 1) & (vertices[:, :2] < (13, 9))).all(axis=1)
    far = inside & (np.linalg.norm(away, axis=1) > 3)
    np.testing.assert_allclose(np.abs(found[1]), 1, atol=1e-5)
    # Frames are turned anyhow; the angle to the first axis is not.
    between = (found[0] * found[1].conj())[far]
    angle = np.arctan2(away[far, 1], away[far, 0])
    np.testing.assert_allclose(between, np.exp(1j * angle), atol=0.1)


def test_directions_move_with_the_surface():
    vertices, faces = icosphere()
    distances = np.arccos(np.clip(vertices @ vertices[[0, 5, 9]].T, -1, 1)).T
    first = proxy_directions(vertices, faces, distances)
    there = vertices @ rotation(1).T
    for second, sign in (
        (proxy_directions(there, faces, distances), 1),
        (proxy_directions(there * (-1, 1, 1), faces[:, ::-1], distances), -1),
    ):
        for i, j in ((0, 1), (1, 2)):
            one, two = first[i] * first[j].conj(), second[i] * second[j].conj()
            np.testing.assert_allclose(two, one.real + sign * 1j * one.imag, atol=1e-4)


def test_halves_that_lack_each_other(wholes):
    """An upper half and a lower one, which share nothing: no match, and the reason."""
    halves = []
    for surface, side in zip(wholes["person"], (1.0, -1.0), strict=True):
        halves.append(cut(surface.mesh.vertices, surface.mesh.faces, 1, side)[:2])
    with pytest.raises(mm.NothingFoundError, match="large openings"):
        mm.match(*halves, parameters=Parameters(partial=FEWER))


def test_rivals_share_the_chances():
    """Where they agree, it matters little which is right."""
    apart = [np.array([0.0, 0.2, 0.2]), np.array([0.0, 0.0, 0.3])]
    place = Placement(SimpleNamespace(image=np.arange(3)), 1.0, list(zip((0.0, 0.0), apart, strict=True)))
    np.testing.assert_allclose(support(place, PARAMETERS), [1, 1 / 2, 1 / 3])
    assert place.margin == 0
    clear = replace(place, rivals=[(1.0, apart[0])])
    np.testing.assert_allclose(support(clear, PARAMETERS), 1, atol=1e-6)
    assert support(replace(place, rivals=[]), PARAMETERS).tolist() == [1, 1, 1]


def test_no_match_is_likely_next_to_the_cut(monkeypatch):
    """However good everything else is."""
    good = {"distances": 0.0, "residual": 0.0, "boundary": 0.5, "stretch": 0.0, "cost": 0.5}
    found = {kind: np.full(2, value) for kind, value in good.items()}
    found["boundary"][1] = 0.9 * PARAMETERS.boundary_margin
    monkeypatch.setattr("mobius_match.matching.partial.matches.features", lambda *_: found)
    closed = SimpleNamespace(whole=mm.prepare(icosphere(2)), parameters=PARAMETERS, registration=REGISTRATION)
    placement = Placement(SimpleNamespace(image=np.arange(2)), 1.0, [])
    first, second = match_probabilities(closed, placement)
    assert first > 0.5
    assert second == 0


@pytest.mark.parametrize("kind", ["distances", "residual", "stretch", "cost"])
def test_probability_falls_with_each_error(kind):
    """Without bound, so that whatever was torn off the rest is unlikely; and with all of them small it is near 1."""
    good = {"distances": 0.01, "residual": 0.005, "boundary": 0.3, "stretch": 0.03, "cost": 0.7}
    found = {name: np.full(60, value) for name, value in good.items()}
    found[kind] = good[kind] * np.geomspace(1, 1e4, 60)
    values = probability(found, PARAMETERS, 0.01)
    assert values[0] > 0.9
    assert (np.diff(values) < 0).all()
    assert values[-1] < 0.5


def vase(turns, height=36):
    """A surface of revolution, closed."""
    angle = 2 * np.pi * np.arange(turns) / turns
    level = np.pi * np.arange(1, height) / height
    radius = np.sin(level) * (1 + 0.25 * np.cos(3 * level))
    around = np.stack([np.cos(angle), np.sin(angle), np.ones(turns)], axis=1)
    rings = np.stack([radius, radius, 1.6 * np.cos(level)], axis=1)[:, None] * around
    vertices = np.concatenate([rings.reshape(-1, 3), [[0, 0, 1.6], [0, 0, -1.6]]])
    here = np.arange(turns)
    there, last = (here + 1) % turns, (height - 2) * turns
    top, bottom = len(vertices) - 2, len(vertices) - 1
    faces = [np.stack([np.full(turns, top), here, there], axis=1)]
    for k in range(0, last, turns):
        faces.append(np.stack([k + here, k + turns + here, k + there], axis=1))
        faces.append(np.stack([k + there, k + turns + here, k + turns + there], axis=1))
    faces.append(np.stack([np.full(turns, bottom), last + there, last + here], axis=1))
    return vertices, np.concatenate(faces)


def test_a_close_choice_is_reported():
    """Half a vase, cut along its axis, fits it all around, but for its triangles."""
    half = cut(*vase(37), 0, 1.0)
    parameters = replace(FEWER, close_margin=0.3)
    (located,) = locate_parts(mm.prepare(half[:2]), mm.prepare(vase(40)), parameters, REGISTRATION, 0)
    notes = part_notes(located, "")
    assert any("almost as well (margin 0." in note and "below 0.3 is close" in note for note in notes)


@pytest.mark.parametrize("name", examples.names())
def test_closed_surfaces_are_no_parts(name, wholes):
    first, second = wholes[name]
    assert locate_parts(first, second, PARAMETERS, REGISTRATION, 0) == []


def punched(surface, share, number=4, seed=0):
    """A mesh with round holes apart from each other, of that share of the faces in total; all vertices are left."""
    vertices, faces = surface.mesh.vertices, surface.mesh.faces
    centres = vertices[surface.samples[np.random.default_rng(seed).permutation(20)[:number]]]
    distances = np.linalg.norm(vertices[faces].mean(axis=1)[:, None] - centres, axis=2)
    nearest = np.argsort(distances, axis=0)[: round(share * len(faces) / number)]
    return vertices, np.delete(faces, np.unique(nearest), axis=0)


@pytest.mark.parametrize(("share", "factor", "reverse"), [(0.004, 1000.0, False), (0.018, 0.6, True)])
def test_a_shape_with_holes_is_a_whole(wholes, shipped_match, share, factor, reverse):
    """In other units, the source or the target: as many matches as without holes, and nearly the same ones."""
    first, second = wholes["person"]
    vertices, faces = punched(second, share)
    holes = mm.prepare((factor * vertices, faces))
    result = mm.match(holes, first) if reverse else mm.match(first, holes)
    clean = mm.match(second, first) if reverse else shipped_match("person")
    assert len(result) >= 0.95 * len(clean)
    target = first if reverse else second
    places = true_places("person", reverse, target)[result.pairs[:, 0]]
    assert right(target, result.pairs[:, 1], places) >= 0.98
    before = dict(clean.pairs.tolist())
    common = [(before[one], other) for one, other in result.pairs.tolist() if one in before]
    apart = np.linalg.norm(np.diff(target.mesh.vertices[np.array(common)], axis=1), axis=2)
    assert len(common) >= 0.2 * len(clean)  # the proxy of each is drawn by its own area
    assert (apart <= NEAR * target.diameter).mean() >= 0.98


def test_units_change_no_match():
    """A power of two changes no bit; for other factors a distance may be rounded the other way, see above."""
    whole, (vertices, faces, _) = mm.prepare(lump()), cut(*lump(), None, -1.0)
    first, second = (mm.match((factor * vertices, faces), whole) for factor in (1.0, 1024.0))
    assert any("partial scan" in line for line in first.warnings)
    np.testing.assert_array_equal(second.pairs, first.pairs)


def test_a_part_of_nothing_there():
    """A flat sheet fits nowhere on the lump, which is nowhere flat."""
    whole = mm.prepare(lump())
    sheet, squares = bent(grid(16, 13))
    part = mm.prepare((sheet * np.sqrt(whole.area / 9 / 260), squares))
    (located,) = locate_parts(part, whole, FEWER, REGISTRATION, 0)
    assert "fits nowhere well" in part_notes(located, "")[0]
    places = located.match()
    assert (places.match_probabilities < 0.5).all()
    with pytest.raises(mm.NothingFoundError, match="no match is likely enough"):
        mm.match(part, whole, parameters=Parameters(partial=FEWER))


def random_paths(generator, samples, points):
    return Paths(*(generator.random((samples, points), np.float32) for _ in range(3)))


@pytest.mark.parametrize("threads", [1, 3])
def test_agreement_is_the_formula(threads):
    generator = np.random.default_rng(0)
    first, second = random_paths(generator, 5, 7), random_paths(generator, 6, 9)
    costs = generator.random((7, 9), np.float32)
    triplets = tuple(generator.integers(0, len(side.x), (2 * BATCH + 1, 3)) for side in (first, second))
    with ThreadPoolExecutor(threads) as pool:
        totals = agreement(first, second, costs, *triplets, 0.2, 0.3, pool)

    def sines(paths, ends):
        x, y = paths.x[ends], paths.y[ends]
        return x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)

    lengths = np.abs(first.lengths[triplets[0]][..., None] - second.lengths[triplets[1]][:, :, None]).mean(axis=1)
    angles = np.abs(sines(first, triplets[0])[..., None] - sines(second, triplets[1])[:, :, None]).mean(axis=1)
    errors = lengths + 0.2 * angles + costs
    np.testing.assert_allclose(totals, np.exp(-errors.min(axis=2) / 0.3).mean(axis=1), rtol=1e-5)
    images = np.empty((len(errors), 7), np.int64)
    images_by_triplets(first, second, costs, *triplets, 0.2, images)
    np.testing.assert_allclose(np.take_along_axis(errors, images[..., None], 2)[..., 0], errors.min(axis=2), rtol=1e-5)


def test_match_by_distances_is_the_formula():
    generator = np.random.default_rng(0)
    first, second = random_paths(generator, 5, 7), random_paths(generator, 5, 9)
    costs = generator.random((7, 9), np.float32)
    weight = (1 / (first.lengths + 0.1))[:, :, None]
    errors = np.minimum(np.abs(first.lengths[:, :, None] - second.lengths[:, None]), 0.4)
    here, there = first.x + 1j * first.y, second.x + 1j * second.y
    agreeing = np.abs((weight * here[:, :, None] * there[:, None].conj()).sum(axis=0))
    total = ((weight * errors).sum(axis=0) - 0.5 * agreeing) / weight.sum(axis=0) + costs
    np.testing.assert_array_equal(match_by_distances(first, second, costs, 0.4, 0.1, 0.5), total.argmin(axis=1))


def test_a_copy_in_other_units_is_the_whole():
    vertices, faces = bent(grid(20, 17))
    result = mm.match((vertices, faces), (3 * vertices + 1, faces), seed=0)
    np.testing.assert_array_equal(result.pairs[:, 0], result.pairs[:, 1])
    np.testing.assert_array_equal(result.dense().vertex_map, np.arange(len(vertices)))
    assert not any("partial scan" in line for line in result.warnings)
