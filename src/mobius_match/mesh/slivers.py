"""Removal of triangles without area, which keeps the surface closed.

Deleting such a triangle would leave a slit. A needle (one edge of almost no length) is removed by collapsing that edge;
a cap (a corner on the opposite edge) by flipping its longest edge, which keeps every vertex and the shape. Lengths and
angles are then accurate enough for intrinsic computations.
"""

from __future__ import annotations

import numpy as np

from .measure import unit_box
from .mesh import Floats, Ints
from .topology import EdgeTable, edge_table

FLAT = 1e-7  # height, or shortest edge, over longest edge: the resolution of float32 files
ROUNDS = 10
BLOCK = 50_000  # faces that are processed at a time, few enough for the processor's caches
MANY = 0.1  # a mesh with a larger share of faces without area is not repaired


def collapse_needles(vertices: Floats, faces: Ints) -> tuple[Ints, Ints, int, EdgeTable]:
    """Collapse edges far shorter than the other edges of their faces, where that keeps the topology.

    Returns
    -------
    faces : (m', 3) int64
        The remaining faces; of a collapsed edge the end of the lower number remains.
    rows : (m',) int64
        The given face that each one was.
    number : int
        Number of collapsed edges.
    table : EdgeTable
        The edges of the remaining faces.
    """
    unit, rows, number, table = unit_box(vertices), np.arange(len(faces)), 0, edge_table(faces)
    for _ in range(ROUNDS):
        length = np.linalg.norm(unit[table.edges[:, 0]] - unit[table.edges[:, 1]], axis=1)
        longest = length[table.face_edges].max(axis=1, initial=0)
        short = (length[table.face_edges] <= FLAT * longest[:, None]) & (longest[:, None] > 0)
        if np.count_nonzero(short) > MANY * len(faces):
            break
        candidates = np.unique(table.face_edges[short])
        if not len(candidates):
            break
        target = _collapses(table, candidates[np.argsort(length[candidates], kind="stable")], len(vertices))
        if not len(target):
            break
        number += len(target)
        moved = np.arange(len(vertices))
        moved[target[:, 1]] = target[:, 0]
        faces = moved[faces]
        whole = (faces != faces[:, [1, 2, 0]]).all(axis=1)
        faces, rows = faces[whole], rows[whole]
        table = edge_table(faces)
    return faces, rows, number, table


def _collapses(table: EdgeTable, candidates: Ints, n: int) -> Ints:
    """Edges (kept end, dropped end) that can be collapsed at once without changing the topology."""
    both = np.concatenate([table.edges, table.edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    start = np.searchsorted(both[:, 0], np.arange(n + 1))
    boundary = np.zeros(n, dtype=bool)
    boundary[table.edges[table.counts != 2]] = True
    touched: set[int] = set()
    chosen = []
    for edge in candidates.tolist():
        u, v = table.edges[edge].tolist()
        if u in touched or v in touched or table.counts[edge] > 2:
            continue
        around = [set(both[start[w] : start[w + 1], 1].tolist()) for w in (u, v)]
        # The link condition: common neighbours only across the edge itself, and no bridge between two boundaries.
        bridge = boundary[u] and boundary[v] and table.counts[edge] == 2
        everyone = around[0] | around[1]
        if bridge or len(around[0] & around[1]) != table.counts[edge] or len(everyone) <= 4:
            continue
        if everyone & touched:
            continue
        touched |= everyone
        chosen.append((u, v))
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def is_flat(unit: Floats, faces: Ints) -> np.ndarray:
    """Which faces (m,) have almost no height over their longest edge."""
    flat = np.empty(len(faces), dtype=bool)
    for start in range(0, len(faces), BLOCK):
        part = slice(start, start + BLOCK)
        a, b, c = (unit[faces[part, k]] for k in range(3))
        longest = np.max([(side**2).sum(axis=1) for side in (b - a, c - b, a - c)], axis=0)
        flat[part] = np.linalg.norm(np.cross(b - a, c - a), axis=1) <= FLAT * longest
    return flat


def flip_caps(vertices: Floats, faces: Ints) -> tuple[Ints, Ints, int, int]:
    """Flip the longest edge of flat faces; if it is on the boundary, drop the face, which has no area.

    The faces must be consistently oriented; a surface with non-manifold edges is not changed.

    Returns
    -------
    faces : (m', 3) int64
    rows : (m',) int64
        The given face that each one lies in.
    number : int
        Number of removed flat faces.
    left : int
        Number of remaining flat faces, whose removal would change the topology.
    """
    unit, rows = unit_box(vertices), np.arange(len(faces))
    flat = is_flat(unit, faces)
    before = int(flat.sum())
    for _ in range(ROUNDS):
        if not 0 < np.count_nonzero(flat) <= MANY * len(faces):
            break
        faces, rows, changed = _flip_once(unit, faces, rows, np.flatnonzero(flat))
        if not changed:
            break
        flat = is_flat(unit, faces)
    return faces, rows, before - int(flat.sum()), int(flat.sum())


def _flip_once(unit: Floats, faces: Ints, rows: Ints, flat: Ints) -> tuple[Ints, Ints, bool]:
    table = edge_table(faces)
    if (table.counts > 2).any():  # removing a face from such an edge would need a new orientation
        return faces, rows, False
    known = table.edges[:, 0] * len(unit) + table.edges[:, 1]
    boundary = np.zeros(len(unit), dtype=bool)
    boundary[table.edges[table.counts == 1]] = True
    sides = unit[faces[flat][:, [2, 0, 1]]] - unit[faces[flat][:, [1, 2, 0]]]
    tops = (sides**2).sum(axis=2).argmax(axis=1)
    faces, rows = faces.copy(), rows.copy()
    touched: set[int] = set()
    gone = np.zeros(len(faces), dtype=bool)
    changed = False
    for f, k in zip(flat.tolist(), tops.tolist(), strict=True):
        p, a, b = faces[f, [k, (k + 1) % 3, (k + 2) % 3]].tolist()
        edge = table.face_edges[f, k]
        if touched & {p, a, b}:
            continue
        if table.counts[edge] == 1:
            ear = (table.counts[table.face_edges[f]] == 1).sum() > 1
            if ear or not boundary[p]:
                gone[f] = changed = True
                touched |= {p, a, b}
        elif table.counts[edge] == 2:
            g = int(table.edge_faces[edge].sum()) - f
            j = int(np.flatnonzero(table.face_edges[g] == edge)[0])
            q = int(faces[g, j])
            key = min(p, q) * len(unit) + max(p, q)
            place = np.searchsorted(known, key)
            exists = place < len(known) and known[place] == key
            agree = faces[g, (j + 1) % 3] == b
            new = np.array([[p, a, q], [p, q, b]])
            if q in touched or p == q or exists or not agree or is_flat(unit, new).any():
                continue
            faces[[f, g]] = new
            rows[f] = rows[g]
            touched |= {p, a, b, q}
            changed = True
    return faces[~gone], rows[~gone], changed
