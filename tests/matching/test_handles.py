"""Surfaces with handles: real ones, which are kept, and contact, which is cut open."""

import numpy as np
import pytest
import scipy.spatial
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

import mobius_match as mm
from mobius_match.matching.partial.openings import openings
from mobius_match.mesh.handles import number_of_handles
from tests.shapes import bumpy_torus, icosphere, lump, mug, renumbered, snake, torus, with_handle


def errors(result, target, true_places):
    """Distances in space, per sqrt(area) of the target, of the dense map from the true places of the source (n, 3)."""
    mapped = target[0][result.dense().vertex_map]
    return np.linalg.norm(mapped - true_places, axis=1) / result.target.scale


def on_circles(angles):
    return np.concatenate([np.cos(angles), np.sin(angles)], axis=1)


@pytest.fixture(scope="module")
def tori():
    """Two tori of other proportions and meshes, and the true place on the second of each vertex of the first."""
    (source, angles1), (target, angles2) = bumpy_torus(3.0, 0.0, 40, 16), bumpy_torus(2.6, 0.7, 38, 18)
    nearest = scipy.spatial.cKDTree(on_circles(angles2)).query(on_circles(angles1))[1]
    return source, target, target[0][nearest]


@pytest.fixture(scope="module")
def torus_match(tori):
    return mm.match(*tori[:2])


def test_torus_to_torus(tori, torus_match):
    _, target, places = tori
    result = torus_match
    assert result.source.handles_kept and result.target.handles_kept
    # An edge is 0.06 long.
    assert errors(result, target, places).mean() < 0.04
    assert len(result) > 300
    *notes, choice = result.warnings
    assert all("1 handle kept, and cut open in the flattening alone" in note for note in notes)
    assert choice.startswith("handles kept on the source and handles kept on the target, which fits best (cost ")


def test_mug_to_mug_of_another_proportion():
    source, (rest, faces) = mug(28, 1), mug(30, 2)
    target = rest * [1.05, 0.95, 1.15], faces
    places = target[0][scipy.spatial.cKDTree(rest).query(source[0])[1]]
    result = mm.match(source, target)
    assert result.source.handles_kept and result.target.handles_kept
    found = errors(result, target, places)
    assert found.mean() < 0.04 and found.max() < 0.2


def test_a_loose_piece_beside_a_surface_cut_open_disturbs_nothing():
    (vertices, faces), places1 = snake(2 * np.pi, 40, 12, touching=True)
    ball = icosphere(1)
    source = np.concatenate([ball[0] * 0.2 + [0, 0, 3], vertices]), np.concatenate([ball[1], faces + len(ball[0])])
    target, places2 = snake(3.5, 42, 14)
    result = mm.match(source, target)
    assert not result.source.handles_kept and result.source.whole_mesh.others is not None
    nearest = scipy.spatial.cKDTree(places2).query(places1)[1]
    mapped = target[0][result.dense().vertex_map[len(ball[0]) :]]
    found = np.linalg.norm(mapped - target[0][nearest], axis=1) / result.target.scale
    assert np.median(found) < 0.06 and np.mean(found < 0.12) > 0.97


def fused(shape, seed, rings=3):
    """The shape with a tube between two of its faces, drawn at random but far from each other along the surface."""
    vertices, faces = shape
    rng = np.random.default_rng(seed)
    centres = vertices[faces].mean(axis=1)
    one = int(rng.integers(len(faces)))
    far = np.flatnonzero(np.linalg.norm(centres - centres[one], axis=1) > 1.0)
    return with_handle(shape, one, int(rng.choice(far)), rings)


@pytest.mark.parametrize("swapped", [False, True])
def test_contact_on_one_side_is_cut_open(swapped):
    """A snake that bites its tail, and the same snake bent less."""
    shapes = snake(2 * np.pi, 40, 12, touching=True), snake(3.5, 42, 14)
    (source, places1), (target, places2) = shapes[::-1] if swapped else shapes
    result = mm.match(source, target)
    biting = result.target if swapped else result.source
    assert len(biting.loop_sizes) == 1 and not biting.handles_kept
    assert [len(result.source.readings), len(result.target.readings)] == ([1, 2] if swapped else [2, 1])
    nearest = scipy.spatial.cKDTree(places2).query(places1)[1]
    found = errors(result, target, target[0][nearest])
    # An edge is 0.05 long.
    assert np.median(found) < 0.06 and np.mean(found < 0.12) > 0.97
    assert result.warnings[-1].startswith(
        f"handles cut open on the {'target' if swapped else 'source'}, which fits best"
    )


