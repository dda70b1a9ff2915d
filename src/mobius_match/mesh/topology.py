"""The combinatorics of triangle lists: edges, boundary, components, genus. Plain arrays in, plain arrays out.

Corner k of a face is its k-th vertex; the edge opposite to it joins corners k+1 and k+2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..errors import TopologyError
from .mesh import Ints

Bools = NDArray[np.bool_]

LARGE = 100_000
"""Number of nodes of a graph from which compiled kernels are used; they take time to load."""


@dataclass(frozen=True, eq=False)
class EdgeTable:
    """Every edge once, with the faces on it.

    Attributes
    ----------
    edges : (E, 2) int64
        Vertex numbers, the lower first; sorted.
    counts : (E,) int64
        How many faces share the edge: 1 on the boundary, 2 inside, more where the surface is not a manifold.
    edge_faces : (E, 2) int64
        The first two faces of each edge, the second -1 on the boundary.
    face_edges : (m, 3) int64
        Number of the edge opposite to each corner.
    order : (3 m,) int64
        All corners (3 * face + k) sorted by the edge opposite to them; edge e owns a run of ``counts[e]``.
    """

    edges: Ints
    counts: Ints
    edge_faces: Ints
    face_edges: Ints
    order: Ints

    @cached_property
    def pairs(self) -> tuple[Ints, Ints]:
        """Corners opposite to one edge, as pairs that link all faces on it: (P,), (P,)."""
        edge = self.face_edges.ravel()[self.order]
        same = edge[1:] == edge[:-1]
        return self.order[:-1][same], self.order[1:][same]


def edge_table(faces: Ints) -> EdgeTable:
    """The edges of faces (m, 3), none of which names a vertex twice."""
    base, key = _edge_keys(faces)
    if base**2 * len(key) < 2**63:
        # Sorting numbers takes a quarter of the time of a stable sort of their places.
        both = np.sort(key * len(key) + np.arange(len(key)))
        ranked = both // max(len(key), 1)
        order = both - ranked * len(key)
    else:
        order = np.argsort(key, kind="stable")
        ranked = key[order]
    fresh = np.ones(len(key), dtype=bool)
    fresh[1:] = ranked[1:] != ranked[:-1]
    return grouped(order, fresh, _ends(ranked[fresh], base))


def _edge_keys(faces: Ints) -> tuple[int, Ints]:
    """The number of vertices, and a number (3 m,) for the edge opposite to each corner; those of edges ascend."""
    tail, head = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    base = int(faces.max(initial=0)) + 1
    return base, np.minimum(tail, head) * base + np.maximum(tail, head)


def _ends(keys: Ints, base: int) -> Ints:
    """The vertices (e, 2) of edges, from their numbers (e,)."""
    return np.stack([keys // base, keys % base], axis=1)


def grouped(order: Ints, fresh: Bools, edges: Ints) -> EdgeTable:
    """The table of edges whose corners follow each other in `order` (3 m,); `fresh` marks the first of each edge.

    Several edges may have the same ends: those are the sheets of an edge that is cut, see :mod:`.sheets`.
    """
    start = np.flatnonzero(fresh)
    counts = np.diff(np.append(start, len(order)))
    face_edges = np.empty(len(order), dtype=np.int64)
    face_edges[order] = np.cumsum(fresh) - 1
    edge_faces = np.full((len(start), 2), -1, dtype=np.int64)
    edge_faces[:, 0] = order[start] // 3
    edge_faces[counts > 1, 1] = order[start[counts > 1] + 1] // 3
    return EdgeTable(edges, counts, edge_faces, face_edges.reshape(-1, 3), order)


def used_vertices(faces: Ints) -> Ints:
    """The vertices that some face names, sorted."""
    return np.flatnonzero(np.bincount(faces.ravel()))  # np.unique takes ten times as long


def labels_of(size: int, first: Ints, second: Ints) -> tuple[int, Ints]:
    """Connected components of a graph with these edges: their number, and the label of each node (size,)."""
    if not size:
        return 0, np.zeros(0, dtype=np.int64)
    if size >= LARGE:
        from .links import linked

        return linked(size, first, second)
    graph = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(size, size))
    number, labels = connected_components(graph, directed=False)
    return int(number), labels.astype(np.int64)


def components(faces: Ints, table: EdgeTable | None = None) -> tuple[int, Ints]:
    """Pieces joined by edges (a shared vertex alone does not join): number, label of each face (m,)."""
    first, second = (table or edge_table(faces)).pairs
    return labels_of(len(faces), first // 3, second // 3)


def fans(faces: Ints, table: EdgeTable, extra: tuple[Ints, Ints] | None = None) -> tuple[int, Ints]:
    """Fans of faces around vertices: number, label of each corner (m, 3).

    Two corners belong to one fan where faces follow each other over edges at their vertex; a manifold
    vertex has one fan. `extra` holds further pairs of corners to link.
    """
    one, two = table.pairs
    if faces.size >= LARGE:
        from .links import fan_links

        number, labels = fan_links(np.ascontiguousarray(faces), one, two, *(extra or (one[:0], two[:0])))
        return number, labels.reshape(-1, 3)
    links_one, links_two = [], []
    for k in (1, 2):
        # The ends of the common edge, seen from both faces; where the faces disagree on its direction,
        # crosswise.
        end_one = one // 3 * 3 + (one + k - one // 3 * 3) % 3
        for j in (1, 2):
            end_two = two // 3 * 3 + (two + j - two // 3 * 3) % 3
            match = faces.ravel()[end_one] == faces.ravel()[end_two]
            links_one.append(end_one[match])
            links_two.append(end_two[match])
    if extra is not None:
        links_one.append(extra[0])
        links_two.append(extra[1])
    number, labels = labels_of(faces.size, np.concatenate(links_one), np.concatenate(links_two))
    return number, labels.reshape(-1, 3)


def nonmanifold_edges(table: EdgeTable) -> Ints:
    """Numbers of the edges that more than two faces share."""
    return np.flatnonzero(table.counts > 2)


def nonmanifold_vertices(faces: Ints, table: EdgeTable | None = None) -> Ints:
    """Vertices at which two or more fans of faces touch."""
    _, labels = fans(faces, table or edge_table(faces))
    _, corner = np.unique(labels.ravel(), return_index=True)
    vertex, count = np.unique(faces.ravel()[corner], return_counts=True)
    return vertex[count > 1]


def sides(faces: Ints, table: EdgeTable) -> tuple[Ints, Bools, Bools]:
    """Which faces are consistently oriented, from the connected components of the orientation double cover.

    Each face has an upper and a lower side; across an edge with two faces, sides are linked to sides. On an
    orientable piece the sides fall into two classes; on a Moebius strip all are one.

    Returns
    -------
    piece : (m,) int64
        Label of each face's piece of surface, connected over edges with exactly two faces.
    turned : (m,) bool
        Whether the face is oriented against the lowest-numbered face of its piece.
    twisted : (m,) bool
        Whether the face lies on a piece that cannot be oriented.
    """
    m = len(faces)
    one, two = table.pairs
    plain = table.counts[table.face_edges.ravel()[one]] == 2
    one, two = one[plain], two[plain]
    corners = faces.ravel()
    clash = corners[one // 3 * 3 + (one + 1 - one // 3 * 3) % 3] == corners[two // 3 * 3 + (two + 1 - two // 3 * 3) % 3]
    f, g = one // 3, two // 3
    _, labels = labels_of(2 * m, np.concatenate([f, f + m]), np.concatenate([g + m * clash, g + m * ~clash]))
    upper, lower = labels[:m], labels[m:]
    piece = np.minimum(upper, lower)
    first = np.full(2 * m, m)
    np.minimum.at(first, piece, np.arange(m))
    return piece, upper != upper[first[piece]], upper == lower


def euler_characteristic(faces: Ints, table: EdgeTable | None = None) -> int:
    """V - E + F, where V counts only vertices that a face uses."""
    return len(used_vertices(faces)) - len((table or edge_table(faces)).edges) + len(faces)


def boundary_loops(faces: Ints, table: EdgeTable | None = None) -> list[Ints]:
    """The boundary as cycles of vertices, each in the direction of the faces along it, longest first.

    Raises
    ------
    TopologyError
        The faces around the boundary are not consistently oriented.
    """
    table = table or edge_table(faces)
    corner = table.order[np.append(0, np.cumsum(table.counts)[:-1])[table.counts == 1]]
    face, k = corner // 3, corner % 3
    after: dict[int, list[int]] = {}
    for tail, head in zip(faces[face, (k + 1) % 3].tolist(), faces[face, (k + 2) % 3].tolist(), strict=True):
        after.setdefault(tail, []).append(head)
    loops = []
    for start in list(after):
        while after.get(start):
            loop: list[int] = []
            at = start
            while at != start or not loop:
                loop.append(at)
                if not after.get(at):
                    raise TopologyError("the faces along the boundary are not consistently oriented; repair first.")
                at = after[at].pop()
            loops.append(np.array(loop, dtype=np.int64))
    return sorted(loops, key=lambda loop: -len(loop))


def boundary_edges(faces: Ints) -> Ints:
    """The edges (b, 2) that have one face, sorted."""
    base, key = _edge_keys(faces)
    key = np.sort(key)
    same = np.concatenate([[False], key[1:] == key[:-1], [False]])
    return _ends(key[~(same[1:] | same[:-1])], base)


def boundary_lengths(table: EdgeTable) -> Ints:
    """Number of edges of each closed curve of a manifold's boundary, longest first; any orientation."""
    ends = table.edges[table.counts == 1]
    vertices, places = np.unique(ends, return_inverse=True)
    places = places.reshape(-1, 2)
    number, labels = labels_of(len(vertices), places[:, 0], places[:, 1])
    return np.sort(np.bincount(labels[places[:, 0]], minlength=number))[::-1]


def genus(faces: Ints, table: EdgeTable | None = None) -> int | None:
    """Total number of handles of all components; None if the surface is no orientable manifold."""
    table = table or edge_table(faces)
    if not len(faces) or len(nonmanifold_edges(table)) or len(nonmanifold_vertices(faces, table)):
        return None
    if sides(faces, table)[2].any():
        return None
    number, _ = components(faces, table)
    return (2 * number - len(boundary_lengths(table)) - euler_characteristic(faces, table)) // 2


def edges_of(faces: Ints) -> Ints:
    """The edges (E, 2) of faces (m, 3), each once, lower vertex first, sorted."""
    return edge_table(faces).edges
