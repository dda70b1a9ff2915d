"""Sparse factors against numpy's dense solution."""

import numpy as np
import pytest
import scipy.sparse as sp

from mobius_match.geometry.cholesky import Pattern, factorized
from mobius_match.geometry.laplacian import intrinsic_mesh
from tests.shapes import bent, grid, lump


@pytest.mark.parametrize("shape", [lump(2), bent(grid())])
def test_one_pattern_solves_all_that_has_it(shape):
    mesh = intrinsic_mesh(*shape)
    laplacian, generator = mesh.laplacian, np.random.default_rng(0)
    right = generator.normal(size=mesh.n_vertices)
    for step, diagonal in (
        (1.0, mesh.masses),
        (0.01, 3 * mesh.masses),
        (2.0, generator.uniform(1, 2, mesh.n_vertices)),
    ):
        found = mesh.pattern.factors(step * laplacian.data, diagonal).solve(right)
        expected = np.linalg.solve(step * laplacian.toarray() + np.diag(diagonal), right)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_several_columns_at_once():
    mesh, generator = intrinsic_mesh(*lump(2)), np.random.default_rng(0)
    factors = mesh.pattern.factors(mesh.laplacian.data, mesh.masses)
    right = generator.normal(size=(mesh.n_vertices, 3))
    found = factors.solve(right)
    assert found.shape == right.shape
    np.testing.assert_array_equal(found, np.stack([factors.solve(column) for column in right.T], axis=1))


def test_other_entries_and_zeros_among_them():
    """Random symmetric matrices that are not definite, entries of the pattern left out."""
    generator = np.random.default_rng(1)
    filled = np.triu(generator.random((40, 40)) < 0.1, 1)
    filled = filled | filled.T | np.eye(40, dtype=bool)
    matrix = sp.csr_matrix(filled.astype(float))
    pattern = Pattern(matrix, np.full(40, 40.0))
    values = np.where(filled & filled.T, generator.normal(size=(40, 40)), 0)
    values = values + values.T + np.diag(generator.choice([-9.0, 9.0], 40))
    values[3, values[3] < 0] = values[values[3] < 0, 3] = 0
    values[3, 3] = 5.0
    right = generator.normal(size=40)
    rows, columns = matrix.nonzero()
    found = pattern.factors(values[rows, columns]).solve(right)
    np.testing.assert_allclose(values @ found, right, atol=1e-9)


def test_a_single_matrix():
    mesh = intrinsic_mesh(*lump(2))
    matrix = mesh.laplacian + sp.diags(mesh.masses)
    right = np.random.default_rng(0).normal(size=(mesh.n_vertices, 3))
    found = factorized(matrix).solve(right)
    np.testing.assert_allclose(matrix @ found, right, atol=1e-10)
    np.testing.assert_allclose(found, mesh.pattern.factors(mesh.laplacian.data, mesh.masses).solve(right), rtol=1e-9)


def test_a_pattern_of_a_singular_matrix_solves_others():
    """A vertex without area, and without cotangents, has a row of zeros."""
    mesh = intrinsic_mesh(*lump(2))
    singular, masses = mesh.laplacian.copy(), mesh.masses.copy()
    singular.data[singular.indptr[5] : singular.indptr[6]] = 0.0
    singular.data[singular.indices == 5] = 0.0
    masses[5] = 0.0
    pattern = Pattern(singular, masses)
    right = np.random.default_rng(0).normal(size=mesh.n_vertices)
    found = pattern.factors(mesh.laplacian.data, mesh.masses).solve(right)
    expected = np.linalg.solve(mesh.laplacian.toarray() + np.diag(mesh.masses), right)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
