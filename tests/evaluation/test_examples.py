"""The example shapes: closed, well meshed, independently meshed, with a correct ground truth."""

import subprocess
import sys

import numpy as np
import pytest

from mobius_match.errors import SettingsError
from mobius_match.evaluation import examples
from mobius_match.mesh import Mesh, read_mesh, require_matchable

pytestmark = pytest.mark.parametrize("name", examples.names())
MAPS = [(mirrored, reverse) for mirrored in (False, True) for reverse in (False, True)]


@pytest.fixture
def meshes(name: str) -> tuple[Mesh, Mesh]:
    first, second = examples.paths(name)
    return read_mesh(first), read_mesh(second)


def edge_length(mesh: Mesh) -> float:
    """Mean length of the edges."""
    sides = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
    return float(np.linalg.norm(sides, axis=2).mean())


def carried(target: Mesh, faces: np.ndarray, barycentric: np.ndarray, values: np.ndarray | None = None) -> np.ndarray:
    """Values (k, d) at the points of a map into the target; its coordinates by default."""
    values = target.vertices if values is None else values
    return np.einsum("ki,kij->kj", barycentric, values[target.faces[faces]])


def normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def test_files_hold_what_their_headers_say(name, meshes):
    for path, mesh in zip(examples.paths(name), meshes, strict=True):
        header = path.read_bytes().split(b"end_header\n")[0].decode("ascii").splitlines()
        assert header[:2] == ["ply", "format binary_little_endian 1.0"]
        assert f"element vertex {len(mesh.vertices)}" in header
        assert f"element face {len(mesh.faces)}" in header
        assert 4900 <= len(mesh.vertices) <= 5100
        assert mesh.notes == ()


def test_closed_genus_zero_outward(name, meshes):
    for mesh in meshes:
        require_matchable(mesh)
        directed = {(int(f[i]), int(f[i - 1])) for f in mesh.faces for i in range(3)}
        assert len(directed) == 3 * len(mesh.faces)  # no directed edge twice: manifold along edges, oriented
        assert {(b, a) for a, b in directed} == directed  # closed
        assert len(mesh.vertices) - len(directed) // 2 + len(mesh.faces) == 2  # genus 0, all vertices used
        corners = mesh.vertices[mesh.faces]
        assert np.linalg.det(corners).sum() / 6 > 0.03  # cubic metres: positive is outward
        assert mesh.vertices[:, 1].min() == pytest.approx(0, abs=0.01)  # it stands on the ground


def test_triangles_are_well_shaped(name, meshes):
    for mesh in meshes:
        corners = mesh.vertices[mesh.faces]
        one, two = (np.roll(corners, -k, axis=1) - corners for k in (1, 2))
        cosine = (one * two).sum(axis=2) / np.linalg.norm(one, axis=2) / np.linalg.norm(two, axis=2)
        smallest = np.degrees(np.arccos(cosine)).min(axis=1)
        assert smallest.min() > 25
        assert np.median(smallest) > 50


def test_poses_share_no_triangulation_and_no_order(name, meshes):
    first, second = meshes
    assert len(first.vertices) != len(second.vertices)
    _, barycentric = examples.truth(name)
    assert (barycentric.max(axis=1) > 0.99).mean() < 0.01  # vertices of one do not lie on vertices of the other
    for mesh in meshes:
        number = np.arange(len(mesh.vertices))
        for axis in mesh.vertices.T:
            assert abs(np.corrcoef(number, axis)[0, 1]) < 0.06  # four sigma of a random order
        step = np.linalg.norm(np.diff(mesh.vertices, axis=0), axis=1).mean()
        stride = np.linalg.norm(mesh.vertices - np.roll(mesh.vertices, 1234, axis=0), axis=1).mean()
        assert step == pytest.approx(stride, rel=0.05)


