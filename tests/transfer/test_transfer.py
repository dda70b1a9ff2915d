"""Transfer along constructed maps: a renumbering, a tube with a seam, regions without a counterpart."""

import numpy as np
import pytest
import trimesh

import mobius_match as mm
from mobius_match.geometry.points import SurfacePoints, closest_points
from mobius_match.mesh import Mesh, repair
from mobius_match.results.surface_map import SurfaceMap
from mobius_match.transfer.colours import GREY
from mobius_match.transfer.transfer import Transfer
from tests.shapes import lump, renumbered, tube


def at_vertices(mesh, vertices):
    """Vertices of a mesh as points."""
    corner = np.empty(len(mesh.vertices), np.int64)
    corner[mesh.faces.ravel()] = np.arange(3 * len(mesh.faces))
    faces, place = corner[vertices] // 3, corner[vertices] % 3
    return SurfacePoints(faces, mesh.faces[faces], np.eye(3)[place])


def renumbering(source, target, number):
    """The map between a mesh and a copy in which vertex i has become number[i]."""
    every = np.ones(len(number), bool)
    points = at_vertices(target, number), at_vertices(source, np.argsort(number))
    return SurfaceMap(source, target, *points, every, every)


def nearest(source, target):
    """The map to the closest points, between two meshes of one surface."""

    def points(a, b):
        near = np.linalg.norm(a.vertices[:, None] - b.vertices, axis=2).argmin(axis=1)
        return closest_points(b.vertices, b.faces, a.vertices, near)

    every = [np.ones(len(mesh.vertices), bool) for mesh in (source, target)]
    return SurfaceMap(source, target, points(source, target), points(target, source), *every)


@pytest.fixture(scope="module")
def copy():
    arrays = lump(2)
    (vertices, faces), number = renumbered(arrays)
    return Transfer(renumbering(Mesh(*arrays), Mesh(vertices, faces), number)), number


