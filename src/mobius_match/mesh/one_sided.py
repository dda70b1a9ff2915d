"""One-sided surfaces cut open so that they can be oriented."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from .measure import areas, unit_box
from .mesh import Floats, Ints
from .topology import Bools, EdgeTable

STARTS = 4
"""Faces that orientation is propagated from; the shortest cut is taken."""


def shortest_cut(vertices: Floats, faces: Ints, table: EdgeTable, piece: Bools) -> tuple[Ints, float, float]:
    """Edges along which a one-sided piece of surface has to be cut so that it has two sides.

    Orientation is propagated from one face to the nearest side of each other face. Where two neighbours disagree, the
    surface is cut. The next start is the face farthest from that cut.

    Parameters
    ----------
    vertices, faces, table
        A surface whose edges have at most two faces.
    piece
        (m,) bool: the faces of one one-sided piece.

    Returns
    -------
    edges : (c,) int64
        Numbers of the edges of the shortest cut found.
    length, boundary : float
        Length of the cut, and of the boundary that the piece had before, in units of the square root of its area.
    """
    unit = unit_box(vertices)
    length = np.linalg.norm(unit[table.edges[:, 0]] - unit[table.edges[:, 1]], axis=1)
    one, two = table.pairs
    inside = piece[one // 3]
    one, two = one[inside], two[inside]
    corners = faces.ravel()
    clash = corners[one // 3 * 3 + (one + 1) % 3] == corners[two // 3 * 3 + (two + 1) % 3]
    edge = table.face_edges.ravel()[one]
    rank = np.cumsum(piece) - 1
    f, g, m = rank[one // 3], rank[two // 3], int(piece.sum())
    centre, middle = unit[faces].mean(axis=1), unit[table.edges[edge]].mean(axis=1)
    step = sum(np.linalg.norm(centre[side // 3] - middle, axis=1) for side in (one, two))
    step = np.maximum(step, np.finfo(float).tiny)
    start = np.concatenate([f, f + m]), np.concatenate([g + m * clash, g + m * ~clash])
    graph = coo_array((np.tile(step, 2), start), shape=(2 * m, 2 * m)).tocsr()
    root, best, shortest = 0, np.zeros(0, dtype=bool), np.inf
    for _ in range(STARTS):
        upper, lower = dijkstra(graph, directed=False, indices=root).reshape(2, m)
        cut = _tightened(clash ^ (lower < upper)[f] ^ (lower < upper)[g], length[edge], f, g, m)
        total = float(length[edge[cut]].sum())
        if total < shortest:
            best, shortest = cut, total
        away = dijkstra(graph, directed=False, indices=np.unique(f[cut]), min_only=True).reshape(2, m).min(axis=0)
        root = int(away.argmax())
    own = table.face_edges[piece]
    boundary = float(length[own[table.counts[own] == 1]].sum())
    scale = float(np.sqrt(areas(vertices, faces)[piece].sum())) or 1.0
    return edge[best], shortest / scale, boundary / scale


def _tightened(cut: Bools, length: Floats, f: Ints, g: Ints, m: int) -> Bools:
    """A cut (P,) between the faces f and g, shortened as long as the other side of some single face is shorter."""
    beside = np.stack([f, g], axis=1).ravel()
    order = np.argsort(beside, kind="stable")
    start = np.searchsorted(beside[order], np.arange(m + 1))
    edges = order // 2
    weight = np.where(cut, length, -length)
    gain = np.bincount(f, weight, m) + np.bincount(g, weight, m)
    least = 1e-9 * length.max(initial=0.0)
    while True:
        face = int(gain.argmax())
        if not gain[face] > least:
            return weight > 0
        own = edges[start[face] : start[face + 1]]
        weight[own] *= -1
        gain[face] *= -1
        np.add.at(gain, f[own] + g[own] - face, 2 * weight[own])
