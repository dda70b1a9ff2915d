"""Section 5, mid-edge uniformization: a mesh of sphere topology, holes allowed, onto the extended complex plane.

Each face of the mid-edge mesh, whose vertices are the middles of the mesh's edges, goes to the plane by an exact
similarity: the real part is a discrete harmonic function, the imaginary part its conjugate (Pinkall and Polthier
1993). Beyond the paper: the triangulation may be the intrinsic Delaunay one, and the closure of the conjugate is
measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from .._core.compiling import jit
from .._core.display import one_line
from ..geometry.laplacian import IntrinsicMesh, corner_cotangents

TRIED = 100
"""Faces that are tried for the cut, at most."""


@dataclass(frozen=True, eq=False)
class Flattening:
    """A mid-edge mesh in the plane.

    Parameters
    ----------
    positions
        Complex position of each mid-edge, (n_edges,) complex128, no units.
    harmonic
        The harmonic function u at the vertices, (n_vertices,) float64.
    cut_face
        The face that was cut out; infinity lies inside it.
    closure
        Largest disagreement of the conjugate function between two paths to the same mid-edge, as a fraction of
        the flattening's extent: round-off where all is well.
    """

    positions: np.ndarray
    harmonic: np.ndarray
    cut_face: int
    closure: float

    def __repr__(self) -> str:
        return one_line(self)


def choose_cut_face(mesh: IntrinsicMesh, average_distance: np.ndarray) -> int:
    """A face at the vertex of least average geodesic distance, for infinity to lie in (section 5).

    Of the faces there the one whose other vertices are also most central is taken, the lowest number first.

    Parameters
    ----------
    mesh
        The triangulation to be flattened.
    average_distance
        Average geodesic distance of each vertex to the others, (n,) float64.
    """
    # A folded face (twice the same vertex) exists only in intrinsic triangulations, and has no two ends to fix.
    folded = (mesh.faces == np.roll(mesh.faces, 1, axis=1)).any(axis=1)
    # A vertex with one face alone would lose its place with that face.
    alone = np.bincount(mesh.faces.ravel(), minlength=mesh.n_vertices) == 1
    bad = folded | alone[mesh.faces].any(axis=1)
    corners = np.unique(mesh.faces[~bad if not bad.all() else ~folded])
    centre = corners[np.argmin(average_distance[corners])]
    elsewhere = ~(mesh.faces == centre).any(axis=1)
    order = np.lexsort((average_distance[mesh.faces].sum(axis=1), elsewhere, bad, folded))
    for face in order[:TRIED]:
        if not bad[face] and _in_one_piece(mesh, int(face)):
            return int(face)
    return int(order[0])


def _in_one_piece(mesh: IntrinsicMesh, face: int) -> bool:
    """Whether the other faces still hang together by their edges without a face."""
    others = np.delete(np.arange(len(mesh.faces)), face)
    sides = mesh.face_edges[others].ravel()
    incidence = sp.csr_matrix((np.ones(len(sides)), (np.repeat(np.arange(len(others)), 3), sides)))
    return bool(connected_components(incidence @ incidence.T, directed=False, return_labels=False) == 1)


def flatten(mesh: IntrinsicMesh, cut_face: int) -> Flattening:
    """Mid-edge flattening, Algorithm 1.

    Parameters
    ----------
    mesh
        A connected, consistently oriented triangulation of genus 0, with any number of boundary loops.
    cut_face
        Number of the face to cut out.
    """
    # The ends of the face's longest edge are fixed, so that the order of its vertices does not matter.
    apex = int(np.argmax(mesh.lengths[cut_face]))
    low, high = np.sort(np.delete(mesh.faces[cut_face], apex))
    cotangents = corner_cotangents(mesh.lengths)
    harmonic = _harmonic(mesh, cotangents[cut_face], cut_face, low, high)
    keep = np.arange(len(mesh.faces)) != cut_face
    open_edges = mesh.face_edges[keep]
    steps = _conjugate_steps(mesh.faces[keep], cotangents[keep], harmonic)
    conjugate = _integrate(open_edges, steps, mesh.n_edges)
    ends = np.empty((mesh.n_edges, 2), np.int64)
    ends[mesh.face_edges] = np.stack([mesh.faces[:, [1, 2, 0]], mesh.faces[:, [2, 0, 1]]], axis=-1)
    positions = harmonic[ends].mean(axis=1) + 1j * conjugate
    found = conjugate[open_edges] - conjugate[np.roll(open_edges, -1, axis=1)]
    with np.errstate(invalid="ignore"):
        extent = np.nanmax(np.abs(positions - np.nanmean(positions)))
        closure = np.nanmax(np.abs(found - steps)) / extent
    return Flattening(positions, harmonic, cut_face, float(closure))


def _harmonic(mesh: IntrinsicMesh, cotangents: np.ndarray, cut_face: int, low: int, high: int) -> np.ndarray:
    """Equation 1 without a face, with the value -1 at one of its vertices and 1 at another."""
    laplacian = mesh.laplacian.copy()
    for corner, cotangent in enumerate(cotangents):
        i, j = mesh.faces[cut_face, [corner - 2, corner - 1]]
        for row, column in ((i, i), (j, j), (i, j), (j, i)):
            laplacian[row, column] += (0.5 if row != column else -0.5) * cotangent
    fixed = np.zeros(mesh.n_vertices)
    fixed[[low, high]] = -1.0, 1.0
    right = np.where(fixed == 0, -(laplacian @ fixed), fixed)
    # Rows and columns of the fixed vertices become those of the identity.
    rows = np.repeat(np.arange(mesh.n_vertices), np.diff(laplacian.indptr))
    bound = (fixed[rows] != 0) | (fixed[laplacian.indices] != 0)
    entries = np.where(bound, 1.0 * (rows == laplacian.indices), laplacian.data)
    return mesh.pattern.factors(entries).solve(right)


def _conjugate_steps(faces: np.ndarray, cotangents: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Equation 2 in every face: u*_r - u*_s, (m, 3), where r and s are the mid-edges opposite corners c and c + 1.

    With the corner c called k, c + 1 called i and c + 2 called j, mid-edge r lies on edge (i, j) and s on (j, k).
    """
    u_k, u_i, u_j = (u[np.roll(faces, -shift, axis=1)] for shift in range(3))
    cot_k, cot_i = cotangents, np.roll(cotangents, -1, axis=1)
    return 0.5 * ((u_i - u_j) * cot_k + (u_k - u_j) * cot_i)