@settings(max_examples=4)
@given(seed=st.integers(0, 10_000))
def test_a_handle_glued_anywhere_moves_few_matches(seed):
    shape = lump(3)
    copy, new = renumbered(shape)
    source = fused(shape, seed)
    result = mm.match(source, copy, samples=60)
    assert number_of_handles(source[1]) == 1
    old = result.pairs[result.pairs[:, 0] < len(new)]
    distance = np.linalg.norm(copy[0][new[old[:, 0]]] - copy[0][old[:, 1]], axis=1) / result.target.scale
    assert len(old) > 200
    assert np.mean(distance < 0.05) > 0.9


def test_other_genus_on_both_sides():
    """Three tubes against one."""
    shape = lump(3)
    three = shape
    for seed in range(3):
        three = fused(three, seed)
    result = mm.match(three, fused(shape, 7), samples=60)
    assert [len(side.loop_sizes) for side in (result.source, result.target)] == [3, 1]
    pairs = result.pairs[(result.pairs < len(shape[0])).all(axis=1)]
    distance = np.linalg.norm(np.diff(shape[0][pairs], axis=1)[:, 0], axis=1) / result.target.scale
    assert np.mean(distance < 0.05) > 0.9


def test_the_paper_takes_spheres_with_holes_and_so_surfaces_cut_open():
    shape = fused(lump(3), 1)
    result = mm.match(shape, lump(3), preset="paper", votes=300_000, samples=30)
    assert not result.source.handles_kept
    assert "1 handle cut open" in result.warnings[0]


def test_files_have_both_readings(tori, torus_match, tmp_path):
    source, target, _ = tori
    one = mm.prepare(source)
    assert [side.handles_kept for side in one.readings] == [False, True]
    assert one.other.closure < 1e-9 and one.closure < 1e-9
    assert len(one.other.mesh.vertices) == len(source[0]) == len(one.mesh.vertices) - one.loop_sizes.sum()
    one.save(tmp_path / "one.npz")
    loaded = mm.Surface.load(tmp_path / "one.npz")
    np.testing.assert_array_equal(loaded.other.positions, one.other.positions)
    np.testing.assert_array_equal(loaded.loops, one.loops)
    again = mm.match(loaded, target, jobs=1)
    np.testing.assert_array_equal(again.pairs, torus_match.pairs)
    assert again.warnings == torus_match.warnings
    assert again.source.handles_kept


def test_the_cache_has_both_readings_and_the_name_of_the_file(tori, tmp_path):
    for name in ("one", "two"):
        trimesh.Trimesh(*tori[0], process=False).export(tmp_path / f"{name}.ply")
    made, found = (mm.prepare(tmp_path / f"{name}.ply", cache=True) for name in ("one", "two"))
    np.testing.assert_array_equal(found.other.eigenfunctions, made.other.eigenfunctions)
    assert [reading.mesh.name for reading in found.readings] == ["two.ply", "two.ply"]
    assert found.other.timings == made.other.timings


def test_rims_of_a_cut_are_no_openings():
    """A torus of one thickness is closed, cut or not; a tube of the same shape is open."""
    surface = mm.prepare(torus(around=24, across=12), samples=20)
    assert len(surface.mesh.vertices) == 24 * 12 + 12
    assert openings(surface).longest == 0


def test_a_hole_in_a_surface_with_a_handle_is_its_only_opening():
    """With handles cut open or kept, and simplified or not."""
    vertices, faces = torus(around=48, across=24)
    hole = np.isin(faces, faces[0]).any(axis=1)
    for resolution in (8000, 500):
        surface = mm.prepare((vertices, faces[~hole]), samples=20, resolution=resolution)
        lengths = [openings(reading).longest for reading in surface.readings]
        assert len(surface.mesh.vertices) < 600 or resolution == 8000
        assert lengths == pytest.approx([reading.rim_length for reading in surface.readings])
        assert 0.2 < lengths[0] < 0.4  # two rims of the cut would add 1.1