def seamed_tube(around, along, turn):
    """A closed tube whose rim has two vertices at one place, and u along, v around it."""
    vertices, faces = tube(around, along)
    vertices = vertices @ [[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    angle = np.arctan2(vertices[:, 1], vertices[:, 0]) / (2 * np.pi) % 1.0
    angle[angle > 1 - 1e-9] = 0.0
    uv = np.stack([angle, vertices[:, 2] / 4], axis=1)[faces]
    over = np.ptp(uv[..., 0], axis=1) > 0.5
    uv[..., 0] += over[:, None] * (uv[..., 0] < 0.5)
    return Mesh(vertices, faces), uv


def test_transfer_to_a_renumbered_copy_changes_nothing(copy):
    carrier, number = copy
    rng = np.random.default_rng(0)
    n, m = len(number), len(carrier.source.faces)
    back = np.argsort(number)
    scalars, vectors = rng.normal(size=n), rng.normal(size=(n, 3))
    np.testing.assert_array_equal(carrier.values(scalars), scalars[back])
    np.testing.assert_array_equal(carrier.values(vectors), vectors[back])
    colors = rng.integers(0, 256, (n, 4), dtype=np.uint8)
    np.testing.assert_array_equal(carrier.colors(colors), colors[back])
    np.testing.assert_array_equal(carrier.positions(), carrier.source.vertices)
    # Faces are the same sets of corners, in another order.
    rows = {tuple(sorted(face)): k for k, face in enumerate(number[carrier.source.faces].tolist())}
    face = np.array([rows[tuple(sorted(corners))] for corners in carrier.target.faces.tolist()])
    np.testing.assert_array_equal(carrier.labels(np.arange(m)), face)
    smooth = np.array([0.3, 0.1]) * carrier.source.vertices[:, :2]
    np.testing.assert_allclose(carrier.uv(smooth[carrier.source.faces]), smooth[back][carrier.target.faces], atol=1e-12)
    uv = rng.random((m, 3, 2))  # every face a chart of its own
    place = [
        [number[carrier.source.faces[k]].tolist().index(corner) for corner in corners]
        for k, corners in zip(face, carrier.target.faces.tolist(), strict=True)
    ]
    wanted = uv[face[:, None], place]
    found = carrier.uv(uv)
    # A corner may take the coordinates of the chart next to it only where these are as near as its own corners are.
    far = np.linalg.norm(found - wanted, axis=2).max(axis=1)
    size = np.linalg.norm(wanted - np.roll(wanted, 1, axis=1), axis=2).max(axis=1)
    assert (far <= size + 1e-9).all()


def test_landmarks_on_vertices_and_edges_stay_there(copy):
    carrier, number = copy
    places, vertices = carrier.points(carrier.at_vertices(np.arange(len(number))))
    np.testing.assert_array_equal(vertices, number)
    np.testing.assert_array_equal(places, carrier.source.vertices)
    ends = carrier.source.vertices[carrier.source.faces[:, :2]]
    on_edges = 0.7 * ends[:, 0] + 0.3 * ends[:, 1]
    points, distances = carrier.project(on_edges)
    assert ((points.barycentric == 0).sum(axis=1) == 1).all()
    assert distances.max() < 1e-12
    np.testing.assert_allclose(carrier.points(points)[0], on_edges, atol=1e-12)


def test_positions_off_the_surface_are_projected():
    sheet = Mesh(*tube(40, 10))
    carrier = Transfer(nearest(sheet, sheet))
    middle = sheet.vertices[sheet.faces[50]].mean(axis=0)
    outward = np.cross(*(sheet.vertices[sheet.faces[50, 1:]] - sheet.vertices[sheet.faces[50, 0]]))
    outward /= np.linalg.norm(outward)
    points, distances = carrier.project(middle[None] + 0.25 * outward)
    assert distances == pytest.approx([0.25])
    assert points.faces == [50]
    np.testing.assert_allclose(points.values(sheet.vertices), [middle], atol=1e-12)


def test_no_face_of_a_texture_spans_a_seam():
    source, uv = seamed_tube(48, 20, 0.0)
    target, wanted = seamed_tube(61, 33, 0.4)
    carrier = Transfer(nearest(source, target))
    found = carrier.uv(uv)
    assert np.ptp(found, axis=1).max() < 0.1
    # The faces of both tubes are chords, so their points differ by a fraction of an edge's angle.
    error = found - wanted
    error[..., 0] -= np.round(error[..., 0])
    assert np.abs(error).max() < 0.01
    assert np.ptp(wanted, axis=1).max() < 0.1  # so the test could fail: plain interpolation spans the seam
    mean = carrier.values(
        uv[np.argsort(source.faces.ravel())[np.cumsum(np.bincount(source.faces.ravel())) - 1] // 3, 0]
    )
    assert np.ptp(mean[target.faces], axis=1).max() > 0.5


def test_labels_of_vertices_are_not_mixed():
    source, target = seamed_tube(30, 12, 0.0)[0], seamed_tube(41, 17, 0.3)[0]
    labels = np.where(source.vertices[:, 2] > 2, 10, 100)
    found = Transfer(nearest(source, target)).values(labels)
    assert found.dtype == np.int64
    assert set(found.tolist()) == {10, 100}
    np.testing.assert_array_equal(found[target.vertices[:, 2] > 2.4], 10)
    np.testing.assert_array_equal(found[target.vertices[:, 2] < 1.6], 100)
    assert set(Transfer(nearest(source, target)).values(labels.astype(float)).tolist()) > {10.0, 100.0}


def test_vertices_joined_by_repair_get_the_same_values(tmp_path):
    """A sheet cut along a line in its file, which repair closes, and a vertex that is in no face."""
    vertices, faces = tube(12, 6)
    ring = 36 + np.arange(12)
    doubled = np.concatenate([vertices, vertices[ring], [[9.0, 9, 9]]])
    above = (faces >= 36).all(axis=1, keepdims=True)
    cut = np.where(above & (faces < 48), faces - 36 + len(vertices), faces)
    path = tmp_path / "cut.off"
    path.write_bytes(trimesh.Trimesh(doubled, cut, process=False).export(file_type="off", digits=17).encode())
    mesh = repair(mm.read_mesh(path))
    assert len(mesh.vertices) == len(vertices)
    source = Mesh(vertices, faces)
    carrier = Transfer(renumbering(source, mesh, np.arange(len(vertices))))
    values = np.random.default_rng(0).normal(size=len(vertices))
    found = carrier.values(values)
    np.testing.assert_array_equal(found, [*values, *values[ring], np.nan])
    np.testing.assert_array_equal(Transfer(carrier.map.inverse).values(found), values)
    np.testing.assert_array_equal(carrier.missing, np.isnan(found))


def test_what_has_no_counterpart_is_marked(copy):
    whole = copy[0].map
    lost = whole.target.vertices[:, 2] > 0.5
    gone = whole.source.vertices[:, 2] > 0.5
    carrier = Transfer(SurfaceMap(whole.source, whole.target, whole.target_points, whole.source_points, ~gone, ~lost))
    n, m = len(lost), len(carrier.source.faces)
    np.testing.assert_array_equal(carrier.missing, lost)
    np.testing.assert_array_equal(np.isnan(carrier.values(np.ones(n))), lost)
    np.testing.assert_array_equal(carrier.values(np.ones(n, int)) == -1, lost)
    colors = carrier.colors(np.zeros((n, 3), np.uint8))
    np.testing.assert_array_equal((colors == GREY[:3]).all(axis=1), lost)
    touched = lost[carrier.target.faces].any(axis=1)
    np.testing.assert_array_equal(carrier.labels(np.ones(m, int)) == -1, touched)
    np.testing.assert_array_equal(np.isnan(carrier.uv(np.ones((m, 3, 2)))).all(axis=(1, 2)), touched)
    np.testing.assert_array_equal(np.isnan(carrier.positions()).all(axis=1), gone)
    places, vertices = carrier.points(carrier.at_vertices(np.arange(n)))
    np.testing.assert_array_equal(vertices == -1, gone)
    np.testing.assert_array_equal(np.isnan(places).any(axis=1), gone)


def test_transfer_of_numbers_is_that_of_the_map(copy):
    carrier = copy[0]
    values = np.random.default_rng(1).normal(size=(len(carrier.source.vertices), 2))
    np.testing.assert_array_equal(carrier.values(values), carrier.map.transfer(values))


def test_of_two_repaired_vertices_with_one_number_the_first_decides():
    """A vertex on a cut is two vertices of the repaired mesh."""
    source = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    target = Mesh(
        source.vertices[[0, 1, 2, 1]],
        np.array([[0, 1, 2], [0, 2, 3]]),
        vertex_ids=np.array([0, 1, 2, 1]),
        n_file_vertices=3,
    )
    every = np.ones(4, bool)
    to_source = at_vertices(source, np.array([0, 1, 2, 0]))
    surface_map = SurfaceMap(source, target, at_vertices(target, np.arange(3)), to_source, every[:3], every)
    np.testing.assert_array_equal(surface_map.transfer(np.array([5.0, 6.0, 7.0])), [5, 6, 7])


@pytest.mark.parametrize(
    ("method", "given", "message"),
    [
        ("values", np.ones(7), "has 162 vertices: one row of numbers is needed for each, not float64 of shape (7,)"),
        ("values", np.full(162, "a"), "one row of numbers"),
        ("colors", np.ones((162, 2)), "`colors` must be rows of 3 or 4 numbers"),
        ("colors", np.full((162, 3), 256), "from 0 to 255"),
        ("labels", np.ones(7, int), "has 320 faces, and 7 values were given"),
        ("labels", np.ones(320), "whole numbers"),
        ("uv", np.ones((320, 2)), "`uv` has shape (320, 2), and its 320 triangles need (320, 3, 2)"),
        ("at_vertices", np.array([3, 162]), "has no vertex 162; it has 162"),
        ("project", np.array([[0, 0, np.nan]]), "`positions` has a coordinate that is not a finite number"),
    ],
)
def test_errors_say_what_is_needed(copy, method, given, message):
    with pytest.raises(mm.SettingsError) as error:
        getattr(copy[0], method)(given)
    assert message in str(error.value)


def test_a_changed_file_is_refused(tmp_path):
    path = tmp_path / "sheet.off"
    path.write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n")
    mesh = repair(mm.read_mesh(path))
    carried = Transfer(renumbering(mesh, mesh, np.arange(4))).values(np.arange(4.0))
    np.testing.assert_array_equal(carried, np.arange(4.0))
    path.write_text(path.read_text().replace("1 1 0", "2 2 0"))
    with pytest.raises(mm.MeshError, match="has changed since the match"):
        Transfer(renumbering(mesh, mesh, np.arange(4)))
    path.unlink()  # nothing that only the file has is needed
    assert Transfer(renumbering(mesh, mesh, np.arange(4))).values(np.arange(4.0)).tolist() == [0, 1, 2, 3]
