"""Repair of a mesh: a compact, consistently oriented manifold, with a note for each change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .measure import cross_products, unit_box
from .mesh import Floats, Ints, Mesh, count
from .one_sided import shortest_cut
from .parameters import RepairParameters
from .seams import join_and_cut, seam_twins
from .sheets import cut_edges, duplicate_faces, sheets
from .slivers import collapse_needles, flip_caps
from .topology import Bools, EdgeTable, components, edge_table, sides, used_vertices

Sides = tuple[Ints, Bools, Bools]  # of `topology.sides`


def repair(mesh: Mesh, parameters: RepairParameters = RepairParameters()) -> Mesh:
    """Repair the defects that can be repaired without changing the shape.

    Faces that name a vertex twice and duplicate faces are dropped; near-zero-length edges are collapsed; edges with
    more than two faces are separated into sheets; vertices with equal coordinates are merged along seams; vertices
    where the surface only touches itself are split; unused vertices are dropped; one-sided surfaces are cut open where
    a short cut is enough; faces are oriented consistently, closed surfaces outwards and cavities inwards; faces without
    area are removed by edge flips. All pieces stay; :func:`.main_piece` chooses the one that is matched.

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
        again, folded = duplicate_faces(faces, again)
        if again.any():
            notes.append(f"{count(again.sum(), 'duplicate face', 'duplicate faces')} dropped.")
        if folded.any():
            notes.append(f"{_faces(folded.sum())} dropped that lie on each other, attached to a surface without them.")
        faces, kept = faces[~(again | folded)], kept[~(again | folded)]

    faces, rows, number, table = collapse_needles(mesh.vertices, faces)
    if number:
        edges = count(number, "near-zero-length edge", "near-zero-length edges")
        notes.append(f"{edges} collapsed ({_faces(len(kept) - len(rows))} removed).")
        kept = kept[rows]

    twin = seam_twins(mesh)
    again = _repeated_pieces(faces, twin)
    if again.any():
        notes.append(f"{_faces(again.sum())} dropped: their piece coincides with another piece of the surface.")
        faces, kept = faces[~again], kept[~again]
        table = edge_table(faces)

    rows, table, more = _separate(mesh, faces, kept, table)
    faces, kept, notes = faces[rows], kept[rows], [*notes, *more]

    faces, origin, more, table = join_and_cut(mesh.vertices, faces, twin, table)
    vertices = mesh.vertices[origin]
    notes += more

    known = sides(faces, table)
    if known[2].any():
        faces, origin, more, table = _cut_one_sided(mesh, faces, origin, table, known, parameters)
        vertices, known = mesh.vertices[origin], sides(faces, table)
        notes += more

    faces, more = _orient(vertices, faces, table, known)
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


def _cut_one_sided(
    mesh: Mesh, faces: Ints, origin: Ints, table: EdgeTable, known: Sides, parameters: RepairParameters
) -> tuple[Ints, Ints, list[str], EdgeTable]:
    """Cut one-sided pieces open, where the cut is no longer than their boundary or within one sample's cell.

    Returns faces in new numbers, the number in `mesh` of each new vertex, notes, and the edge table of the new faces.
    """
    piece, _, twisted = known
    cuts, notes = [], []
    for label in np.unique(piece[twisted]).tolist():
        edges, length, boundary = shortest_cut(mesh.vertices[origin], faces, table, piece == label)
        if length <= max(boundary, parameters.one_sided_cut):
            cuts.append(edges)
            first = origin[table.edges[edges[0], 0]]
            place = ", ".join(f"{x:.4g}" for x in mesh.vertices[first])
            notes.append(
                f"surface with one side only cut open along {count(len(edges), 'edge', 'edges')} "
                f"({length:.2g} sqrt(area) long, at vertex {mesh.vertex_ids[first]}, ({place})), so that it has two."
            )
    if not cuts:
        return faces, origin, notes, table
    cut = cut_edges(table, np.concatenate(cuts))
    faces, own, _, table = join_and_cut(mesh.vertices[origin], faces, np.arange(len(origin)), cut)
    return faces, origin[own], notes, table


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


def _separate(mesh: Mesh, faces: Ints, kept: Ints, table: EdgeTable) -> tuple[Ints, EdgeTable, list[str]]:
    """Separate edges with more than two faces into sheets: the remaining faces, the table of their edges, notes."""
    many = np.flatnonzero(table.counts > 2)
    if not len(many):
        return np.arange(len(faces)), table, []
    a, b = mesh.vertex_ids[table.edges[many[0]]]
    edges = count(len(many), "edge", "edges")
    notes = [f"{edges} with more than two faces separated into sheets (the first joins vertices {a} and {b})."]
    table, rows, flat = sheets(mesh.vertices, faces, table)
    if flat.any():
        notes.append(f"{count(flat.sum(), 'flap', 'flaps')} without area dropped there.")
    rest = ~flat
    rest[rows] = False
    if rest.any():
        first = mesh.face_ids[kept[rest]][0]
        notes.append(f"{_faces(rest.sum())} dropped that could not be separated (the first is face {first}).")
    return rows, table, notes


def _orient(vertices: Floats, faces: Ints, table: EdgeTable, known: Sides) -> tuple[Ints, list[str]]:
    """Orient faces consistently: closed pieces outwards, open ones as the majority of their faces."""
    piece, turned, twisted = known
    turned = turned & ~twisted
    number = 2 * len(faces)  # labels are below this; most of them are not in use
    size = np.bincount(piece, minlength=number)
    open_ = np.bincount(piece, weights=(table.counts[table.face_edges] != 2).any(axis=1), minlength=number) > 0
    unit = unit_box(vertices)
    sign = np.where(turned, -1.0, 1.0)
    volumes = sign * np.einsum("ij,ij->i", unit[faces[:, 0]], cross_products(unit, faces))
    volume = np.bincount(piece, weights=volumes, minlength=number)
    against = np.bincount(piece, weights=turned, minlength=number)
    inwards = volume < 0
    if (size > 0).sum() > 1:
        from .cavities import cavities_among

        used, label = np.unique(piece, return_inverse=True)
        oriented = np.where(turned[:, None], faces[:, [0, 2, 1]], faces)
        inwards[used] ^= cavities_among(vertices, oriented, label, ~open_[used])
    reverse = np.where(open_ | (volume == 0), 2 * against > size, inwards)
    turned ^= reverse[piece] & ~twisted
    whole = (np.bincount(piece, weights=turned, minlength=number) == size) & (size > 0)
    notes = []
    single = int((turned & ~whole[piece]).sum())
    if single:
        notes.append(f"{_faces(single)} reversed to agree with their neighbours.")
    if whole.any():
        notes.append(f"closed surface turned outwards ({_faces(size[whole].sum())} reversed).")
    return np.where(turned[:, None], faces[:, [0, 2, 1]], faces), notes
