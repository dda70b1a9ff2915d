"""Large meshes: computed on a simplified one, reported in the user's own vertices."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.mesh import Mesh
from mobius_match.surface.simplified import simplified
from tests.shapes import lump, renumbered, rotation


@pytest.fixture(scope="module")
def large():
    vertices, faces = lump(5)
    # One vertex more, that no face uses: numbers of the user's list and of the repaired mesh differ.
    return np.vstack([[9.0, 9.0, 9.0], vertices]), faces + 1


@pytest.fixture(scope="module")
def surface(large):
    return mm.prepare(large, samples=60, resolution=1500)


def test_a_small_mesh_is_not_simplified():
    mesh = Mesh(*lump(3))
    assert simplified(mesh, 600, 1.5) == (mesh, None)
    assert simplified(mesh, 600, 1.0)[1] is not None


def test_the_users_vertices_lie_on_the_simplified_mesh(surface):
    simple, detail = surface.mesh, surface.detail
    places = detail.places(simple)
    whole = surface.whole_mesh
    assert len(simple.vertices) == 1500
    assert len(whole.vertices) == 10242
    np.testing.assert_array_equal(whole.vertices[detail.kept], simple.vertices)
    np.testing.assert_array_equal(whole.vertex_ids[detail.kept], simple.vertex_ids)
    size = np.ptp(whole.vertices, axis=0).max()
    apart = np.linalg.norm(places.values(simple.vertices) - whole.vertices, axis=1) / size
    assert apart.mean() < 0.002
    assert apart.max() < 0.02
    np.testing.assert_array_equal(places[detail.kept].nearest, np.arange(1500))
    assert np.ptp(places.barycentric.sum(axis=1)) < 1e-6


def test_points_are_lifted_to_the_users_mesh(surface):
    simple, detail = surface.mesh, surface.detail
    there = detail.places(simple)[np.arange(0, 10242, 7)]
    lifted = detail.lifted(simple, there)
    np.testing.assert_array_equal(lifted.corners, surface.whole_mesh.faces[lifted.faces])
    size = np.ptp(surface.whole_mesh.vertices, axis=0).max()
    apart = np.linalg.norm(
        lifted.values(surface.whole_mesh.vertices) - surface.whole_mesh.vertices[np.arange(0, 10242, 7)], axis=1
    )
    assert apart.max() < 0.02 * size


def test_matches_have_the_users_own_numbers(large, surface):
    vertices, faces = large
    (moved, moved_faces), new = renumbered((vertices @ rotation().T, faces), seed=4)
    result = mm.match(surface, mm.prepare((moved, moved_faces), samples=60, resolution=1500))
    assert len(result) > 30
    assert len(np.unique(result.pairs[:, 1])) == len(result)
    points = result.target_points
    np.testing.assert_array_equal(np.sort(points.corners), np.sort(moved_faces[points.faces]))
    size = np.ptp(vertices, axis=0).max()
    true = moved[new[result.pairs[:, 0]]]
    assert np.linalg.norm(points.values(moved) - true, axis=1).mean() < 0.01 * size
    assert np.linalg.norm(moved[result.pairs[:, 1]] - true, axis=1).mean() < 0.015 * size


def test_the_dense_map_covers_all_the_users_vertices(large, surface):
    vertices, faces = large
    (moved, moved_faces), new = renumbered((vertices @ rotation().T, faces), seed=4)
    target = mm.prepare((moved, moved_faces), samples=60, resolution=1500)
    found = mm.match(surface, target).dense()
    assert found.vertex_map[0] == -1  # which no face uses
    assert (found.vertex_map[1:] >= 0).all()
    size = np.ptp(vertices, axis=0).max()
    apart = np.linalg.norm(moved[found.vertex_map[1:]] - moved[new[1:]], axis=1) / size
    assert apart.mean() < 0.01
    carried = found.transfer(vertices)[new[1:]]
    assert np.nanmean(np.linalg.norm(carried - vertices[1:], axis=1)) < 0.01 * size


def test_a_simplified_surface_is_saved_and_loaded(surface, tmp_path):
    assert len(surface.descriptors) == len(surface.mesh.vertices)  # computed on demand, not saved
    surface.save(tmp_path / "surface.npz")
    found = mm.Surface.load(tmp_path / "surface.npz")
    for one, other in ((surface.mesh, found.mesh), (surface.whole_mesh, found.whole_mesh)):
        np.testing.assert_array_equal(one.vertex_ids, other.vertex_ids)
        np.testing.assert_array_equal(one.faces, other.faces)
    for name in ("kept", "faces", "barycentric"):
        one, other = (getattr(of.detail, name) for of in (surface, found))
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


def test_resolution_0_uses_every_vertex(large):
    surface = mm.prepare(large, samples=20, resolution=0)
    assert surface.detail is None
    assert len(surface.mesh.vertices) == len(surface.eigenfunctions) == 10242
