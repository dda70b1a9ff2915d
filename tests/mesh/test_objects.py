"""Meshes of other libraries: real ones of trimesh and meshio, and stand-ins with the attributes of the others."""

from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import trimesh

from mobius_match.errors import FormatError, MeshError
from mobius_match.mesh import as_mesh, repair, require_matchable

BALL = trimesh.creation.icosphere(1)
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])


class Tensor:
    """A tensor on another device: numpy cannot read it before it is copied."""

    def __init__(self, values, step=0):
        self.values, self.step = values, step

    def cpu(self):
        return Tensor(self.values, 1)

    def numpy(self):
        assert self.step == 1, "copy the tensor from its device first"
        return self.values

    def __array__(self, *_, **__):
        raise TypeError("not on this device")


def padded(*polygons):
    return np.concatenate([[len(polygon), *polygon] for polygon in polygons])


@pytest.mark.parametrize(
    "thing",
    [
        BALL,
        SimpleNamespace(vertices=BALL.vertices, triangles=BALL.faces),
        SimpleNamespace(
            vertex=SimpleNamespace(positions=Tensor(np.array(BALL.vertices))),
            triangle=SimpleNamespace(indices=Tensor(np.array(BALL.faces))),
        ),
        (Tensor(np.array(BALL.vertices)), Tensor(np.array(BALL.faces))),
        SimpleNamespace(points=BALL.vertices, regular_faces=BALL.faces),
        SimpleNamespace(points=BALL.vertices, faces=padded(*BALL.faces)),
        meshio.Mesh(BALL.vertices, [("triangle", BALL.faces)]),
        meshio.Mesh(BALL.vertices, [("triangle", BALL.faces[:30]), ("triangle", BALL.faces[30:])]),
        trimesh.Scene(BALL),
    ],
    ids=["trimesh", "open3d", "open3d.t", "tensors", "regular", "padded", "meshio", "meshio blocks", "scene"],
)
def test_each_library_gives_the_same_mesh(thing):
    mesh = as_mesh(thing)
    np.testing.assert_array_equal(mesh.vertices, BALL.vertices)
    np.testing.assert_array_equal(mesh.faces, BALL.faces)
    assert mesh.notes == () and mesh.path is None and mesh.n_file_faces == 80
    require_matchable(repair(mesh))


@pytest.mark.parametrize(
    "thing",
    [
        meshio.Mesh(SQUARE, [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]])]),
        SimpleNamespace(points=SQUARE, faces=padded([0, 1, 2, 3], [1, 4, 2]), regular_faces=None),
    ],
    ids=["meshio", "pyvista"],
)
def test_quadrilaterals_are_cut_and_keep_their_numbers(thing):
    mesh = as_mesh(thing)
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    np.testing.assert_array_equal(mesh.face_ids, [0, 0, 1])
    assert mesh.n_file_faces == 2
    assert mesh.notes == ("1 polygon(s) with more than 3 corners cut into 2 triangles.",)


def test_regular_quadrilaterals():
    mesh = as_mesh(SimpleNamespace(points=SQUARE, regular_faces=np.array([[0, 1, 2, 3]])))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])


def test_points_and_lines_are_left_out_and_counted():
    blocks = [("vertex", [[0], [4]]), ("triangle", [[0, 1, 2]]), ("line", [[0, 1]])]
    mesh = as_mesh(meshio.Mesh(SQUARE, blocks))
    np.testing.assert_array_equal(mesh.face_ids, [2])
    assert mesh.n_file_faces == 4
    assert mesh.notes[0] == "3 point or line cell(s) keep their numbers, but have no face."
    mesh = as_mesh(SimpleNamespace(points=SQUARE, faces=padded([0, 1, 2]), n_verts=2, n_lines=1))
    assert mesh.notes == ("2 point cell(s) left out.", "1 line cell(s) left out.")


def test_points_in_the_plane_get_a_third_coordinate():
    mesh = as_mesh(meshio.Mesh(SQUARE[:, :2], [("triangle", [[0, 1, 2]])]))
    np.testing.assert_array_equal(mesh.vertices, SQUARE)


def test_a_scene_is_placed_by_its_transforms():
    box, far = trimesh.creation.box(), np.eye(4)
    far[:3, 3] = [5, 0, 0]
    mirror = np.diag([1.0, 1, -1, 1])
    scene = trimesh.Scene()
    for name, transform in (("plain", np.eye(4)), ("far", far), ("mirrored", mirror)):
        scene.add_geometry(box, node_name=name, geom_name="box", transform=transform)
    scene.add_geometry(trimesh.PointCloud(SQUARE), node_name="points")
    mesh = as_mesh(scene)
    assert len(mesh.vertices) == 24 and len(mesh.faces) == 36
    assert mesh.notes == (
        "1 part(s) of points or lines left out.",
        "3 parts combined in the order of the scene's nodes; vertices are numbered in that order.",
    )
    expected = scene.to_mesh()
    np.testing.assert_allclose(np.sort(mesh.vertices, axis=0), np.sort(expected.vertices, axis=0))
    corners = mesh.vertices[mesh.faces]
    volumes = np.einsum("mi,mi->m", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).reshape(3, 12).sum(axis=1)
    np.testing.assert_allclose(volumes / 6, 1)  # all face outwards, the mirrored one too


def test_an_empty_scene_is_refused_by_the_match_not_by_numpy():
    mesh = as_mesh(trimesh.Scene())
    with pytest.raises(MeshError, match="0 usable faces and 0 vertices are too few"):
        require_matchable(repair(mesh))


@pytest.mark.parametrize(
    ("thing", "text"),
    [
        (meshio.Mesh(SQUARE, [("tetra", [[0, 1, 2, 3]])]), "1 cell.s. of type tetra are neither.*Extract the surface"),
        (meshio.Mesh(SQUARE, [("triangle", [[0, 1, 9]])]), "face 0 .* names vertex 9.*Correct the faces"),
        (SimpleNamespace(points=SQUARE, celltypes=[10], cells=[4, 0, 1, 2, 3]), r"give its extract_surface\(\)"),
        (
            SimpleNamespace(points=SQUARE, faces=padded([0, 1, 2]), n_strips=2),
            r"2 triangle strip.s. .* give triangulate\(\)",
        ),
        (SimpleNamespace(points=SQUARE, faces=padded([0, 1, 9])), "names vertex 9.*Correct the faces"),
        (SimpleNamespace(points=SQUARE), "'SimpleNamespace' is not a mesh: give a path"),
        (trimesh.PointCloud(SQUARE), "'PointCloud' is not a mesh"),
        ((BALL.vertices.T, BALL.faces), r"shape \(3, 42\)\. If the array is transposed, give vertices\.T\.$"),
        ((BALL.vertices, BALL.faces.T), r"shape \(3, 80\)\. If the array is transposed, give faces\.T\.$"),
        ((SQUARE, [[0, 1, 2, 3]] * 3), r"If the array is transposed, give faces\.T\. Cut polygons into triangles"),
        ((SQUARE, [[0, 1, 2, 3]] * 2), r"shape \(2, 4\)\. Cut polygons into triangles first"),
    ],
)
def test_what_is_no_surface_is_refused_with_a_remedy(thing, text):
    with pytest.raises(MeshError, match=text) as caught:
        as_mesh(thing)
    assert "damaged" not in str(caught.value)


def test_parts_with_faces_out_of_range_are_refused():
    scene = trimesh.Scene(trimesh.Trimesh(SQUARE, [[0, 1, 9]], process=False))
    with pytest.raises(FormatError, match="1 indices exceed the 5 vertices of a part"):
        as_mesh(scene)
