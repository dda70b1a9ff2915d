"""The symmetry of one surface: exact mirror images, invariance, what is told of shapes without one."""

import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment
from mobius_match.evaluation import examples
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.matching.symmetry.symmetry import mirror_images
from tests.shapes import icosphere, lump, renumbered, rotation


def mirrored_lump(subdivisions=4):
    """A lump that the plane x = 0 cuts into mirror images, and the mirror image of each vertex."""
    directions, faces = icosphere(subdivisions)
    opposite = cKDTree(directions).query(directions * [-1, 1, 1])[1]
    radius = np.linalg.norm(lump(subdivisions)[0], axis=1)
    return (directions * ((radius + radius[opposite]) / 2)[:, None], faces), opposite


@pytest.fixture(scope="module")
def found():
    shape, opposite = mirrored_lump()
    return shape, opposite, mm.symmetry(shape)


def test_exact_mirror_images_are_found_to_the_vertex(found):
    _, opposite, result = found
    assert len(result) >= 30
    np.testing.assert_array_equal(result.pairs[:, 1], opposite[result.pairs[:, 0]])
    assert result.score == pytest.approx(1, abs=1e-3)
    assert result.warnings == ()


def test_each_pair_is_told_once_and_the_surest_first(found):
    result = found[2]
    assert len(np.unique(result.pairs)) == result.pairs.size
    assert not np.isin(result.pairs, result.stationary).any()
    assert (np.diff(result.confidence) <= 0).all()
    assert result.confidence[0] <= 1
    assert result.confidence[-1] >= 0.4


def test_stationary_vertices_are_those_near_the_plane(found):
    (vertices, faces), opposite, result = found
    on_the_plane = np.flatnonzero(opposite == np.arange(len(opposite)))
    assert len(on_the_plane) >= 60
    assert np.isin(on_the_plane, result.stationary).all()
    edge = np.linalg.norm(vertices[faces[:, 0]] - vertices[faces[:, 1]], axis=1).mean()
    assert np.abs(vertices[result.stationary, 0]).max() < edge
    np.testing.assert_array_equal(result.stationary, np.unique(result.stationary))


def test_a_copy_turned_scaled_and_renumbered_has_the_same_pairs(found):
    shape, opposite, _ = found
    (vertices, faces), new = renumbered(shape)
    result = mm.symmetry((3.7 * vertices @ rotation().T + [5, -2, 1], faces))
    old = np.argsort(new)
    assert len(result) >= 30
    np.testing.assert_array_equal(old[result.pairs[:, 1]], opposite[old[result.pairs[:, 0]]])
    np.testing.assert_array_equal(np.sort(old[result.stationary]), found[2].stationary)
    assert result.score == pytest.approx(found[2].score, abs=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_lump_is_less_symmetric_and_that_is_told(seed):
    result = mm.symmetry(lump(4), seed=seed)
    assert 0 <= result.score < 0.6
    assert any("hardly symmetric" in line for line in result.warnings)


@pytest.mark.parametrize("name", examples.names())
@pytest.mark.parametrize("pose", [0, 1])
def test_left_and_right_of_the_shipped_bodies(name, pose):
    """From a pose to the mirrored place in the other pose, and from the vertex there back, is the mirror image here."""
    meshes = [mm.read_mesh(path) for path in examples.paths(name)]
    here, there = meshes[pose], meshes[1 - pose]
    faces, weights = examples.truth(name, mirrored=True, reverse=pose == 1)
    other = there.faces[faces, weights.argmax(axis=1)]
    faces, weights = examples.truth(name, reverse=pose == 0)
    truth = np.einsum("ijk,ij->ik", here.vertices[here.faces[faces]], weights)[other]
    truth = cKDTree(here.vertices).query(truth)[1]
    result = mm.symmetry(here)
    solver = geodesic_solver(here.vertices, here.faces)
    errors = np.array([solver(int(j))[truth[i]] for i, j in result.pairs]) / result.source_info["diameter"]
    assert len(result) >= 25
    assert result.score > 0.8
    assert np.mean(errors < 0.05) >= 0.9
    assert errors[:10].mean() < 0.025
    # What stays in place does so by the truth as well.
    moved = np.array([solver(int(v))[truth[v]] for v in result.stationary[::10]]) / result.source_info["diameter"]
    assert np.mean(moved < 0.08) > 0.9


def test_same_seed_same_bytes_whatever_the_threads():
    surface = mm.prepare(mirrored_lump(3)[0])
    results = [mm.symmetry(surface, seed=3, jobs=jobs).to_dict() for jobs in (1, 2, 3)]
    for other in results[1:]:
        for name in ("pairs", "stationary", "score"):
            assert other[name] == results[0][name]


def test_numbers_are_the_users_own():
    vertices, faces = mirrored_lump(3)[0]
    plain = mm.symmetry((vertices, faces))
    padded = mm.symmetry((np.concatenate([np.full((5, 3), 9.0), vertices]), faces + 5))
    np.testing.assert_array_equal(padded.pairs, plain.pairs + 5)
    np.testing.assert_array_equal(padded.stationary, plain.stationary + 5)
    assert any("5 unused vertices" in line for line in padded.warnings)


def test_the_nearest_involution_is_taken():
    """The identity, disturbed at a tenth of the surface, becomes the identity again."""
    surface = mm.prepare(lump(3), samples=30)
    image = surface.proxy.copy()
    image[::10] = surface.proxy[0]
    vertices = np.arange(0, len(surface.mesh.vertices), 7)
    found = mirror_images(surface, Alignment(image, {}, 0.0, 1.0), vertices)
    assert np.mean(found == vertices) > 0.95


def test_result_file(found, tmp_path):
    result = found[2]
    result.save(tmp_path / "symmetry.json")
    content = json.loads((tmp_path / "symmetry.json").read_text())
    assert content == json.loads(json.dumps(result.to_dict()))
    assert (content["format"], content["version"]) == ("mobius-match/symmetry", 1)
    rows = [(row["source"], row["target"]) for row in content["pairs"]]
    assert rows == [tuple(pair) for pair in result.pairs.tolist()]
    assert content["source"]["vertices"] == len(found[0][0])
    assert content["settings"]["seed"] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["symmetry.json"]
    assert repr(result) == f"<Symmetry of array: {len(result)} pairs, score 1.00>"


@pytest.mark.parametrize("shape", [icosphere(0), icosphere(1)], ids=["12 vertices", "42 vertices"])
def test_meshes_of_a_few_vertices_end_well(shape):
    try:
        assert mm.symmetry(shape).score > 0.5
    except mm.NothingFoundError as error:
        assert "`votes`" in str(error)


def test_nothing_found_says_what_to_do():
    with pytest.raises(mm.NothingFoundError, match=r"array: no mirror symmetry .*raise `votes`"):
        mm.symmetry(lump(3), samples=6)


def test_unknown_and_wrong_settings_are_refused():
    with pytest.raises(mm.SettingsError, match=r"^symmetry has no setting 'threshold'; its settings are .*votes$"):
        mm.symmetry(lump(2), threshold=0.5)
    with pytest.raises(mm.SettingsError, match="samples"):
        mm.symmetry(lump(2), samples=2)


def test_progress_is_told_from_start_to_end():
    calls = []
    mm.symmetry(mirrored_lump(3)[0], progress=lambda *call: calls.append(call))
    assert calls[0][0].startswith("sampling")
    assert calls[-1][0] == "voting"
    assert calls[-1][1] == calls[-1][2] > 0