@pytest.mark.parametrize(("mirrored", "reverse"), MAPS)
def test_truth_is_well_formed(name, meshes, mirrored, reverse):
    source, target = meshes[::-1] if reverse else meshes
    faces, barycentric = examples.truth(name, mirrored=mirrored, reverse=reverse)
    assert faces.dtype == np.int64
    assert barycentric.dtype == np.float64
    assert faces.shape == (len(source.vertices),)
    assert barycentric.shape == (len(source.vertices), 3)
    assert 0 <= faces.min() <= faces.max() < len(target.faces)
    assert barycentric.min() >= 0
    assert np.abs(barycentric.sum(axis=1) - 1).max() < 4e-16


@pytest.mark.parametrize(("mirrored", "reverse"), MAPS)
def test_the_round_trip_returns_to_the_vertex(name, meshes, mirrored, reverse):
    source, target = meshes[::-1] if reverse else meshes
    there = examples.truth(name, mirrored=mirrored, reverse=reverse)
    back = carried(source, *examples.truth(name, mirrored=mirrored, reverse=not reverse))
    error = np.linalg.norm(carried(target, *there, back) - source.vertices, axis=1) / edge_length(source)
    assert error.mean() < 0.06
    assert (error > 0.5).mean() < 0.005
    assert error.max() < 1  # edges; at folds thinner than an edge


@pytest.mark.parametrize("reverse", [False, True])
def test_truth_keeps_sides_and_mirrored_truth_swaps_them(name, meshes, reverse):
    source, target = meshes[::-1] if reverse else meshes
    for mirrored, sign in ((False, 1), (True, -1)):
        faces, barycentric = examples.truth(name, mirrored=mirrored, reverse=reverse)
        image = normals(carried(target, faces, barycentric), source.faces)
        there = normals(target.vertices, target.faces)[faces[source.faces[:, 0]]]
        assert ((image * there).sum(axis=1) * sign > 0).mean() > 0.99


def test_mirrored_truth_is_truth_after_reflection(name, meshes):
    first, second = meshes  # the first stands symmetrically about the plane x = 0
    back = carried(first, *examples.truth(name, reverse=True))
    reflected = carried(second, *examples.truth(name, mirrored=True), back)
    edge = edge_length(first)
    error = np.linalg.norm(reflected - first.vertices * [-1, 1, 1], axis=1) / edge
    assert error.mean() < 0.06
    assert error.max() < 1
    direct, mirrored = (carried(second, *examples.truth(name, mirrored=m)) for m in (False, True))
    assert np.linalg.norm(direct - mirrored, axis=1).mean() > 5 * edge


def test_truth_is_nearly_isometric(name, meshes):
    first, second = meshes
    image = carried(second, *examples.truth(name))
    edges = np.vstack([first.faces[:, [0, 1]], first.faces[:, [1, 2]], first.faces[:, [2, 0]]])
    before, after = (np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1) for p in (first.vertices, image))
    ratio = after / before
    assert np.median(ratio) == pytest.approx(1, abs=0.02)
    assert np.abs(ratio - 1).mean() < 0.06
    assert (np.abs(ratio - 1) > 0.5).mean() < 0.005


def test_poses_differ(name, meshes):
    """No rigid motion brings one pose to the other: distances through space change by far more than edges do."""
    first, second = meshes
    image = carried(second, *examples.truth(name))
    shuffled = np.random.default_rng(0).permutation(len(image))
    before, after = (np.linalg.norm(p - p[shuffled], axis=1) for p in (first.vertices, image))
    assert np.abs(after - before).mean() / before.mean() > 0.05


def test_small_enough_to_ship(name):
    folder = examples.paths(name)[0].parent
    assert sum(path.stat().st_size for path in folder.iterdir()) < 1.6e6


def test_unknown_name_is_refused(name):
    for call in (examples.paths, examples.truth):
        with pytest.raises(SettingsError, match=f"no example called '{name}2'.*person, quadruped"):
            call(f"{name}2")


def test_import_is_light(name):
    code = "import sys, mobius_match.evaluation.examples as e; e.paths(sys.argv[1]); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, name], capture_output=True, text=True, check=True)
    assert not {"scipy", "numba", "trimesh", "meshio", "igl"} & set(done.stdout.split())
