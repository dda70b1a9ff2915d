"""Smoothing of densities, whose effect on eigenfunctions is known; ranks and their correlation."""

import numpy as np
import pytest
from scipy.stats import spearmanr

from mobius_match.geometry.curvature import Curvatures, rank_correlation, ranks, smoothed_density
from mobius_match.geometry.laplacian import intrinsic_mesh
from mobius_match.geometry.spectral import eigenbasis
from tests.shapes import bent, grid, icosphere, lump


@pytest.mark.parametrize("steps", [1, 5, 12])
@pytest.mark.parametrize("shape", [lump(3), bent(grid(12, 9))])
def test_eigenfunctions_decay_as_implicit_steps_make_them(shape, steps):
    mesh, radius = intrinsic_mesh(*shape), 0.1
    eigenvalues, functions = eigenbasis(mesh, 12)
    for eigenvalue, function in zip(eigenvalues, functions.T, strict=True):
        found = smoothed_density(mesh, mesh.masses * function, radius, steps=steps)
        expected = function / (1 + radius**2 * eigenvalue / steps) ** steps
        np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(function).max())


def test_the_integral_is_kept():
    mesh = intrinsic_mesh(*lump(3))
    integrated = np.random.default_rng(0).normal(size=mesh.n_vertices)
    for steps in (1, 5):
        density = smoothed_density(mesh, integrated, 0.05, steps=steps)
        assert mesh.masses @ density == pytest.approx(integrated.sum(), abs=1e-9)


def test_curvatures_of_a_sphere_in_its_units():
    """1 / r^2 and 1 / r at every radius of the smoothing."""
    vertices, faces = icosphere(3)
    found = Curvatures(4 * vertices, faces).smoothed((0.8, 1.6))
    np.testing.assert_allclose(found, np.tile([1 / 16, 1 / 4], (len(vertices), 2)), rtol=0.02)


def test_rank_correlation_is_spearmans():
    generator = np.random.default_rng(0)
    first = generator.normal(size=50)
    second = first + generator.normal(size=50)
    assert rank_correlation(first, second) == pytest.approx(spearmanr(first, second).statistic)
    assert rank_correlation(first, np.exp(3 * first)) == pytest.approx(1)
    assert rank_correlation(first, np.zeros(50)) == 0
    np.testing.assert_array_equal(ranks(np.array([3.0, 1.0, 3.0, 2.0])), [2, 0, 3, 1])
