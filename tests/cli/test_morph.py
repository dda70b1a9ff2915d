"""`mobius morph`: the folder that it writes, and how it ends."""

import io

import numpy as np
import pytest
import trimesh
from PIL import Image

from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import Mesh
from mobius_match.results.surface_map import SurfaceMap


@pytest.fixture(scope="module")
def saved_map(shape, tmp_path_factory):
    """The file of a map from a shape to itself, stretched and set aside."""
    one, two = Mesh(*shape), Mesh(shape[0] * [1, 1, 2] + [5, 5, 5], shape[1])
    corner = np.empty(len(one.vertices), np.int64)
    corner[one.faces.ravel()] = np.arange(one.faces.size)
    points = SurfacePoints(corner // 3, one.faces[corner // 3], np.eye(3)[corner % 3])
    every = np.ones(len(one.vertices), bool)
    path = tmp_path_factory.mktemp("map") / "map.npz"
    SurfaceMap(one, two, points, points, every, every).save(path)
    return path, one, two


@pytest.mark.parametrize("back", [False, True])
def test_frames_and_animation(mobius, saved_map, tmp_path, back):
    path, *meshes = saved_map
    first = meshes[back]
    out = tmp_path / "new" / "folder"
    ended = mobius("morph", path, "--frames", 3, "--pixels", 96, "-o", out, *(["--back"] if back else []))
    assert (ended.code, ended.out) == (0, ""), ended.err
    assert sorted(one.name for one in out.iterdir()) == ["frame000.png", "frame001.png", "frame002.png", "morph.glb"]
    loaded = trimesh.load(io.BytesIO((out / "morph.glb").read_bytes()), file_type="glb", process=False, force="mesh")
    np.testing.assert_allclose(loaded.vertices, first.vertices, atol=1e-5)
    pictures = [np.asarray(Image.open(out / f"frame{k:03d}.png").convert("L"), float) for k in range(3)]
    assert all(picture.shape == (96, 96) for picture in pictures)
    # One camera for all: what moves through the picture moves on in it.
    centres = np.array([np.argwhere(picture < 250).mean(axis=0) for picture in pictures])
    one, two = np.diff(centres, axis=0)
    assert np.abs(one - two).max() < 3 < np.abs(one).max() - 5


def test_no_pictures(mobius, saved_map, tmp_path):
    assert mobius("morph", saved_map[0], "--frames", 2, "--pixels", 0, "-o", tmp_path).code == 0
    assert [one.name for one in tmp_path.iterdir()] == ["morph.glb"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--frames", 1), "--frames is 1; give a number from 2"),
        (("--seconds", 0), "--seconds is 0"),
        (("--pixels", 5), "--pixels is 5; give 0, or"),
        (("-o", "file"), "the folder file cannot be created"),
        (("-o", "file/below"), "the folder file/below cannot be created"),
    ],
)
def test_errors(mobius, saved_map, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    ended = mobius("morph", saved_map[0], "-o", "out", *options)
    assert (ended.code, ended.out) == (2, "")
    assert message in ended.err
    assert [one.name for one in tmp_path.iterdir()] == ["file"]


def test_a_reflected_map_begins_with_the_mirror_image(mobius, shape, tmp_path):
    one = Mesh(*shape)
    two = Mesh(one.reflected().vertices * [1, 1, 2], one.reflected().faces)
    corner = np.empty(len(one.vertices), np.int64)
    corner[one.faces.ravel()] = np.arange(one.faces.size)
    points = SurfacePoints(corner // 3, one.faces[corner // 3], np.eye(3)[corner % 3])
    every = np.ones(len(one.vertices), bool)
    SurfaceMap(one, two, points.in_flipped_faces, points, every, every, reflected=True).save(tmp_path / "map.npz")
    ended = mobius("morph", tmp_path / "map.npz", "--frames", 2, "--pixels", 0, "-o", tmp_path / "out")
    assert ended.code == 0, ended.err
    assert "the source was reflected first" in ended.err
    content = (tmp_path / "out" / "morph.glb").read_bytes()
    loaded = trimesh.load(io.BytesIO(content), file_type="glb", process=False, force="mesh")
    assert loaded.volume > 0
    np.testing.assert_allclose(loaded.vertices[:, 1:], one.vertices[:, 1:], atol=1e-5)
    np.testing.assert_allclose(
        np.sort(loaded.vertices[:, 0]),
        np.sort(-one.vertices[:, 0]) + one.vertices[:, 0].min() + one.vertices[:, 0].max(),
        atol=1e-5,
    )
    # What is transferred is the shape of the target, with faces that point outward.
    out = tmp_path / "positions.ply"
    ended = mobius("transfer", tmp_path / "map.npz", "--what", "positions", "-o", out)
    assert ended.code == 0 and "faces are flipped" in ended.err
    moved = trimesh.load(out, process=False)
    assert moved.volume > 0
    np.testing.assert_allclose(moved.vertices, two.vertices, atol=1e-5)
