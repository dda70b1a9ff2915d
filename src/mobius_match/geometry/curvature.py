"""Gauss and mean curvature, smoothed so that two triangulations of one shape agree."""

from __future__ import annotations

import numpy as np

from ..mesh.measure import cross_products, vertex_sums
from .laplacian import IntrinsicMesh, corner_angles, intrinsic_mesh


def gauss_curvature(mesh: IntrinsicMesh, radius: float, *, steps: int = 5) -> np.ndarray:
    """Gauss curvature (n,), smoothed, times the surface's area.

    Parameters
    ----------
    mesh
        Any triangulation of the surface.
    radius
        Width of the smoothing per sqrt(area).
    steps
        Number of implicit heat steps, see :func:`smoothed_density`.
    """
    return smoothed_density(mesh, _angle_deficits(mesh), radius, steps=steps)


def _angle_deficits(mesh: IntrinsicMesh) -> np.ndarray:
    """Gauss curvature (n,) integrated over the vertices' cells: the angle deficit (Desbrun et al. 2002).

    At a boundary the deficit is the geodesic curvature of the boundary, not Gauss curvature: it is taken as zero.
    """
    angle_sum = np.bincount(mesh.faces.ravel(), corner_angles(mesh.lengths).ravel(), mesh.n_vertices)
    return np.where(_on_boundary(mesh), 0.0, 2 * np.pi - angle_sum)


def integrated_curvatures(mesh: IntrinsicMesh, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Gauss and mean curvature (n, 2) integrated over the vertices' cells, for :func:`smoothed_density`.

    Mean curvature is positive where the surface bulges outwards, and divided by sqrt(area), which makes it free of
    units. Both are 0 at the boundary.

    Parameters
    ----------
    mesh
        A triangulation of the surface, for the Laplacian.
    vertices, faces
        The mesh in space, consistently oriented, for normals.
    """
    normals = vertex_sums(faces, cross_products(vertices, faces), len(vertices))
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    # The Laplacian of the position is the mean curvature normal, integrated over the vertex's cell.
    mean = 0.5 * np.einsum("ij,ij->i", mesh.laplacian @ vertices, normals) / np.sqrt(mesh.areas.sum())
    return np.stack([_angle_deficits(mesh), np.where(_on_boundary(mesh), 0.0, mean)], axis=1)


class Curvatures:
    """Gauss and mean curvature of a mesh, (n, 3) and (m, 3), that is to be compared with others at several sizes.

    All but the smoothing is done once.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self._mesh = intrinsic_mesh(vertices, faces)
        self._integrated = integrated_curvatures(self._mesh, vertices, faces)
        self._size = np.sqrt(self._mesh.areas.sum())

    def smoothed(self, radii: tuple[float, ...], size: float = 1.0, *, steps: int = 5) -> np.ndarray:
        """Gauss and mean curvature smoothed to each radius, (n, 2 * radii), of the mesh made so many times larger.

        Both are in the units of the vertices.
        """
        columns = []
        for radius in radii:
            density = smoothed_density(self._mesh, self._integrated, radius / (size * self._size), steps=steps)
            columns += [density[:, 0] / (size * self._size) ** 2, density[:, 1] / (size * self._size)]
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
    """Quantities given as integrals over the vertices' cells, as densities on the surface scaled to area 1.

    The density is smoothed by implicit Euler steps of the heat equation, which keep its integral.

    Parameters
    ----------
    mesh
        Any triangulation of the surface.
    integrated
        (n,) integrals over the vertices' cells, or (n, c) for several quantities; the densities have the same shape.
    radius
        Width r of the smoothing per sqrt(area): heat flows for the time r^2.
    steps
        Number of equal steps that this time is divided into. More steps come closer to a Gaussian.
    """
    # The Laplacian has no units in two dimensions; masses of a unit surface make the step free of scale.
    heat = mesh.pattern.factors(radius**2 / steps * mesh.laplacian.data, mesh.masses)
    density, masses = heat.solve(integrated), mesh.masses.reshape(-1, *[1] * (integrated.ndim - 1))
    for _ in range(steps - 1):
        density = heat.solve(masses * density)
    return density


def _on_boundary(mesh: IntrinsicMesh) -> np.ndarray:
    one_face = np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges)[mesh.face_edges] == 1
    boundary = np.zeros(mesh.n_vertices, bool)
    boundary[mesh.faces[:, [1, 2, 0]][one_face]] = True
    boundary[mesh.faces[:, [2, 0, 1]][one_face]] = True
    return boundary
