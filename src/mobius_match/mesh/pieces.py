"""Pieces of a mesh: which one is matched, and the others, which are kept beside it.

A piece is what hangs together over edges. A cavity is a closed piece that lies inside another piece and faces inwards,
as the inner wall of a bone in a scan.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .._core.display import one_line
from ..errors import MeshError
from .measure import areas, box_scale
from .mesh import Floats, Ints, Mesh, count
from .topology import EdgeTable, components, edge_table

MIN_FACES, MIN_VERTICES = 20, 12
"""A piece with fewer is too coarse to be matched by itself."""


LISTED = 12
"""Names that a message lists at most."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pieces of a repaired mesh.

    Parameters
    ----------
    faces
        (m,) int64 piece of each face.
    vertices
        (n,) int64 piece of each vertex; -1 for one that no face uses.
    sizes
        (k, 2) int64 numbers of vertices and faces of each piece.
    areas
        (k,) float64 area of each piece, in the squared units of the mesh.
    closed, cavities
        (k,) bool: which pieces have no boundary, and which are cavities.
    """

    faces: Ints
    vertices: Ints
    sizes: Ints
    areas: Floats
    closed: np.ndarray
    cavities: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)

    def __len__(self) -> int:
        return len(self.areas)


def pieces_of(mesh: Mesh, table: EdgeTable | None = None) -> Pieces:
    """The pieces of a repaired mesh, in the order of their first faces."""
    table = table or edge_table(mesh.faces)
    number, label = components(mesh.faces, table)
    vertices = np.full(len(mesh.vertices), -1, np.int64)
    vertices[mesh.faces.ravel()] = np.repeat(label, 3)
    sizes = np.stack(
        [np.bincount(vertices[vertices >= 0], minlength=number), np.bincount(label, minlength=number)], axis=1
    )
    of_faces = areas(mesh.vertices, mesh.faces)
    with np.errstate(over="ignore"):
        scale = np.float64(box_scale(mesh.vertices))
        total = np.bincount(label, of_faces * scale * scale, number).astype(np.float64)
    closed = np.bincount(label, (table.counts[table.face_edges] == 1).any(axis=1), number) == 0
    cavities = np.zeros(number, bool)
    if number > 1:
        from .cavities import cavities_among

        cavities = cavities_among(mesh.vertices, mesh.faces, label, closed)
    return Pieces(label, vertices, sizes, total, closed, cavities)


def main_piece(mesh: Mesh, name: str | None = None) -> Mesh:
    """The piece of a repaired mesh that is matched, with the others beside it (:attr:`.Mesh.others`).

    It is the one of largest area that is no cavity and has enough faces to be matched. A mesh of one piece is returned
    as it is.

    Parameters
    ----------
    mesh
        The mesh.
    name
        If the file has names, the piece is one of those of this name, the largest.

    Raises
    ------
    MeshError
        If the file has names, and not this one.
    """
    table = edge_table(mesh.faces)
    if components(mesh.faces, table)[0] < 2:
        return mesh
    pieces = pieces_of(mesh, table)
    number = main_number(pieces, None if name is None else _named(mesh, pieces, name))
    main = piece_with_others(mesh, pieces, number)
    share, cavities = 100 * pieces.areas[number] / pieces.areas.sum(), int(pieces.cavities.sum())
    of_name = "the largest" if name is None else f"the largest named {name!r}"
    rest = count(len(mesh.vertices) - len(main.vertices), "vertex", "vertices")
    note = (
        f"{len(pieces)} pieces: {of_name} ({len(main.vertices)} vertices, {share:.2g} % of the area) is the main "
        f"one, with {count(len(pieces) - 1, 'other', 'others')} beside it ({rest}"
        + (f"; {count(cavities, 'cavity', 'cavities')} inside others" if cavities else "")
        + ")."
    )
    return replace(main, notes=(*main.notes, note))


def _named(mesh: Mesh, pieces: Pieces, name: str) -> np.ndarray:
    """Which pieces (k,) bool have the name."""
    names = dict(mesh.names)
    if name not in names:
        known = ", ".join(repr(one) for one in list(names)[:LISTED]) + (", ..." if len(names) > LISTED else "")
        raise MeshError(
            f"{mesh.name}: no group, object, material or node is named {name!r}; "
            + (f"there are {known}." if names else "the file has no names.")
        )
    return pieces_named(mesh, pieces, names[name])


def pieces_named(mesh: Mesh, pieces: Pieces, faces: Ints) -> np.ndarray:
    """Which pieces (k,) bool have more of some faces of the file than of others; else those that have any of them."""
    of_name = np.isin(mesh.face_ids, faces)
    number, rest = (np.bincount(pieces.faces, some, len(pieces)) for some in (of_name, ~of_name))
    return number > rest if (number > rest).any() else number > 0


def main_number(pieces: Pieces, among: np.ndarray | None = None) -> int:
    """The number of the piece that is matched, of all pieces or among those marked (k,)."""
    enough = (pieces.sizes >= (MIN_VERTICES, MIN_FACES)).all(axis=1) & ~pieces.cavities
    if among is not None:
        enough &= among
    choice = enough if enough.any() else np.ones(len(pieces), bool) if among is None else among
    return int(np.argmax(np.where(choice, pieces.areas, -1.0)))


def piece_with_others(mesh: Mesh, pieces: Pieces, number: int) -> Mesh:
    """One piece of a mesh, with all the others beside it."""
    main = part_of_mesh(mesh, pieces.vertices == number, pieces.faces == number)
    return replace(main, others=part_of_mesh(mesh, pieces.vertices != number, pieces.faces != number))


def part_of_mesh(mesh: Mesh, vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Some vertices and faces of a mesh, as marked (n,) and (m,) bool; the faces use these vertices only."""
    rank = np.cumsum(vertices) - 1
    return replace(
        mesh,
        vertices=mesh.vertices[vertices],
        faces=rank[mesh.faces[faces]],
        vertex_ids=mesh.vertex_ids[vertices],
        face_ids=mesh.face_ids[faces],
        others=None,
    )


