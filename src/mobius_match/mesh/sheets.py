"""Non-manifold edges taken apart into manifold sheets.

Around an edge with more than two faces the faces are joined in pairs; a face that is left over gets a boundary there.
Only joined faces then share vertices (:func:`.topology.fans`), so that each sheet has vertices of its own.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations

import numpy as np

from .measure import areas, unit_box
from .mesh import Floats, Ints
from .slivers import is_flat
from .topology import Bools, EdgeTable, components, edge_table, fans, grouped, sides

MOST_SHEETS = 16
"""Faces on one edge above which none of them are joined: all that meet there are flaps."""


def duplicate_faces(faces: Ints, again: Bools) -> tuple[Bools, Bools]:
    """Which faces to drop of those with the same three vertices.

    Parameters
    ----------
    faces
        (m, 3) int64, none of which names a vertex twice.
    again
        (m,) bool: the faces that repeat an earlier one; some do.

    Returns
    -------
    again : (m,) bool
        Repeated faces, all but the first of each group.
    folded : (m,) bool
        Groups of which none is kept. Two faces that lie on each other and are attached to a surface that is complete
        without them are a fold without volume: one of the two would remain as a flap.
    """
    group = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)[1].ravel()
    size = np.bincount(group)[group]
    several = size > 1
    table = edge_table(faces)
    # How many single faces there are on each edge: two beside a fold, one where the group belongs to the surface.
    single = np.bincount(table.face_edges[~several].ravel(), minlength=len(table.edges))
    _, label = components(faces[several])
    beside = single[table.face_edges[several]]
    odd = np.bincount(label, (beside % 2 | (size[several] % 2)[:, None]).sum(axis=1)) > 0
    attached = np.bincount(label, beside.sum(axis=1)) > 0
    folded = np.zeros(len(faces), dtype=bool)
    folded[several] = (attached & ~odd)[label]
    return again & ~folded, folded


def sheets(vertices: Floats, faces: Ints, table: EdgeTable) -> tuple[EdgeTable, Ints, Bools]:
    """Join the faces around non-manifold edges in pairs.

    Faces are joined that pass the edge in opposite directions: first those that are connected elsewhere, then those
    that continue each other most smoothly, in pairs that do not cross each other; of two equal pairs the one that
    encloses the smaller inside, which keeps solids that touch at an edge apart.

    Parameters
    ----------
    vertices, faces
        (n, 3) float64 and (m, 3) int64, none of which names a vertex twice.
    table
        The edges of the faces.

    Returns
    -------
    table : EdgeTable
        The edges of the remaining faces, in which no edge has more than two faces; several edges can have the same
        ends. Once :func:`.topology.fans` has given each fan a vertex of its own, their ends differ.
    rows : (m',) int64
        The remaining faces, numbers of the given ones.
    flat : (m,) bool
        Flaps of no area that were dropped. What is missing besides could not be separated.
    """
    flat = _flat_flaps(vertices, faces, table)
    rows = np.flatnonzero(~flat)
    if flat.any():
        table = edge_table(faces[rows])
    banned: set[tuple[int, int]] = set()
    while (table.counts > 2).any():
        split, pairs = _split(vertices, faces[rows], table, banned)
        shared = _shared(faces[rows], table, split)
        if not len(shared):
            return split, rows, flat
        # Two sheets still have both ends in common: they are one surface that meets itself there. Joining the faces
        # of the edge in another way cuts the surface along the two sheets' loop.
        used = {pair for edge in shared.tolist() for pair in pairs.get(edge, ())}
        if used:
            banned |= used
            continue
        size = areas(vertices, faces[rows])
        start = np.cumsum(table.counts) - table.counts
        corners = [table.order[start[edge] : start[edge] + table.counts[edge]] for edge in shared.tolist()]
        drop = {int(corner[np.argmin(size[corner // 3])]) // 3 for corner in corners}
        rows = np.delete(rows, sorted(drop))
        table, banned = edge_table(faces[rows]), set()
    return table, rows, flat


def cut_edges(table: EdgeTable, edges: Ints) -> EdgeTable:
    """The table with edges of two faces, by their numbers, cut open into two edges of one face."""
    fresh = np.zeros(len(table.order), dtype=bool)
    start = np.cumsum(table.counts) - table.counts
    fresh[start] = True
    fresh[start[edges] + 1] = True
    return _regrouped(table, table.order, fresh)


def _regrouped(table: EdgeTable, order: Ints, fresh: Bools) -> EdgeTable:
    return grouped(order, fresh, np.repeat(table.edges, table.counts, axis=0)[fresh])


def _flat_flaps(vertices: Floats, faces: Ints, table: EdgeTable) -> Bools:
    """Faces without area on a non-manifold edge that nothing else is attached to."""
    many = table.counts[table.face_edges] > 2
    flap = np.flatnonzero((many | (table.counts[table.face_edges] == 1)).all(axis=1) & many.any(axis=1))
    flat = np.zeros(len(faces), dtype=bool)
    flat[flap] = is_flat(unit_box(vertices), faces[flap])
    return flat


def _shared(faces: Ints, table: EdgeTable, split: EdgeTable) -> Ints:
    """Edges of which two sheets still have both ends in common."""
    _, label = fans(faces, split)
    many = np.flatnonzero(table.counts > 2)
    corner = table.order[np.isin(table.face_edges.ravel()[table.order], many)]
    face, k = corner // 3, corner % 3
    ends = np.sort(np.stack([label[face, (k + 1) % 3], label[face, (k + 2) % 3]], axis=1), axis=1)
    sheet = np.unique(split.face_edges.ravel()[corner], return_index=True)[1]
    _, first, number = np.unique(ends[sheet], axis=0, return_index=True, return_counts=True)
    return np.unique(table.face_edges.ravel()[corner[sheet[first[number > 1]]]])


def _split(
    vertices: Floats, faces: Ints, table: EdgeTable, banned: set[tuple[int, int]]
) -> tuple[EdgeTable, dict[int, list[tuple[int, int]]]]:
    """Each non-manifold edge as one edge for each pair of joined faces and for each single one; the pairs by edge.

    Pairs are of corners opposite to the edge; those in `banned` are not joined.
    """
    order, fresh = table.order.copy(), np.zeros(len(table.order), dtype=bool)
    start = np.cumsum(table.counts) - table.counts
    fresh[start] = True
    pairs = joined_faces(vertices, faces, table, banned)
    for edge in np.flatnonzero(table.counts > 2).tolist():
        place = slice(start[edge], start[edge] + table.counts[edge])
        joined = [corner for pair in pairs.get(edge, ()) for corner in pair]
        single = [corner for corner in order[place].tolist() if corner not in joined]
        order[place] = joined + single
        fresh[place] = [k % 2 == 0 for k in range(len(joined))] + [True] * len(single)
    return _regrouped(table, order, fresh), pairs


def joined_faces(
    vertices: Floats, faces: Ints, table: EdgeTable, banned: Collection[tuple[int, int]] = ()
) -> dict[int, list[tuple[int, int]]]:
    """The pairs of joined faces at each non-manifold edge, as corners opposite to it; best first over all edges.

    Pairs in `banned` are not joined.
    """
    patch, turned = _patches(faces, table)
    ahead, angle = _around(vertices, faces, table)
    ahead ^= turned.repeat(3)
    start = np.cumsum(table.counts) - table.counts
    pairs: list[tuple[int, int]] = []
    for edge in np.flatnonzero((table.counts > 2) & (table.counts <= MOST_SHEETS)).tolist():
        corners = table.order[start[edge] : start[edge] + table.counts[edge]]
        corners = corners[np.argsort(angle[corners], kind="stable")].tolist()
        for i, j in combinations(range(len(corners)), 2):
            # Of an even number of faces none is left over where an even number lies on either side of each pair.
            alike = patch[corners[i] // 3] == patch[corners[j] // 3]
            if (alike or len(corners) % 2 or (j - i) % 2) and (corners[i], corners[j]) not in banned:
                pairs.append((corners[i], corners[j]))
    if not pairs:
        return {}
    first, second = np.array(pairs).T
    # The angle of the wedge inside the surface, between the face that passes the edge forwards and the other.
    sign = np.where(ahead[first], 1, -1)
    wedge = (sign * (angle[first] - angle[second])) % (2 * np.pi)
    along = ahead[first] == ahead[second]
    alike = patch[first // 3] == patch[second // 3]
    rank = np.where(alike, 0, np.where(along, 2, 1))
    best = np.lexsort([wedge, np.round(np.abs(np.pi - wedge), 6), rank])
    # Patches that are joined already are one, with a direction each: joining them elsewhere must not make a surface
    # of one side.
    group, flip = list(range(int(patch.max()) + 1)), [False] * (int(patch.max()) + 1)
    members = [[p] for p in group]
    chosen: dict[int, list[tuple[int, int]]] = {}
    edges = table.face_edges.ravel()
    for k in best.tolist():
        pair, p, q = pairs[k], int(patch[first[k] // 3]), int(patch[second[k] // 3])
        here = chosen.setdefault(int(edges[pair[0]]), [])
        if any(set(pair) & set(other) for other in here):
            continue
        # Connected parts may cross each other: they are not one surface.
        if any(_cross(angle, pair, other) for other in here if not (p == q != patch[other[0] // 3])):
            continue
        opposed = bool(along[k]) == (flip[p] != flip[q])
        if group[p] != group[q]:
            keep, move = sorted((group[p], group[q]), key=lambda g: -len(members[g]))
            for patch_moved in members[move]:
                group[patch_moved] = keep
                flip[patch_moved] ^= not opposed
            members[keep] += members[move]
        elif not opposed:
            continue
        here.append(pair)
    return chosen


def _cross(angle: Floats, pair: tuple[int, int], other: tuple[int, int]) -> bool:
    """Whether two pairs at one edge cross each other."""
    low, high = sorted(angle[list(pair)])
    one, two = ((low < angle[corner] < high) for corner in other)
    return bool(one != two)


def _patches(faces: Ints, table: EdgeTable) -> tuple[Ints, Bools]:
    """Faces joined over edges of two faces: their patch, and whether they are turned against most of it."""
    piece, turned, twisted = sides(faces, table)
    turned &= ~twisted
    patch = np.unique(piece, return_inverse=True)[1].ravel()
    against = 2 * np.bincount(patch, turned) > np.bincount(patch)
    return patch, turned ^ against[patch]


def _around(vertices: Floats, faces: Ints, table: EdgeTable) -> tuple[Bools, Floats]:
    """Per corner (3 m,): whether its face passes the edge opposite to it from the lower to the higher vertex, and the
    angle of the corner around that edge. Filled in at non-manifold edges only."""
    unit, corners = unit_box(vertices), faces.ravel()
    ahead, angle = np.zeros(faces.size, dtype=bool), np.zeros(faces.size)
    edge = table.face_edges.ravel()
    chosen = np.flatnonzero(table.counts[edge] > 2)
    base, k = chosen // 3 * 3, chosen % 3
    tail, head = corners[base + (k + 1) % 3], corners[base + (k + 2) % 3]
    ahead[chosen] = tail < head
    low, high = unit[table.edges[edge[chosen]].T]
    axis = high - low
    reference = np.zeros_like(axis)
    reference[np.arange(len(axis)), np.abs(axis).argmin(axis=1)] = 1.0
    one = np.cross(axis, reference)
    two = np.cross(axis, one) / np.maximum(np.linalg.norm(axis, axis=1), np.finfo(float).tiny)[:, None]
    arm = unit[corners[chosen]] - low
    angle[chosen] = np.arctan2((arm * two).sum(axis=1), (arm * one).sum(axis=1))
    return ahead, angle
