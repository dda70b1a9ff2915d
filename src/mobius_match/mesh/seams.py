"""Vertices merged along seams, and fans of faces given vertices of their own."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .measure import twins
from .mesh import Floats, Ints, Mesh, count
from .sheets import joined_faces
from .topology import EdgeTable, edge_table, fans, used_vertices


def seam_twins(mesh: Mesh) -> Ints:
    """For each vertex the lowest one with its coordinates; those that repair has separated before have none."""
    twin = twins(mesh.vertices)
    shared = np.bincount(mesh.vertex_ids)[mesh.vertex_ids] > 1
    return np.where(shared, np.arange(len(twin)), twin)


def join_and_cut(
    vertices: Floats, faces: Ints, twin: Ints, table: EdgeTable
) -> tuple[Ints, Ints, list[str], EdgeTable]:
    """Merge vertices along seams, then give every fan of faces a vertex of its own.

    A seam is a pair of boundary edges, and no other edge, with equal coordinates. Of more than two boundary edges with
    equal coordinates those are pairs whose faces are sheets, see :mod:`.sheets`. Surfaces that only touch at vertices
    are not merged.

    Returns faces in new numbers, the old number of each new vertex (the lowest of merged ones), notes, and the edge
    table of the new faces.
    """
    separate, label = fans(faces, table)
    number = separate
    if (twin[faces] != faces).any():
        for pairs in _seams(vertices, faces, twin, table):
            fewer, merged = fans(faces, table, _ends(faces, twin, *pairs))
            if _no_worse(merged, label):
                number, label = fewer, merged
                break
    old, new = faces.ravel(), label.ravel()
    origin = np.full(number, len(twin), dtype=np.int64)
    np.minimum.at(origin, new, old)
    # Fans are numbered by the vertex they come from, so that a mesh without defects keeps its order.
    order = np.argsort(origin, kind="stable")
    rank = np.empty(number, dtype=np.int64)
    rank[order] = np.arange(number)
    links = number if number == separate else len(np.unique(old * number + new))
    joined, cut = links - number, links - len(used_vertices(faces))
    notes = []
    if joined:
        notes.append(f"{count(joined, 'vertex', 'vertices')} merged with another of the same coordinates, along seams.")
    if cut:
        times = count(cut, "vertex", "vertices")
        notes.append(f"{times} added where parts of the surface only touch, to separate them.")
    renamed = rank[label]
    if not np.array_equal(renamed, faces):
        table = edge_table(renamed)
    return renamed, origin[order], notes, table


def _no_worse(merged: Ints, plain: Ints) -> bool:
    """Whether merging neither makes a face name a vertex twice nor brings a third face to an edge."""
    if (merged == merged[:, [1, 2, 0]]).any():
        return False
    return int((edge_table(merged).counts > 2).sum()) <= int((edge_table(plain).counts > 2).sum())


def _seams(vertices: Floats, faces: Ints, twin: Ints, table: EdgeTable) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of corners opposite to edges to be joined: first with those of sheets, if there are any, then without."""
    ends = np.sort(twin[table.edges], axis=1)
    group = np.unique(ends[:, 0] * (len(twin) + 1) + ends[:, 1], return_inverse=True)[1]
    load = np.bincount(group, weights=table.counts)
    single = (table.counts == 1) & (ends[:, 0] != ends[:, 1])
    edge = np.flatnonzero(single & (load[group] == 2))
    pairs = edge[np.argsort(group[edge], kind="stable")].reshape(-1, 2)
    start = np.cumsum(table.counts) - table.counts
    one, two = table.order[start[pairs[:, 0]]], table.order[start[pairs[:, 1]]]
    if (single & (load[group] > 2)).any():
        proper = np.flatnonzero((twin[faces] != twin[faces][:, [1, 2, 0]]).all(axis=1))
        welded = twin[faces[proper]]
        sheets = [pair for here in joined_faces(vertices, welded, edge_table(welded)).values() for pair in here]
        corners = np.array(sheets, dtype=np.int64).reshape(-1, 2)
        corners = proper[corners // 3] * 3 + corners % 3
        corners = corners[single[table.face_edges.ravel()[corners]].all(axis=1)]
        yield np.concatenate([one, corners[:, 0]]), np.concatenate([two, corners[:, 1]])
    yield one, two


def _ends(faces: Ints, twin: Ints, one: Ints, two: Ints) -> tuple[Ints, Ints]:
    """Pairs of corners at equal ends of the edges opposite to the corners `one` and `two`."""
    firsts, seconds = [], []
    for k in (1, 2):
        a = one // 3 * 3 + (one % 3 + k) % 3
        for j in (1, 2):
            b = two // 3 * 3 + (two % 3 + j) % 3
            same = twin[faces.ravel()[a]] == twin[faces.ravel()[b]]
            firsts.append(a[same])
            seconds.append(b[same])
    return np.concatenate(firsts), np.concatenate(seconds)
