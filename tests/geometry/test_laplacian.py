"""Laplacian, curvature's angles, areas: values known from triangles, spheres and flat sheets."""

import numpy as np
import pytest

from mobius_match.geometry.laplacian import (
    corner_angles,
    corner_cotangents,
    cotangent_laplacian,
    face_areas,
    intrinsic_mesh,
    mollified,
    vertex_areas,
)
from tests.shapes import bent, grid, icosphere, lump


def test_one_right_triangle():
    lengths = np.array([[5.0, 4.0, 3.0]])
    np.testing.assert_allclose(face_areas(lengths), [6.0], rtol=1e-15)
    np.testing.assert_allclose(corner_angles(lengths), [[np.pi / 2, np.arctan2(4, 3), np.arctan2(3, 4)]], rtol=1e-15)
    np.testing.assert_allclose(corner_cotangents(lengths), [[0.0, 3 / 4, 4 / 3]], atol=1e-15)


def test_needle_keeps_its_area():
    """Heron's formula as it stands in books loses all digits here."""
    lengths = np.array([[1e-8, 1.0, 1.0]])
    np.testing.assert_allclose(face_areas(lengths), [0.5e-8], rtol=1e-12)


@pytest.mark.parametrize("delaunay", [False, True])
@pytest.mark.parametrize("shape", [icosphere(2), bent(grid()), lump(2)])
def test_laplacian_annihilates_constants_and_areas_add_up(shape, delaunay):
    mesh = intrinsic_mesh(*shape, delaunay=delaunay)
    laplacian = cotangent_laplacian(mesh)
    assert abs(laplacian - laplacian.T).max() < 1e-12
    np.testing.assert_allclose(laplacian @ np.ones(mesh.n_vertices), 0, atol=1e-11)
    assert vertex_areas(mesh).sum() == pytest.approx(face_areas(mesh.lengths).sum(), rel=1e-12)
    np.testing.assert_array_equal(np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges) > 0, True)


def test_laplacian_of_coordinates_vanishes_inside_a_flat_sheet():
    vertices, faces = grid(7, 6)
    rng = np.random.default_rng(0)
    interior = (vertices[:, 0] % 7 > 0) & (vertices[:, 1] % 6 > 0)
    vertices[interior, :2] += rng.uniform(-0.2, 0.2, (interior.sum(), 2))
    laplacian = cotangent_laplacian(intrinsic_mesh(vertices, faces, delaunay=False))
    np.testing.assert_allclose((laplacian @ vertices)[interior], 0, atol=1e-12)


def test_intrinsic_delaunay_has_no_negative_weight():
    """Opposite angles of every edge add to at most pi, so cotangents to at least zero; the mesh's own do not."""
    vertices, faces = lump(3)
    vertices = vertices * [1.0, 1.0, 3.0]

    def least_weight(mesh):
        weights = np.bincount(mesh.face_edges.ravel(), corner_cotangents(mesh.lengths).ravel(), mesh.n_edges)
        return weights.min()

    assert least_weight(intrinsic_mesh(vertices, faces, delaunay=False)) < -0.1
    assert least_weight(intrinsic_mesh(vertices, faces, delaunay=True)) > -1e-9


def test_a_short_text():
    assert repr(intrinsic_mesh(*icosphere(1))) == "IntrinsicMesh(42 vertices, 80 faces, 120 edges)"


def test_edges_are_glued_by_length():
    """Both sides of an edge have the same length, also where two edges join the same vertices."""
    mesh = intrinsic_mesh(*lump(3))
    by_edge = np.full(mesh.n_edges, np.nan)
    by_edge[mesh.face_edges] = mesh.lengths
    np.testing.assert_allclose(by_edge[mesh.face_edges], mesh.lengths, rtol=1e-9)
    np.testing.assert_array_equal(np.bincount(mesh.face_edges.ravel()), 2)


def test_mollification_opens_flat_faces_and_leaves_others_alone():
    fine = np.array([[3.0, 4.0, 5.0], [1.0, 1.0, 1.0]])
    assert mollified(fine) is fine
    flat = np.array([[2.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
    opened = mollified(flat)
    assert (face_areas(opened) > 0).all()
    np.testing.assert_allclose(opened, flat, atol=1e-5)
