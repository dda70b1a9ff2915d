"""Eigenfunctions of the Laplacian, the wave kernel signature and functional maps."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla

from .laplacian import IntrinsicMesh

SHIFT = 1e-2
"""Eigenvalues are computed by shift and invert around minus this, as the Laplacian itself is singular."""

RIDGE = 1e-11
"""Regularisation of the least squares of a functional map, as a fraction of the trace."""


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
    # Scaling by the square roots of the masses gives an ordinary eigenproblem. The fixed start vector makes results
    # reproducible.
    root = np.sqrt(mesh.masses)
    start = root * np.random.default_rng(0).standard_normal(mesh.n_vertices)
    inverse = mesh.pattern.factors(mesh.laplacian.data, SHIFT * mesh.masses)
    shape = (mesh.n_vertices, mesh.n_vertices)
    operator = spla.LinearOperator(shape, matvec=lambda x: root * inverse.solve(root * x.ravel()), dtype=np.float64)
    # A tolerance would end the iteration before round-off has produced all copies of a multiple eigenvalue.
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
        (count,) and (p, count) from :func:`eigenbasis`; the rows may be those of a subset of points.
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
        (p, energies) float64, without units; invariant under isometries and scaling.
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
        (p, k1) and (p, k2): the eigenfunctions at points of the source and at their images. The map C minimises
        ``|source C - target|``.
    """
    # Normal equations take a fifth of the time of an orthogonal decomposition, and are well conditioned, as
    # eigenfunctions are nearly orthogonal. With too few points the ridge selects the smallest solution.
    source, target = source.astype(np.float64, copy=False), target.astype(np.float64, copy=False)
    gram = source.T @ source
    gram[np.diag_indices_from(gram)] += RIDGE * np.trace(gram)
    return np.linalg.solve(gram, source.T @ target)