def all_pieces(mesh: Mesh) -> Mesh:
    """A mesh together with the pieces beside it, in the order of the user's numbers; itself if there are none."""
    return mesh if mesh.others is None else joined(mesh)[0]


def joined(mesh: Mesh) -> tuple[Mesh, tuple[Ints, Ints], tuple[Ints, Ints]]:
    """The mesh of all pieces, and the vertices and faces in it of the mesh itself, and of the pieces beside it.

    It is the same whichever piece is the mesh itself.
    """
    parts = [mesh] if mesh.others is None else [mesh, mesh.others]
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertex_ids, face_ids = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("vertex_ids", "face_ids")
    )
    vertices, faces = np.argsort(vertex_ids, kind="stable"), np.argsort(face_ids, kind="stable")
    new_vertices, new_faces = np.argsort(vertices), np.argsort(faces)
    corners = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)])
    whole = replace(
        mesh,
        vertices=np.concatenate([part.vertices for part in parts])[vertices],
        faces=new_vertices[corners[faces]],
        vertex_ids=vertex_ids[vertices],
        face_ids=face_ids[faces],
        others=None,
    )
    n, m = len(mesh.vertices), len(mesh.faces)
    return whole, (new_vertices[:n], new_faces[:m]), (new_vertices[n:], new_faces[m:])


def unreached_vertices(mesh: Mesh) -> Ints:
    """The vertices of the user's file, as numbers in it, that no face of the repaired mesh and of its others uses."""
    reached = np.zeros(mesh.n_file_vertices, bool)
    for part in (mesh, mesh.others):
        if part is not None:
            reached[part.vertex_ids] = True
    return np.flatnonzero(~reached)
