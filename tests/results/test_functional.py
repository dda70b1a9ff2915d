"""Functional maps and their bases: orthonormality, the identity, units, transported functions, and a dense twin."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

import mobius_match as mm
from mobius_match.geometry.laplacian import intrinsic_mesh
from mobius_match.geometry.points import points_at
from mobius_match.results.surface_map import SurfaceMap
from tests.shapes import icosphere, lump, renumbered


def made(arrays):
    return mm.prepare(arrays, samples=10, resolution=0).mesh


def vertex_map(source, target, there):
    """The map that takes vertex i of the source to vertex there[i] of the target, a permutation."""
    back = np.argsort(there)
    points, sources = points_at(target.faces, there), points_at(source.faces, back)
    return SurfaceMap(source, target, points, sources, np.full(len(there), True), np.full(len(there), True))


@pytest.fixture(scope="module")
def mesh():
    return made(lump(3))


@pytest.fixture(scope="module")
def identity(mesh):
    return vertex_map(mesh, mesh, np.arange(len(mesh.vertices)))


def test_the_identity_is_the_identity(identity):
    np.testing.assert_allclose(identity.functional_map(40), np.eye(40), atol=1e-8)


def test_bases_are_orthonormal_for_areas_and_solve_the_eigenvalue_problem(identity, mesh):
    basis, again = identity.eigenbases(30)
    np.testing.assert_array_equal(basis.eigenfunctions, again.eigenfunctions)
    gram = basis.eigenfunctions.T @ (basis.areas[:, None] * basis.eigenfunctions)
    np.testing.assert_allclose(gram, np.eye(30), atol=1e-9)
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    lumped = np.bincount(mesh.faces.ravel(), np.repeat(areas / 3, 3))
    np.testing.assert_allclose(basis.areas, lumped, rtol=1e-9)
    # An independent twin: all eigenpairs of the dense problem.
    laplacian = intrinsic_mesh(mesh.vertices, mesh.faces, delaunay=False).laplacian.toarray()
    values = scipy.linalg.eigh(laplacian, np.diag(lumped), eigvals_only=True)[:30]
    np.testing.assert_allclose(basis.eigenvalues, values, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(
        laplacian @ basis.eigenfunctions, lumped[:, None] * basis.eigenfunctions * basis.eigenvalues, atol=1e-6
    )


def test_eigenvalues_of_a_sphere_and_units():
    radius = 5.0
    vertices, faces = icosphere(4)
    sphere = made((radius * vertices, faces))
    basis, _ = vertex_map(sphere, sphere, np.arange(len(vertices))).eigenbases(9)
    # l (l + 1) / r^2, 2 l + 1 times each.
    np.testing.assert_allclose(basis.eigenvalues, np.repeat([0, 2, 6], [1, 3, 5]) / radius**2, rtol=0.01, atol=1e-9)
    np.testing.assert_allclose(np.abs(basis.eigenfunctions[:, 0]), 1 / np.sqrt(4 * np.pi * radius**2), rtol=0.01)


def test_functions_are_transported_from_source_to_target(mesh):
    """The target is renumbered, twice as large, and the direction of the map matters."""
    (vertices, faces), new = renumbered(lump(3), 3)
    target = made((2 * vertices, faces))
    surface_map = vertex_map(mesh, target, new)
    source_basis, target_basis = surface_map.eigenbases(60)
    C = surface_map.functional_map(60)
    assert C.shape == (60, 60)
    smooth = mesh.vertices @ [1.0, 2.0, -1.0] + mesh.vertices[:, 0] ** 2
    moved = np.empty_like(smooth)
    moved[new] = smooth
    coefficients = source_basis.eigenfunctions.T @ (source_basis.areas * smooth)
    found = target_basis.eigenfunctions @ (C @ coefficients)
    assert np.abs(found - moved).max() < 0.1 * np.ptp(smooth)
    assert np.sqrt(np.mean((found - moved) ** 2)) < 0.02 * np.ptp(smooth)
    # An isometry up to scale: orthogonal but for the scale, and the inverse's map is its inverse.
    np.testing.assert_allclose(C @ C.T, 4 * np.eye(60), atol=1e-5)
    np.testing.assert_allclose(surface_map.inverse.functional_map(60) @ C, np.eye(60), atol=1e-5)


def test_it_is_the_projection_that_pyfm_computes(mesh):
    """FM = evects2.T @ A2 @ evects1[p2p_21], with areas A2 and vertices p2p_21 of mesh 1 for those of mesh 2."""
    target = made(renumbered(lump(3), 3)[0])
    there = np.random.default_rng(0).permutation(len(mesh.vertices))
    surface_map = vertex_map(mesh, target, there)
    one, two = surface_map.eigenbases(20)
    expected = two.eigenfunctions.T @ (two.areas[:, None] * one.eigenfunctions[np.argsort(there)])
    np.testing.assert_allclose(surface_map.functional_map(20), expected, atol=1e-8)


def test_vertices_without_counterpart_are_left_out(identity, mesh):
    rng = np.random.default_rng(1)
    mapped = rng.random(len(mesh.vertices)) < 0.7
    wrong = points_at(mesh.faces, np.where(mapped, np.arange(len(mapped)), 0))
    part = replace(identity, source_points=wrong, target_mapped=mapped)
    np.testing.assert_allclose(part.functional_map(20), np.eye(20), atol=1e-6)
    few = replace(identity, target_mapped=np.arange(len(mapped)) < 10)
    with pytest.raises(mm.SettingsError, match=r"^`k` is 20, and only 10 vertices"):
        few.functional_map(20)


def test_rows_count_as_the_users_file():
    vertices, faces = lump(2)
    padded = made((np.concatenate([np.full((3, 3), 9.0), vertices]), faces + 3))
    mesh = made((vertices, faces))
    points = points_at(mesh.faces, np.arange(len(vertices)))
    every = np.full(len(vertices), True)
    padded_basis, basis = SurfaceMap(padded, mesh, points, points, every, every).eigenbases(5)
    assert padded_basis.eigenfunctions.shape == (len(vertices) + 3, 5)
    assert np.isnan(padded_basis.eigenfunctions[:3]).all()
    assert (padded_basis.areas[:3] == 0).all()
    np.testing.assert_allclose(np.abs(padded_basis.eigenfunctions[3:]), np.abs(basis.eigenfunctions), atol=1e-6)
    np.testing.assert_allclose(padded_basis.areas[3:], basis.areas)


@pytest.mark.parametrize("k", [0, -1, 2.0, True, 641, None])
def test_numbers_of_functions_that_there_are_not(identity, k):
    with pytest.raises(mm.SettingsError, match=r"^`k` is .*from 1 to 640"):
        identity.functional_map(k)
    with pytest.raises(mm.SettingsError, match=r"^`k` is .*from 1 to 640"):
        identity.eigenbases(k)


def test_dense_maps_of_matches_have_one():
    shape = lump(3)
    (vertices, faces), _ = renumbered(shape, 2)
    dense = mm.match(shape, (vertices, faces)).dense()
    C = dense.functional_map(20)
    np.testing.assert_allclose(C @ C.T, np.eye(20), atol=0.05)