@jit
def _integrate(face_edges: np.ndarray, steps: np.ndarray, n_edges: int) -> np.ndarray:
    """Traverse the mid-edge mesh and sum the steps of equation 2; mid-edges out of reach are NaN."""
    m = len(face_edges)
    sides = np.full((n_edges, 2), -1)  # the corners (as 3 * face + corner) that an edge lies opposite of
    for face in range(m):
        for corner in range(3):
            edge = face_edges[face, corner]
            sides[edge, 0 if sides[edge, 0] < 0 else 1] = 3 * face + corner
    values = np.full(n_edges, np.nan)
    queue = np.empty(m, np.int64)
    visited = np.zeros(m, np.bool_)
    queue[0] = 0
    visited[0] = True
    values[face_edges[0, 0]] = 0.0
    first, last = 0, 1
    while first < last:
        face = queue[first]
        first += 1
        for turn in range(3):  # one of the three is known; twice around reaches the others
            here, there = face_edges[face, turn], face_edges[face, (turn + 1) % 3]
            if np.isnan(values[here]) and not np.isnan(values[there]):
                values[here] = values[there] + steps[face, turn]
        for turn in range(3):
            here, there = face_edges[face, turn], face_edges[face, (turn + 1) % 3]
            if np.isnan(values[there]) and not np.isnan(values[here]):
                values[there] = values[here] - steps[face, turn]
        for corner in range(3):
            for side in sides[face_edges[face, corner]]:
                if side >= 0 and not visited[side // 3]:
                    visited[side // 3] = True
                    queue[last] = side // 3
                    last += 1
    return values


def vertex_positions(
    flattening: Flattening, mesh: IntrinsicMesh, wanted: np.ndarray, placement: str = "mean"
) -> np.ndarray:
    """Where vertices lie in the plane, (p,) complex128.

    Parameters
    ----------
    flattening, mesh
        A flattening and the triangulation it was made from.
    wanted
        Vertex numbers (p,).
    placement
        ``"mean"`` of the mid-edges around the vertex, or the ``"closest"`` mid-edge on the surface (section 6).
    """
    corner, edge = mesh.faces[:, [1, 2, 0]].ravel(), mesh.face_edges.ravel()
    corner, edge = np.concatenate([corner, mesh.faces[:, [2, 0, 1]].ravel()]), np.tile(edge, 2)
    known = np.isfinite(flattening.positions[edge])
    corner, edge = corner[known], edge[known]
    if placement == "closest":
        length = np.empty(mesh.n_edges)
        length[mesh.face_edges] = mesh.lengths
        order = np.lexsort((edge, length[edge], corner))
        found, first = np.unique(corner[order], return_index=True)
        nearest = np.full(mesh.n_vertices, -1)
        nearest[found] = edge[order[first]]
        return flattening.positions[nearest[wanted]]
    count = np.bincount(corner, minlength=mesh.n_vertices)
    real = np.bincount(corner, flattening.positions.real[edge], mesh.n_vertices)
    imaginary = np.bincount(corner, flattening.positions.imag[edge], mesh.n_vertices)
    return ((real + 1j * imaginary) / count)[wanted]
