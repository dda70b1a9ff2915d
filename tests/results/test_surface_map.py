"""Maps made by hand: what they carry, and how they are kept."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.evaluation.quality import quality
from mobius_match.geometry.points import SurfacePoints, closest_points
from mobius_match.mesh import Mesh
from mobius_match.results.surface_map import SurfaceMap


def grid(size, seed):
    """The unit square with its inner vertices moved about."""
    generator = np.random.default_rng(seed)
    step = np.linspace(0, 1, size)
    places = np.stack(np.meshgrid(step, step, indexing="ij"), axis=-1).reshape(-1, 2)
    inner = ((places > 0) & (places < 1)).all(axis=1)
    places[inner] += generator.uniform(-0.3, 0.3, (inner.sum(), 2)) / size
    first = (np.arange(size - 1)[:, None] * size + np.arange(size - 1)).ravel()
    faces = np.concatenate(
        [np.stack([first, first + size, first + 1], 1), np.stack([first + 1, first + size, first + size + 1], 1)]
    )
    return Mesh(np.column_stack([places, np.zeros(len(places))]), faces)


@pytest.fixture(scope="module")
def plane():
    """The identity between two triangulations of the unit square."""
    meshes = grid(20, 0), grid(27, 1)

    def points(a, b):
        near = np.linalg.norm(b.vertices[:, None] - a.vertices, axis=2).argmin(axis=0)
        return closest_points(b.vertices, b.faces, a.vertices, near)

    every = [np.ones(len(mesh.vertices), bool) for mesh in meshes]
    return SurfaceMap(*meshes, points(*meshes), points(*meshes[::-1]), *every)


def test_a_linear_function_is_carried_exactly(plane):
    def linear(places):
        return np.column_stack([places @ [1.0, 2.0, 0.0] + 3, places @ [-1.0, 0.5, 0.0]])

    np.testing.assert_allclose(plane.transfer(linear(plane.source.vertices)), linear(plane.target.vertices), atol=1e-12)
    np.testing.assert_allclose(
        plane.inverse.transfer(linear(plane.target.vertices)), linear(plane.source.vertices), atol=1e-12
    )
    np.testing.assert_allclose(plane.positions, plane.source.vertices, atol=1e-12)


def test_labels_never_mix(plane):
    centres = plane.source.vertices[plane.source.faces].mean(axis=1)
    carried = plane.transfer_labels(np.where(centres[:, 0] < 0.5, 10, 20))
    there = plane.target.vertices[plane.target.faces].mean(axis=1)[:, 0]
    assert set(np.unique(carried)) == {10, 20}
    assert (carried[there < 0.45] == 10).all()
    assert (carried[there > 0.55] == 20).all()


def test_points_on_vertices_edges_and_faces_stay_there(plane):
    count = np.arange(len(plane.source.faces))
    same = SurfacePoints(count, plane.source.faces, np.tile([1.0, 0, 0], (len(count), 1)))
    images, found = plane.map_points(same)
    assert found.all()
    np.testing.assert_allclose(
        images.values(plane.target.vertices), plane.source.vertices[plane.source.faces[:, 0]], atol=1e-12
    )
    for weights in ([0.25, 0.75, 0.0], [0.2, 0.3, 0.5]):
        inner = SurfacePoints(count, plane.source.faces, np.tile(weights, (len(count), 1)))
        images, _ = plane.map_points(inner)
        places = inner.values(plane.source.vertices)
        np.testing.assert_allclose(images.values(plane.target.vertices), places, atol=1e-9)


def test_what_has_no_counterpart_stays_unmatched(plane):
    left = plane.target.vertices[:, 0] < 0.5
    part = SurfaceMap(
        plane.source, plane.target, plane.target_points, plane.source_points, plane.source.vertices[:, 0] < 0.5, left
    )
    carried = part.transfer(np.ones(len(plane.source.vertices)))
    np.testing.assert_array_equal(np.isnan(carried), ~left)
    np.testing.assert_array_equal(part.vertex_map == -1, plane.source.vertices[:, 0] >= 0.5)
    assert np.isnan(part.positions[~part.source_mapped]).all()
    labels = part.transfer_labels(np.zeros(len(plane.source.faces), int))
    np.testing.assert_array_equal(labels == 0, left[plane.target.faces].all(axis=1))
    report = quality(part)
    assert report.mapped == pytest.approx(part.source_mapped.mean())
    assert 0.4 < report.coverage < 0.6
    assert report.orientation == 1.0


def test_distortion_is_that_of_a_known_map():
    """A square drawn out to three times its length keeps its area in units of its own, and its angles do not."""
    square = grid(12, 0)
    drawn = Mesh(square.vertices * [3.0, 1.0, 1.0], square.faces)
    every = np.arange(len(square.vertices))
    corner = np.argmax(square.faces[:, :, None] == every, axis=1)  # which corner a vertex is, in each face
    face = np.array([np.flatnonzero((square.faces == i).any(axis=1))[0] for i in every])
    points = SurfacePoints(face, square.faces[face], np.eye(3)[corner[face, every]])
    known = np.ones(len(every), bool)
    report = quality(SurfaceMap(square, drawn, points, points, known, known))
    np.testing.assert_allclose(report.area, 0.0, atol=1e-9)
    np.testing.assert_allclose(report.angle, np.log2(3), atol=1e-9)
    np.testing.assert_allclose(report.round_trip, 0.0, atol=1e-12)
    mirrored = Mesh(square.vertices * [-1.0, 1.0, 1.0], square.faces[:, ::-1])
    turned = SurfaceMap(square, mirrored, points, points, known, known)
    assert quality(turned).orientation == 0.0


def test_a_map_is_kept_in_a_file(plane, tmp_path):
    plane.save(tmp_path / "map.npz")
    again = mm.SurfaceMap.load(tmp_path / "map.npz")
    np.testing.assert_array_equal(again.vertex_map, plane.vertex_map)
    np.testing.assert_array_equal(again.inverse.positions, plane.inverse.positions)
    assert again.source.sha256 == plane.source.sha256
    plane.save(tmp_path / "map.txt")
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "map.txt", dtype=int), plane.vertex_map)
    for content in (b"", b"PK\x03\x04 cut", (tmp_path / "map.npz").read_bytes()[:-100]):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(mm.FormatError, match="not a readable map"):
            mm.SurfaceMap.load(tmp_path / "bad.npz")


def test_values_of_the_wrong_number_are_refused(plane):
    with pytest.raises(mm.SettingsError, match="400 vertices, and 3 values"):
        plane.transfer(np.ones(3))
    with pytest.raises(mm.SettingsError, match="faces, and 400 values"):
        plane.transfer_labels(np.ones(400, int))
    with pytest.raises(mm.SettingsError, match="whole numbers"):
        plane.transfer_labels(np.ones(len(plane.source.faces)))
