"""Cotangent Laplacian of an intrinsic triangulation, one that is given by its edge lengths.

Section 5 uses only the edge lengths of a mesh, so it works on any triangulation of the same surface. The intrinsic
Delaunay triangulation (Fisher et al. 2007) has no negative cotangent weight, which removes the paper's first
limitation: artefacts where triangles are bad.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..mesh.topology import edge_table
from .cholesky import Pattern

MOLLIFICATION = 1e-6
"""Least slack of the triangle inequality in every face, as a fraction of the mean edge length."""


@dataclass(frozen=True, eq=False)
class IntrinsicMesh:
    """A triangulation given by edge lengths and by how its triangles are glued.

    Two different edges may join the same two vertices, so edges are identified by ``face_edges``.

    Parameters
    ----------
    faces
        Vertices of each triangle, (m, 3) int64, counter-clockwise.
    lengths
        Length of the edge opposite each corner, (m, 3) float64, in the units of the mesh.
    face_edges
        Number of the edge opposite each corner, (m, 3) int64.
    n_vertices, n_edges
        Number of vertices and of edges.
    """

    faces: np.ndarray
    lengths: np.ndarray
    face_edges: np.ndarray
    n_vertices: int
    n_edges: int

    def __repr__(self) -> str:
        return f"IntrinsicMesh({self.n_vertices} vertices, {len(self.faces)} faces, {self.n_edges} edges)"

    @cached_property
    def laplacian(self) -> sp.csr_matrix:
        """See :func:`cotangent_laplacian`."""
        return cotangent_laplacian(self)

    @cached_property
    def areas(self) -> np.ndarray:
        """See :func:`vertex_areas`."""
        return vertex_areas(self)

    @cached_property
    def masses(self) -> np.ndarray:
        """The vertices' areas (n,) as fractions of the surface's area, none of them zero."""
        return np.maximum(self.areas / self.areas.sum(), 1e-12 / len(self.areas))

    @cached_property
    def pattern(self) -> Pattern:
        """The pattern of the Laplacian, to factorise all matrices that share it."""
        return Pattern(self.laplacian, self.masses)


def intrinsic_mesh(vertices: np.ndarray, faces: np.ndarray, *, delaunay: bool = True) -> IntrinsicMesh:
    """The intrinsic Delaunay triangulation of a mesh, or the mesh's own triangles.

    Parameters
    ----------
    vertices, faces
        (n, 3) float and (m, 3) int arrays of an edge-manifold mesh, indices already checked.
    delaunay
        Flip edges until the triangulation is intrinsically Delaunay.
    """
    import igl

    faces = np.ascontiguousarray(faces, np.int64)
    lengths = mollified(igl.edge_lengths(np.ascontiguousarray(vertices, np.float64), faces))
    if not delaunay:
        table = edge_table(faces)
        return IntrinsicMesh(faces, lengths, table.face_edges, len(vertices), len(table.edges))
    # After flips two edges may join the same vertices: libigl numbers them by how the triangles are glued, which an
    # edge table, made from pairs of vertices, cannot.
    lengths, faces, _, unique, edge_map, _ = igl.intrinsic_delaunay_triangulation(lengths, faces)
    face_edges = np.ascontiguousarray(np.asarray(edge_map, np.int64).reshape(3, -1).T)
    return IntrinsicMesh(faces, lengths, face_edges, len(vertices), len(unique))


def mollified(lengths: np.ndarray) -> np.ndarray:
    """Lengths with the least constant added that makes every triangle strictly valid (Sharp and Crane 2020).

    Faces without area have infinite cotangents; the lengths of a mesh without such faces are returned unchanged.
    """
    slack = lengths.sum(axis=1) - 2 * lengths.max(axis=1)
    missing = MOLLIFICATION * lengths.mean() - slack.min()
    return lengths + missing if missing > 0 else lengths


def face_areas(lengths: np.ndarray) -> np.ndarray:
    """Areas (m,) of triangles from their edge lengths (m, 3), by Kahan's stable form of Heron's formula."""
    c, b, a = np.sort(lengths, axis=1).T
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return 0.25 * np.sqrt(np.maximum(product, 0.0))


def corner_cotangents(lengths: np.ndarray) -> np.ndarray:
    """Cotangent of the angle at each corner (m, 3), from the lengths of the opposite edges (m, 3)."""
    squared = lengths**2
    return (squared.sum(axis=1, keepdims=True) - 2 * squared) / (4 * face_areas(lengths)[:, None])


def corner_angles(lengths: np.ndarray) -> np.ndarray:
    """Angle at each corner (m, 3), radians, from the lengths of the opposite edges (m, 3)."""
    squared = lengths**2
    return np.arctan2(4 * face_areas(lengths)[:, None], squared.sum(axis=1, keepdims=True) - 2 * squared)


def cotangent_laplacian(mesh: IntrinsicMesh) -> sp.csr_matrix:
    """Positive semi-definite Laplacian (n, n) with weights (cot alpha + cot beta) / 2, equation 1."""
    weights = 0.5 * corner_cotangents(mesh.lengths).ravel()
    start, end = mesh.faces[:, [1, 2, 0]].ravel(), mesh.faces[:, [2, 0, 1]].ravel()
    rows, columns = np.concatenate([start, end, start, end]), np.concatenate([end, start, start, end])
    values = np.concatenate([-weights, -weights, weights, weights])
    return sp.csr_matrix((values, (rows, columns)), shape=(mesh.n_vertices, mesh.n_vertices))


def vertex_areas(mesh: IntrinsicMesh) -> np.ndarray:
    """A third of the area of the triangles around each vertex, (n,), in squared units of the mesh."""
    corner = np.repeat(face_areas(mesh.lengths) / 3, 3)
    return np.bincount(mesh.faces.ravel(), corner, mesh.n_vertices)
