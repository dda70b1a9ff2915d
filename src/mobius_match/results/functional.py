"""Functional maps (Ovsjanikov et al. 2012) of a dense map, for programs that go on from them, such as pyFM and geomfum.

The Laplacian is the cotangent Laplacian of each mesh's own triangles, with lumped areas: a third of the area of the
triangles around each vertex. These are the usual choices, so that eigenvalues and eigenfunctions are those that the
other programs compute, up to the signs of functions and to rotations within repeated eigenvalues.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from .._core.display import one_line
from ..errors import SettingsError
from ..geometry.laplacian import intrinsic_mesh
from ..geometry.points import SurfacePoints
from ..geometry.spectral import eigenbasis, functional_map
from ..mesh import Mesh
from ..mesh.measure import box_scale


@dataclass(frozen=True, eq=False)
class Eigenbasis:
    """The first eigenfunctions of the Laplacian of one mesh.

    Rows count as the vertices of the user's file. Vertices that repair has left out have area 0 and functions NaN.

    Parameters
    ----------
    eigenvalues
        (k,) float64, ascending, the first of them 0; in 1 / area, in the units of the mesh.
    eigenfunctions
        (n, k) float64, with ``eigenfunctions.T @ (areas[:, None] * eigenfunctions)`` the identity; in 1 / sqrt(area).
    areas
        (n,) float64: lumped areas of the vertices, in squared units of the mesh.
    """

    eigenvalues: np.ndarray
    eigenfunctions: np.ndarray
    areas: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)


def repaired_eigenbasis(mesh: Mesh, count: int) -> Eigenbasis:
    """The basis of a repaired mesh, with rows that count as its own vertices."""
    # A box of size 1 keeps squares and areas far from overflow, whatever the units of the file.
    scale = box_scale(mesh.vertices)
    intrinsic = intrinsic_mesh(mesh.vertices / scale, mesh.faces, delaunay=False)
    area = float(intrinsic.areas.sum()) * scale**2
    # One BLAS thread: sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        eigenvalues, functions = eigenbasis(intrinsic, count)
    return Eigenbasis(eigenvalues / area, functions / np.sqrt(area), intrinsic.masses * area)


def in_file_order(basis: Eigenbasis, mesh: Mesh) -> Eigenbasis:
    """The basis with rows that count as the vertices of the user's file."""
    functions = np.full((mesh.n_file_vertices, len(basis.eigenvalues)), np.nan)
    functions[mesh.vertex_ids] = basis.eigenfunctions
    return Eigenbasis(basis.eigenvalues, functions, np.bincount(mesh.vertex_ids, basis.areas, mesh.n_file_vertices))


def check_count(count: int, *meshes: Mesh) -> None:
    """Refuse a number of eigenfunctions that the meshes do not have.

    Raises
    ------
    SettingsError
        If it is no whole number from 1 to the least number of vertices less 2.
    """
    most = min(len(mesh.vertices) for mesh in meshes) - 2
    if not isinstance(count, int | np.integer) or isinstance(count, bool) or not 1 <= count <= most:
        raise SettingsError(f"`k` is {count!r}; give a whole number from 1 to {most}, two less than the vertices")


def map_of_functions(
    source: Eigenbasis, target: Eigenbasis, source_points: SurfacePoints, mapped: np.ndarray
) -> np.ndarray:
    """The matrix (k, k) that takes coefficients of functions on the source to those on the target.

    Parameters
    ----------
    source, target
        Bases with rows that count as the repaired meshes' vertices.
    source_points, mapped
        (n2,) points of the source for the target's vertices, and which of them have one.

    Raises
    ------
    SettingsError
        If fewer vertices of the target have a counterpart than the bases have functions.
    """
    found, count = int(mapped.sum()), len(target.eigenvalues)
    if found < count:
        raise SettingsError(f"`k` is {count}, and only {found} vertices of the target have a counterpart; give less")
    weights = np.sqrt(target.areas[mapped])[:, None]
    pulled = source_points.values(source.eigenfunctions)[mapped]
    with threadpool_limits(limits=1, user_api="blas"):
        # Least squares, weighted by area. Where all are mapped it is the projection onto the target's basis.
        return functional_map(weights * target.eigenfunctions[mapped], weights * pulled)
