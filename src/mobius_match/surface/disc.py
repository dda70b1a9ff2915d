"""The paper's footnote: a surface of disc topology onto the unit disc, in closed form from its flattening.

Theorem 5.1 puts the boundary of the mid-edge flattening on a horizontal segment, and infinity lies in the cut face. So
the surface goes to the plane outside of a slit, and the inverse of Joukowski's map takes the outside of a slit to the
unit disc: the cut face to the centre, the boundary to the circle. The longest of several boundary loops is the rim that
goes to the circle. The others are holes, which are closed by cones first, because the shape of a slit is not that of
the hole.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.laplacian import IntrinsicMesh
from ..mesh.topology import labels_of
from .flattening import Flattening, flatten, vertex_positions


def disc_positions(flattening: Flattening, mesh: IntrinsicMesh, wanted: np.ndarray) -> np.ndarray:
    """Where vertices lie in the unit disc, (p,) complex128; empty where the surface is closed.

    Parameters
    ----------
    flattening, mesh
        A flattening and the triangulation it was made from.
    wanted
        Vertex numbers (p,).
    """
    corners, loops = boundary_corners(mesh)
    if not len(corners):
        return np.empty(0, np.complex128)
    if loops.any():
        mesh = with_cones(mesh, corners[loops > 0], loops[loops > 0])
        flattening = flatten(mesh, flattening.cut_face)
    rim = corners[loops == 0]
    return vertex_positions(replace(flattening, positions=mid_edges_in_disc(flattening, mesh, rim)), mesh, wanted)


def boundary_corners(mesh: IntrinsicMesh) -> tuple[np.ndarray, np.ndarray]:
    """The corners (b,), as 3 * face + corner, opposite to the boundary's edges, and the loop of each, 0 the longest."""
    edges = mesh.face_edges.ravel()
    corners = np.flatnonzero(np.bincount(edges, minlength=mesh.n_edges)[edges] == 1)
    face, corner = corners // 3, corners % 3
    labels = labels_of(mesh.n_vertices, mesh.faces[face, corner - 2], mesh.faces[face, corner - 1])[1]
    names, loops = np.unique(labels[mesh.faces[face, corner - 2]], return_inverse=True)
    order = np.argsort(-np.bincount(loops, mesh.lengths[face, corner], len(names)), kind="stable")
    return corners, np.argsort(order)[loops]


def with_cones(mesh: IntrinsicMesh, corners: np.ndarray, loops: np.ndarray) -> IntrinsicMesh:
    """A triangulation with loops of its boundary closed by cones, which are flat for a round hole in a plane.

    Parameters
    ----------
    mesh
        The triangulation.
    corners, loops
        As :func:`boundary_corners` gives them, of the loops that are to be closed.
    """
    face, corner = corners // 3, corners % 3
    tail, head = mesh.faces[face, corner - 2], mesh.faces[face, corner - 1]
    lengths, (vertices, places) = mesh.lengths[face, corner], np.unique(tail, return_inverse=True)
    # Few long edges need longer spokes: an equilateral triangle has its circumradius.
    longest = np.zeros(loops.max() + 1)
    np.maximum.at(longest, loops, lengths)
    spoke = np.maximum(np.bincount(loops, lengths) / (2 * np.pi), longest / np.sqrt(3))[loops]
    of_tail, of_head = mesh.n_edges + places, mesh.n_edges + np.searchsorted(vertices, head)
    return IntrinsicMesh(
        np.concatenate([mesh.faces, np.stack([head, tail, mesh.n_vertices + loops - 1], axis=1)]),
        np.concatenate([mesh.lengths, np.stack([spoke, spoke, lengths], axis=1)]),
        np.concatenate([mesh.face_edges, np.stack([of_tail, of_head, mesh.face_edges[face, corner]], axis=1)]),
        mesh.n_vertices + int(loops.max()),
        mesh.n_edges + len(vertices),
    )


def mid_edges_in_disc(flattening: Flattening, mesh: IntrinsicMesh, corners: np.ndarray) -> np.ndarray:
    """Where the mid-edges lie in the unit disc, (n_edges,) complex128, those of one loop on the circle.

    Parameters
    ----------
    flattening, mesh
        A flattening and its triangulation.
    corners
        Those opposite to the edges of the loop (r,).
    """
    rim, others = mesh.face_edges.ravel()[corners], mesh.face_edges[corners // 3]
    slit = flattening.positions[rim]
    low, high = np.nanmin(slit.real), np.nanmax(slit.real)
    z = (flattening.positions - (low + high) / 2 - 1j * np.nanmean(slit.imag)) * (2 / (high - low))
    # A mid-edge of the rim lies on that side of the slit on which the rest of its face does.
    upper = np.where(np.isin(others, rim), 0.0, z.imag[others]).sum(axis=1) >= 0
    disc = z - np.sqrt(z - 1) * np.sqrt(z + 1)
    along = np.clip(z[rim].real, -1.0, 1.0)
    disc[rim] = along - np.where(upper, 1j, -1j) * np.sqrt(1 - along**2)
    return disc
