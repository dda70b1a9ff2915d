"""Eigenfunctions of the Laplacian and the wave kernel signature."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla

from .laplacian import IntrinsicMesh

SHIFT = 1e-2
"""Eigenvalues are looked for about minus this: the Laplacian itself is singular."""

BLOCK = 100
"""Rows whose distances are held at a time; few enough to stay near the processor."""


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


def wave_kernel_signature(eigenvalues: np.ndarray, eigenfunctions: np.ndarray, energies: int = 100) -> np.ndarray:
    """Wave kernel signature (Aubry et al. 2011) of each row of eigenfunctions.

    Parameters
    ----------
    eigenvalues, eigenfunctions
        (count,) and (p, count), as :func:`eigenbasis` gives them; rows of a subset of points will do.
    energies
        Number of energy levels.

    Returns
    -------
    numpy.ndarray
        (p, energies) float64, without units; equal on isometric points whatever the scale of the mesh.
    """
    log_energy = np.log(np.maximum(eigenvalues[1:], 1e-6))
    levels = np.linspace(log_energy[0], log_energy[-1] / 1.02, energies)
    spread = 7 * (levels[1] - levels[0])
    weights = np.exp(-((levels[:, None] - log_energy[None, :]) ** 2) / (2 * spread**2))
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
    return np.linalg.lstsq(source, target, rcond=None)[0]


def nearest_rows(queries: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Number of the nearest of ``rows`` (n, k) to each of ``queries`` (p, k), (p,) int64; the lowest of equal ones."""
    # One more column, so that the product alone is the squared distance, but for what all rows share.
    wide = np.hstack([-2 * rows, np.einsum("ij,ij->i", rows, rows)[:, None]])
    asked = np.hstack([queries, np.ones((len(queries), 1), queries.dtype)])
    found = np.empty(len(queries), np.int64)
    for start in range(0, len(queries), BLOCK):
        np.argmin(asked[start : start + BLOCK] @ wide.T, axis=1, out=found[start : start + BLOCK])
    return found
