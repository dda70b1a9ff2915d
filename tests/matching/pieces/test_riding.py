"""Pieces that ride along: in dense maps, transfer, morphs, files and pages."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.geometry.moving_least_squares import carried, similarity
from mobius_match.results.main_map import main_map
from tests.shapes import icosphere, lump, rotation


def union(*parts):
    start = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(
        [faces + first for (_, faces), first in zip(parts, start, strict=False)]
    )


def bent(points):
    """A motion that is no rigid one: the more turned about z the higher, then moved and scaled."""
    angle = 0.15 * points[:, 2]
    x, y = points[:, 0], points[:, 1]
    turned = np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, points[:, 2]], 1)
    return 3 * turned @ rotation(1) + 5


@pytest.fixture(scope="module")
def eyed():
    """A lump with two eyes and a vertex on no face, and its body bent; the body has the numbers 42 to 2603.

    The third is where the vertices of the first are once all of it is bent.
    """
    ball, ball_faces = icosphere(1)
    body = lump(4)
    top = body[0][np.linalg.norm(body[0], axis=1).argmax()]
    eyes = [(0.08 * ball + 1.02 * top, ball_faces), (0.1 * ball + [0.0, -0.9, -0.1], ball_faces)]
    vertices, faces = union(eyes[0], body, eyes[1])
    vertices = np.concatenate([vertices, [[4.0, 4, 4]]])
    return (vertices, faces), (bent(body[0]), body[1]), bent(vertices)


BODY = slice(42, 2604)
EYES = np.r_[0:42, 2604:2646]


@pytest.fixture(scope="module")
def result(eyed):
    return mm.match(*eyed[:2], seed=0)


def test_every_vertex_of_a_face_is_mapped_and_the_others_are_told(eyed, result):
    vertex_map = result.dense().vertex_map
    assert vertex_map[-1] == -1 and (vertex_map[:-1] >= 0).all()
    assert result.source_info["unreached_vertices"] == 1 and result.source_info["other_pieces"] == 2
    assert "other_pieces" not in result.target_info
    assert any("3 pieces" in warning for warning in result.warnings)
    scale = np.sqrt(result.target_info["area"])
    error = np.linalg.norm(eyed[1][0][vertex_map] - eyed[2], axis=1) / scale
    assert error[BODY].mean() < 0.02
    # An eye has the image of the place that it lies on.
    assert error[EYES].mean() < 0.1


def test_eyes_stay_in_their_places(eyed, result):
    positions = mm.Transfer(result.dense()).positions()
    scale = np.sqrt(result.target_info["area"])
    error = np.linalg.norm(positions - eyed[2], axis=1) / scale
    assert error[EYES].max() < 0.02
    assert np.isnan(positions[-1]).all()
    # They are solid: only moved, turned and scaled.
    eye = positions[:42]
    np.testing.assert_allclose(similarity(eyed[0][0][:42], eye), eye, atol=1e-9)


def test_a_morph_ends_there_and_keeps_them_near(eyed, result):
    dense = result.dense()
    shapes = mm.morph(dense, [0, 0.5, 1])
    np.testing.assert_array_equal(shapes[0], dense.source.vertices)
    np.testing.assert_allclose(shapes[2], dense.positions)
    scale = np.sqrt(result.target_info["area"])
    centre = shapes[1, :42].mean(axis=0)
    gap = np.linalg.norm(shapes[1, BODY] - centre, axis=1).min()
    assert gap < 0.03 * scale


def test_transfer_reaches_them(eyed, result):
    values = eyed[0][0][:, 2]
    moved = result.dense().transfer(values)
    assert np.abs(moved - values[BODY]).mean() < 0.1
    back = result.dense().inverse.transfer(values[BODY])
    assert np.isnan(back[-1]) and np.abs(back - values)[:-1].mean() < 0.1
    labels = result.dense().inverse.transfer_labels(np.ones(5120, int))
    assert (labels == 1).all()


def test_files_keep_them(eyed, result, tmp_path):
    dense = result.dense()
    dense.save(tmp_path / "map.npz")
    loaded = mm.SurfaceMap.load(tmp_path / "map.npz")
    for one, other in ((dense, loaded), (dense.inverse, loaded.inverse)):
        np.testing.assert_array_equal(one.vertex_map, other.vertex_map)
        np.testing.assert_array_equal(one.positions, other.positions)
    result.source.save(tmp_path / "surface.npz")
    surface = mm.Surface.load(tmp_path / "surface.npz")
    np.testing.assert_array_equal(surface.whole_mesh.others.vertex_ids, result.source.whole_mesh.others.vertex_ids)
    again = mm.match(surface, result.target, seed=0)
    np.testing.assert_array_equal(again.dense().vertex_map, dense.vertex_map)


def test_simplified_surfaces_keep_them(eyed, tmp_path):
    first, second = (mm.prepare(arrays, resolution=1000) for arrays in eyed[:2])
    assert first.detail is not None and first.mesh.others is None
    first.save(tmp_path / "surface.npz")
    dense = mm.match(mm.Surface.load(tmp_path / "surface.npz"), second, seed=0).dense()
    assert (dense.vertex_map[:-1] >= 0).all()


def test_the_body_is_matched_as_if_it_were_alone(eyed, result):
    alone = mm.match((eyed[0][0][BODY], lump(4)[1]), eyed[1], seed=0)
    np.testing.assert_array_equal(result.pairs, alone.pairs + np.array([42, 0]))
    np.testing.assert_array_equal(result.confidence, alone.confidence)
    main, vertices, faces = main_map(result.dense())
    assert np.flatnonzero(vertices)[[0, -1]].tolist() == [42, 2603] and faces.sum() == 5120
    np.testing.assert_array_equal(main.target_points.nearest, alone.dense().target_points.nearest)
    assert mm.quality(result.dense()).orientation == mm.quality(alone.dense()).orientation


def test_a_page_with_them(result):
    assert "<html" in mm.page(result, dense=result.dense())


def test_carrying_is_exact_for_a_similarity():
    rng = np.random.default_rng(0)
    controls, points = rng.normal(size=(50, 3)), rng.normal(size=(9, 3)) * 3

    def move(x):
        return 2 * x @ rotation(3) + [1, 2, 3]

    anchors = controls[:9]
    np.testing.assert_allclose(carried(points, controls, move(controls), anchors, move(anchors)), move(points))
    np.testing.assert_allclose(similarity(points, move(points)), move(points))


def test_carrying_follows_the_nearest_control_points():
    """Two far groups that move apart: what is beside one goes with it; half way between them is their mean."""
    rng = np.random.default_rng(0)
    group = rng.normal(size=(20, 3)) * 0.1
    controls = np.concatenate([group, group + np.array([10, 0, 0])])
    images = np.concatenate([group, group + np.array([12, 0, 0])])
    points = np.array([[0.2, 0, 0], [10.2, 0, 0]])
    there = carried(points, controls, images, controls[[0, 20]], images[[0, 20]])
    np.testing.assert_allclose(there, [[0.2, 0, 0], [12.2, 0, 0]], atol=0.05)
