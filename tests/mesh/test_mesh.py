"""The Mesh: what it checks, freezes and remembers."""

import hashlib
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from mobius_match.errors import FormatError, MeshError
from mobius_match.mesh import Mesh, as_mesh

V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
F = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def test_fills_in_what_is_not_given():
    mesh = Mesh(V, F)
    assert mesh.vertices.dtype == np.float64 and mesh.faces.dtype == np.int64
    np.testing.assert_array_equal(mesh.vertex_ids, [0, 1, 2, 3])
    np.testing.assert_array_equal(mesh.face_ids, [0, 1, 2, 3])
    assert (mesh.name, mesh.path, mesh.n_file_vertices, mesh.n_file_faces, mesh.notes) == (
        "array",
        None,
        4,
        4,
        (),
    )
    assert repr(mesh) == "Mesh('array', 4 vertices, 4 faces)"


def test_is_frozen_and_leaves_the_callers_arrays_alone():
    vertices, faces = V.copy(), F.copy()
    mesh = Mesh(vertices, faces)
    vertices[0], faces[0] = 9, 0
    np.testing.assert_array_equal(mesh.vertices, V)
    np.testing.assert_array_equal(mesh.faces, F)
    for array in (mesh.vertices, mesh.faces, mesh.vertex_ids, mesh.face_ids):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(AttributeError):
        mesh.name = "other"


def test_hash_depends_on_the_contents_alone():
    same = Mesh(V.astype(np.float32), F.astype(np.uint8)).sha256
    assert same == Mesh(np.asfortranarray(V), F[:, ::1]).sha256 == Mesh(V.tolist(), F.tolist()).sha256
    assert len({same, Mesh(V + 1, F).sha256, Mesh(V, F[:3]).sha256, Mesh(V, F[:, [1, 2, 0]]).sha256}) == 4
    assert len(same) == len(hashlib.sha256().hexdigest())


@pytest.mark.parametrize(
    ("vertices", "faces", "text"),
    [
        (V[:, :2], F, r"vertices must be numbers of shape \(n, 3\), not float64 of shape \(4, 2\)"),
        (V.ravel(), F, "shape"),
        (V.astype(complex), F, "complex128"),
        ([["a"] * 3] * 4, F, r"vertices must be numbers"),
        ([[0, 0, 0], [1, 1]], F, "vertices cannot be converted to an array"),
        (V, F[:, :2], r"faces must be vertex numbers of shape \(m, 3\).*Cut polygons"),
        (V, np.zeros((2, 4), int), "Cut polygons into triangles"),
        (V, F + 0.5, "face 0 .* names vertex 0.5"),
        (V, F + 1, "face 1 .* names vertex 4, .* 4 vertices, numbered 0 to 3; 3 faces are wrong.*subtract 1"),
        (V, F - 1, "face 0 .* names vertex -1.*3 faces are wrong"),
        (V, F.astype(np.uint64) + np.uint64(2**63), "names vertex 9223372036854775808"),
        (V, F * 1e300, r"face 0 .* names vertex 2e\+300"),
        (V, F * np.nan, "names vertex nan"),
        (V[:0], F, "the mesh has 0 vertices"),
        (np.where(V == 1, np.nan, V), F, "3 vertices have .* the first is vertex 1"),
        (np.where([[0, 0, 0]] * 3 + [[0, 1, 0]], np.inf, V), F, "1 vertex has .* the first is vertex 3"),
    ],
)
def test_refuses(vertices, faces, text):
    with pytest.raises(MeshError, match=text) as caught:
        Mesh(vertices, faces, name="thing")
    assert str(caught.value).startswith("thing: ")


def test_takes_whole_floats_and_no_faces():
    np.testing.assert_array_equal(Mesh(V, F.astype(float)).faces, F)
    assert Mesh(V, []).faces.shape == (0, 3)


@pytest.mark.parametrize("ids", [np.arange(3), np.arange(4.0), np.arange(8).reshape(4, 2)])
def test_refuses_wrong_ids(ids):
    with pytest.raises(MeshError, match="vertex_ids must be 4 integers"):
        Mesh(V, F, vertex_ids=ids)


def test_as_mesh(tmp_path):
    mesh = Mesh(V, F)
    assert as_mesh(mesh) is mesh
    path = tmp_path / "t.off"
    path.write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n")
    for thing in (path, str(path)):
        assert as_mesh(thing).path == path
    ball = trimesh.creation.icosphere(1)
    for thing, n in (((V, F), 4), ([V, F], 4), (SimpleNamespace(vertices=V, faces=F), 4), (ball, 42)):
        mesh = as_mesh(thing)
        assert type(mesh.vertices) is np.ndarray and len(mesh.vertices) == n and mesh.path is None


@pytest.mark.parametrize("thing", [None, 3, (V,), (V, F, F), {"vertices": V}, V])
def test_as_mesh_refuses(thing):
    with pytest.raises(MeshError, match="is not a mesh: give a path"):
        as_mesh(thing)


def test_as_mesh_of_a_missing_file():
    with pytest.raises(FormatError, match=r"nowhere\.off: no such file"):
        as_mesh("nowhere.off")
