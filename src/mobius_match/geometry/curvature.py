"""Gauss and mean curvature, smoothed so that two triangulations of one shape agree."""

from __future__ import annotations

import numpy as np

from ..mesh.measure import cross_products, vertex_sums
from .laplacian import IntrinsicMesh, corner_angles, intrinsic_mesh


def gauss_curvature(mesh: IntrinsicMesh, radius: float, *, steps: int = 5) -> np.ndarray:
    """Gauss curvature (n,) from the angle deficit (Desbrun et al. 2002), smoothed, times the surface's area.

    At a boundary the deficit is the geodesic curvature of the boundary, not Gauss curvature: it is taken as zero.

    Parameters
    ----------
    mesh
        Any triangulation of the surface.
    radius
        Width of the smoothing per sqrt(area).
    steps
        Number of implicit heat steps, see :func:`smoothed_density`.
    """
    angle_sum = np.bincount(mesh.faces.ravel(), corner_angles(mesh.lengths).ravel(), mesh.n_vertices)
    return smoothed_density(mesh, np.where(_on_boundary(mesh), 0.0, 2 * np.pi - angle_sum), radius, steps=steps)


def mean_curvature(
    mesh: IntrinsicMesh, vertices: np.ndarray, faces: np.ndarray, radius: float, *, steps: int = 5
) -> np.ndarray:
    """Mean curvature (n,), smoothed, times sqrt(area); positive where the surface bulges outwards.

    Parameters
    ----------
    mesh
        A triangulation of the surface, for the Laplacian and the smoothing.
    vertices, faces
        The mesh in space, consistently oriented, for normals.
    radius
        Width of the smoothing per sqrt(area).
    steps
        Number of implicit heat steps, see :func:`smoothed_density`.
    """
    normals = vertex_sums(faces, cross_products(vertices, faces), len(vertices))
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    # The Laplacian of the position is the mean curvature normal, integrated over the vertex's cell.
    integrated = 0.5 * np.einsum("ij,ij->i", mesh.laplacian @ vertices, normals)
    scale = np.sqrt(mesh.areas.sum())
    return smoothed_density(mesh, np.where(_on_boundary(mesh), 0.0, integrated / scale), radius, steps=steps)


def curvatures(vertices: np.ndarray, faces: np.ndarray, radii: tuple[float, ...], *, steps: int = 5) -> np.ndarray:
    """Gauss and mean curvature smoothed to each radius, (n, 2 * radii); both in the units of the vertices."""
    mesh = intrinsic_mesh(vertices, faces)
    size = np.sqrt(mesh.areas.sum())
    columns = []
    for radius in radii:
        columns.append(gauss_curvature(mesh, radius / size, steps=steps) / size**2)
        columns.append(mean_curvature(mesh, vertices, faces, radius / size, steps=steps) / size)
    return np.stack(columns, axis=1)


def rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Spearman's rank correlation, ties in order; 0 if one of the two is constant.

    (Importing scipy.stats takes half a second.)
    """
    if np.ptp(first) == 0 or np.ptp(second) == 0:
        return 0.0
    return float(np.corrcoef(ranks(first), ranks(second))[0, 1])


def ranks(values: np.ndarray) -> np.ndarray:
    """The rank (n,) int64 of each value, from 0, ties in order."""
    return np.argsort(np.argsort(values, kind="stable"))


def smoothed_density(mesh: IntrinsicMesh, integrated: np.ndarray, radius: float, *, steps: int = 5) -> np.ndarray:
    """A quantity given as integrals over the vertices' cells (n,), as a density on the surface scaled to area 1.

    The density is smoothed by implicit Euler steps of the heat equation, which keep its integral.

    Parameters
    ----------
    mesh
        Any triangulation of the surface.
    integrated
        (n,) integrals over the vertices' cells.
    radius
        Width r of the smoothing per sqrt(area): heat flows for the time r^2.
    steps
        Number of equal steps that this time is divided into. More steps come closer to a Gaussian.
    """
    # The Laplacian has no units in two dimensions; masses of a unit surface make the step free of scale.
    heat = mesh.pattern.factors(radius**2 / steps * mesh.laplacian.data, mesh.masses)
    density = heat.solve(integrated)
    for _ in range(steps - 1):
        density = heat.solve(mesh.masses * density)
    return density


def _on_boundary(mesh: IntrinsicMesh) -> np.ndarray:
    one_face = np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges)[mesh.face_edges] == 1
    boundary = np.zeros(mesh.n_vertices, bool)
    boundary[mesh.faces[:, [1, 2, 0]][one_face]] = True
    boundary[mesh.faces[:, [2, 0, 1]][one_face]] = True
    return boundary
