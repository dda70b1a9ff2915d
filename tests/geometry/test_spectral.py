"""Eigenfunctions of the sphere, and the invariances of the wave kernel signature."""

import numpy as np

from mobius_match.geometry.laplacian import intrinsic_mesh, vertex_areas
from mobius_match.geometry.spectral import eigenbasis, wave_kernel_signature
from tests.shapes import icosphere, lump, renumbered, rotation


def test_sphere_has_the_eigenvalues_of_spherical_harmonics():
    mesh = intrinsic_mesh(*icosphere(4))
    eigenvalues, functions = eigenbasis(mesh, 16)
    degrees = np.repeat(np.arange(4), 2 * np.arange(4) + 1)
    np.testing.assert_allclose(eigenvalues, 4 * np.pi * degrees * (degrees + 1), rtol=0.01, atol=1e-6)
    areas = vertex_areas(mesh)
    np.testing.assert_allclose(functions.T @ (areas[:, None] / areas.sum() * functions), np.eye(16), atol=1e-9)


def test_signature_does_not_change_with_scale_rotation_or_numbering():
    vertices, faces = lump(3)
    (moved, moved_faces), new = renumbered((1000 * vertices @ rotation().T, faces))
    first = wave_kernel_signature(*eigenbasis(intrinsic_mesh(vertices, faces), 30))
    second = wave_kernel_signature(*eigenbasis(intrinsic_mesh(moved, moved_faces), 30))
    np.testing.assert_allclose(second[new], first, rtol=1e-5)
    assert np.ptp(first, axis=0).min() > 0.1 * first.mean()  # and it tells points apart


def test_levels_are_means_over_eigenfunctions():
    """Where all squared eigenfunctions are equal, so is every level: the weights of a level sum to 1."""
    eigenvalues = np.arange(20.0)
    found = wave_kernel_signature(eigenvalues, np.full((3, 20), 0.5), energies=7, spread=2.0, top=1.1)
    np.testing.assert_allclose(found, np.full((3, 7), 0.25))


def test_a_narrow_spread_selects_single_eigenfunctions():
    """Levels are evenly spaced logarithms, from the first eigenvalue above zero to the largest where ``top`` is 1."""
    eigenvalues, functions = np.array([0.0, 1, 2, 4, 8, 16]), np.array([[1.0, 2, 3, 4, 5, 6]])
    found = wave_kernel_signature(eigenvalues, functions, energies=5, spread=0.01, top=1.0)
    np.testing.assert_allclose(found, functions[:, 1:] ** 2)
