"""Repair of a mesh: compact, without non-manifold vertices, consistently oriented, with a note for each change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .measure import areas, cross_products, twins, unit_box
from .mesh import Floats, Ints, Mesh, count
from .slivers import collapse_needles, flip_caps
from .topology import EdgeTable, components, edge_table, fans, sides, used_vertices

LOOSE_AREA = 0.01  # the smallest pieces are dropped as long as their total area stays below this fraction


def repair(mesh: Mesh) -> Mesh:
    """Repair the defects that can be repaired without changing the shape.

    Faces that name a vertex twice and duplicate faces are dropped; near-zero-length edges are collapsed; vertices with
    equal coordinates are merged along seams; vertices where the surface only touches itself are split; small loose
    pieces and unused vertices are dropped; faces are oriented consistently, closed surfaces outwards; faces without
    area are removed by edge flips. What cannot be repaired (edges with three faces, handles, several large pieces) is
    refused by `require_matchable`.

    Returns
    -------
    Mesh
        With the user's numbers in `vertex_ids` and `face_ids`, and a note for each kind of change.
    """
    notes: list[str] = []
    faces, kept = mesh.faces, np.arange(len(mesh.faces))

    a, b, c = faces.T
    double = (a == b) | (b == c) | (c == a)
    if double.any():
        notes.append(f"{count(double.sum(), 'face that names', 'faces that name')} a vertex twice dropped.")
        faces, kept = faces[~double], kept[~double]

    again = repeated(np.sort(faces, axis=1))
    if again.any():
        notes.append(f"{count(again.sum(), 'duplicate face', 'duplicate faces')} dropped.")
        faces, kept = faces[~again], kept[~again]

    faces, rows, number, table = collapse_needles(mesh.vertices, faces)
    if number:
        edges = count(number, "near-zero-length edge", "near-zero-length edges")
        notes.append(f"{edges} collapsed ({_faces(len(kept) - len(rows))} removed).")
        kept = kept[rows]

    twin = twins(mesh.vertices)
    again = _repeated_pieces(faces, twin)
    if again.any():
        notes.append(f"{_faces(again.sum())} dropped: their piece coincides with another piece of the surface.")
        faces, kept = faces[~again], kept[~again]
        table = edge_table(faces)

    faces, origin, more, table = _join_and_cut(faces, twin, table)
    vertices = mesh.vertices[origin]
    notes += more

    loose = _loose(vertices, faces, table)
    if loose.any():
        pieces, _ = components(faces[loose])
        size = areas(vertices, faces)
        percent = 100 * size[loose].sum() / size.sum()
        listed = f"{_faces(loose.sum())}, {percent:.2g} % of the area"
        notes.append(f"{count(pieces, 'small loose piece', 'small loose pieces')} dropped ({listed}).")
        faces, kept = faces[~loose], kept[~loose]
        table = edge_table(faces)

    faces, more = _orient(vertices, faces, table)
    notes += more

    faces, rows, number, left = flip_caps(vertices, faces)
    if number:
        notes.append(f"{_faces(number)} without area removed (by edge flips, or at the boundary).")
        kept = kept[rows]
    if left:
        notes.append(f"{_faces(left)} without area kept: removing them would change the topology.")

    used = used_vertices(faces)
    unused = len(mesh.vertices) - len(used_vertices(mesh.faces))
    if unused:
        notes.append(f"{count(unused, 'unused vertex', 'unused vertices')} dropped.")
    rank = np.zeros(len(vertices), dtype=np.int64)
    rank[used] = np.arange(len(used))
    return replace(
        mesh,
        vertices=vertices[used],
        faces=rank[faces],
        vertex_ids=mesh.vertex_ids[origin[used]],
        face_ids=mesh.face_ids[kept],
        notes=(*mesh.notes, *notes),
    )


def _faces(number: int) -> str:
    return count(number, "face", "faces")


def repeated(rows: Ints) -> np.ndarray:
    """Which rows equal an earlier one (m,)."""
    # Usually none does. Comparing one key per row shows that in a tenth of the time; different rows may share a key, so
    # equal keys prove nothing.
    base = np.uint64(rows.max(initial=0) + 1)
    a, b, c = rows.T.astype(np.uint64)
    key = np.sort((a * base + b) * base + c)
    if (key[1:] != key[:-1]).all():
        return np.zeros(len(rows), dtype=bool)
    again = np.ones(len(rows), dtype=bool)
    order = np.lexsort(rows.T[::-1])
    again[order[0]] = False
    again[order[1:]] = (rows[order[1:]] == rows[order[:-1]]).all(axis=1)
    return again


def _repeated_pieces(faces: Ints, twin: Ints) -> np.ndarray:
    """Faces of components that lie, face for face, exactly on earlier faces (double-sided models).

    Single faces that coincide are kept: there a surface touches itself, and dropping them would leave a hole.
    """
    rows = np.sort(twin[faces], axis=1)
    again = repeated(rows)
    if not again.any():
        return again
    number, label = components(faces)
    whole = np.bincount(label, weights=~again, minlength=number) == 0
    return again & whole[label]


def _join_and_cut(faces: Ints, twin: Ints, table: EdgeTable) -> tuple[Ints, Ints, list[str], EdgeTable]:
    """Merge vertices along seams, then give every fan of faces a vertex of its own.

    A seam is a pair of boundary edges, and no other edge, with equal coordinates. Surfaces that only touch at vertices
    are not merged.

    Returns faces in new numbers, the old number of each new vertex (the lowest of merged ones), notes, and the edge
    table of the new faces.
    """
    separate, label = fans(faces, table)
    number = separate
    if (twin[faces] != faces).any():
        fewer, merged = fans(faces, table, _seams(faces, twin, table))
        if _no_worse(merged, label):
            number, label = fewer, merged
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


def _seams(faces: Ints, twin: Ints, table: EdgeTable) -> tuple[Ints, Ints]:
    """Pairs of corners to link so that seams are closed."""
    ends = np.sort(twin[table.edges], axis=1)
    group = np.unique(ends[:, 0] * (len(twin) + 1) + ends[:, 1], return_inverse=True)[1]
    load = np.bincount(group, weights=table.counts)
    lone = (table.counts == 1) & (load[group] == 2) & (ends[:, 0] != ends[:, 1])
    edge = np.flatnonzero(lone)
    pairs = edge[np.argsort(group[edge], kind="stable")].reshape(-1, 2)
    start = np.cumsum(table.counts) - table.counts
    one, two = table.order[start[pairs[:, 0]]], table.order[start[pairs[:, 1]]]
    firsts, seconds = [], []
    for k in (1, 2):
        a = one // 3 * 3 + (one % 3 + k) % 3
        for j in (1, 2):
            b = two // 3 * 3 + (two % 3 + j) % 3
            same = twin[faces.ravel()[a]] == twin[faces.ravel()[b]]
            firsts.append(a[same])
            seconds.append(b[same])
    return np.concatenate(firsts), np.concatenate(seconds)


def _loose(vertices: Floats, faces: Ints, table: EdgeTable) -> np.ndarray:
    """Faces of the smallest components, whose total area stays below `LOOSE_AREA`; never the largest."""
    number, label = components(faces, table)
    if number < 2:
        return np.zeros(len(faces), dtype=bool)
    size = np.bincount(label, weights=areas(vertices, faces), minlength=number)
    order = np.argsort(size, kind="stable")
    small = np.cumsum(size[order]) < LOOSE_AREA * size.sum()
    small[-1] = False
    drop = np.zeros(number, dtype=bool)
    drop[order[small]] = True
    return drop[label]


def _orient(vertices: Floats, faces: Ints, table: EdgeTable) -> tuple[Ints, list[str]]:
    """Orient faces consistently: closed pieces outwards, open ones as the majority of their faces."""
    piece, turned, twisted = sides(faces, table)
    turned = turned & ~twisted
    number = 2 * len(faces)  # labels are below this; most of them are not in use
    size = np.bincount(piece, minlength=number)
    open_ = np.bincount(piece, weights=(table.counts[table.face_edges] != 2).any(axis=1), minlength=number) > 0
    unit = unit_box(vertices)
    sign = np.where(turned, -1.0, 1.0)
    volumes = sign * np.einsum("ij,ij->i", unit[faces[:, 0]], cross_products(unit, faces))
    volume = np.bincount(piece, weights=volumes, minlength=number)
    against = np.bincount(piece, weights=turned, minlength=number)
    reverse = np.where(open_ | (volume == 0), 2 * against > size, volume < 0)
    turned ^= reverse[piece] & ~twisted
    whole = (np.bincount(piece, weights=turned, minlength=number) == size) & (size > 0)
    notes = []
    single = int((turned & ~whole[piece]).sum())
    if single:
        notes.append(f"{_faces(single)} reversed to agree with their neighbours.")
    if whole.any():
        notes.append(f"closed surface turned outwards ({_faces(size[whole].sum())} reversed).")
    return np.where(turned[:, None], faces[:, [0, 2, 1]], faces), notes
