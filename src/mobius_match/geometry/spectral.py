"""Eigenfunctions of the Laplacian and the wave kernel signature."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla

from .laplacian import IntrinsicMesh

SHIFT = 1e-2
"""Eigenvalues are looked for about minus this: the Laplacian itself is singular."""

RIDGE = 1e-11
"""Added to squares, per their sum, where a map of functions is fitted."""


def eigenbasis(mesh: IntrinsicMesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The lowest eigenpairs of the Laplacian, scaled to a surface of area 1.

    Returns
    -------
    eigenvalues
        (count,) float64, ascending, times the surface's area: free of units.
    eigenfunctions
        (n, count) float64, orthonormal for areas that sum to 1.
    """
    count = min(count, mesh.n_vertices - 2)
    # In the square roots of the masses the problem is an ordinary one. The fixed start vector makes the result the
    # same from run to run.
    root = np.sqrt(mesh.masses)
    start = root * np.random.default_rng(0).standard_normal(mesh.n_vertices)
    inverse = mesh.pattern.factors(mesh.laplacian.data, SHIFT * mesh.masses)
    shape = (mesh.n_vertices, mesh.n_vertices)
    operator = spla.LinearOperator(shape, matvec=lambda x: root * inverse.solve(root * x.ravel()), dtype=np.float64)
    # No tolerance: it would end the search before round-off has brought all copies of a multiple eigenvalue.
    values, functions = spla.eigsh(operator, count, which="LM", v0=start)
    order = np.argsort(-values)
    return np.maximum(1 / values[order] - SHIFT, 0.0), functions[:, order] / root[:, None]


def wave_kernel_signature(
    eigenvalues: np.ndarray,
    eigenfunctions: np.ndarray,
    *,
    energies: int = 100,
    spread: float = 7.0,
    top: float = 1.02,
) -> np.ndarray:
    """Wave kernel signature (Aubry et al. 2011) of each row of eigenfunctions.

    Parameters
    ----------
    eigenvalues, eigenfunctions
        (count,) and (p, count), as :func:`eigenbasis` gives them; rows of a subset of points will do.
    energies
        Number of levels of the logarithm of the energy, evenly spaced.
    spread
        Standard deviation of the Gaussian around each level, in steps from one level to the next.
    top
        The highest level is the logarithm of the largest eigenvalue, divided by this: above it few eigenfunctions
        remain.

    Returns
    -------
    numpy.ndarray
        (p, energies) float64, without units; equal on isometric points whatever the scale of the mesh.
    """
    log_energy = np.log(np.maximum(eigenvalues[1:], 1e-6))
    levels = np.linspace(log_energy[0], log_energy[-1] / top, energies)
    deviation = spread * (levels[1] - levels[0])
    weights = np.exp(-((levels[:, None] - log_energy[None, :]) ** 2) / (2 * deviation**2))
    weights /= weights.sum(axis=1, keepdims=True)
    return eigenfunctions[:, 1:] ** 2 @ weights.T


def functional_map(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The functional map (k1, k2) of a pointwise map (Ovsjanikov et al. 2012).

    Parameters
    ----------
    source, target
        (p, k1) and (p, k2): the eigenfunctions at points of the source and at their images. The map takes a row of
        the first to the row of the second, in the sense of least squares.
    """
    # A fifth of the time of an orthogonal decomposition, and eigenfunctions are nearly orthogonal. Where there are too
    # few points to tell, the ridge leaves the least of all solutions.
    source, target = source.astype(np.float64, copy=False), target.astype(np.float64, copy=False)
    gram = source.T @ source
    gram[np.diag_indices_from(gram)] += RIDGE * np.trace(gram)
    return np.linalg.solve(gram, source.T @ target)
