"""Handles of a surface: the shortest loops that separate nothing, and the surface cut open along them.

Cut along such a loop, a surface has one handle less and two boundary loops more, which lie on each other. A sphere with
holes is left when no handle is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import TopologyError
from .loops import closing_edges, loop_of, shortest_tree
from .measure import areas, unit_box
from .mesh import Floats, Ints, Mesh, count
from .parameters import EnvelopeParameters
from .sheets import cut_edges
from .topology import (
    EdgeTable,
    boundary_lengths,
    components,
    edge_table,
    euler_characteristic,
    fans,
    labels_of,
)

ROOTS = 6
"""Roots of trees, far from each other. Loops are shortened afterwards, so a few are enough to have one near each."""

ROOTS_ON_LOOP, ROOTS_BESIDE = 4, 4
"""Roots from which a loop is shortened: evenly spaced on it, and beside it within half of its length."""

SHORTER = 1 - 1e-9
"""A loop is shorter than another one if its length is less than this fraction: more than round-off."""

LISTED = 6
"""Loops that a note lists at most."""


def number_of_handles(faces: Ints, table: EdgeTable | None = None) -> int:
    """The genus of one connected, orientable manifold (m, 3) in which every vertex is used."""
    table = table or edge_table(faces)
    return (2 - len(boundary_lengths(table)) - euler_characteristic(faces, table)) // 2


def is_wild(handles: int, parameters: EnvelopeParameters = EnvelopeParameters()) -> bool:
    """Whether so many handles are too many for samples, and an envelope stands for the surface."""
    return handles > parameters.most_handles


def handle_loops(mesh: Mesh, number: int | None = None) -> list[Ints]:
    """Short loops around the handles of a surface, as many as it has; cut along all of them, it has none.

    By tree and cotree (Erickson and Whittlesey 2005) from several roots, then from roots on each loop until it gets no
    shorter; the shortest first. Loops do not touch each other or the boundary if that is possible.

    Parameters
    ----------
    mesh
        A connected, consistently oriented manifold in which every vertex is used.
    number
        Its :func:`number_of_handles`, if that is known.

    Returns
    -------
    list of numpy.ndarray
        Vertices of the mesh (l,) int64 of each loop, in order around it; the last is joined to the first.

    Raises
    ------
    TopologyError
        If the mesh is too coarse for such loops.
    """
    faces, origin = mesh.faces, np.arange(len(mesh.vertices))
    number = number_of_handles(faces) if number is None else number
    loops, unit = list[Ints](), unit_box(mesh.vertices)
    while len(loops) < number:
        graph = Graph.of(unit[origin], faces)
        found = graph.separate_loops(number - len(loops)) or graph.touching_loop()
        if not found:
            raise TopologyError(
                f"{mesh.name}: {count(number - len(loops), 'handle', 'handles')} of the surface cannot be cut along "
                "edges without cutting it in two. Use a finer mesh."
            )
        loops += [origin[loop] for loop in found]
        if len(loops) < number:
            faces, more = cut_faces(faces, found)
            origin = origin[more]
    return loops


def cut_along(mesh: Mesh, loops: list[Ints]) -> tuple[Mesh, Ints]:
    """Cut a surface open along loops of edges.

    Parameters
    ----------
    mesh
        A consistently oriented manifold.
    loops
        Vertices (l,) int64 of each loop, in order around it.

    Returns
    -------
    mesh : Mesh
        Vertices keep their order. Those of loops are doubled: both share the user's number in ``vertex_ids``, and the
        second one comes next to the first.
    origin : (n',) int64
        Of each vertex the number in the given mesh, ascending.
    """
    faces, origin = cut_faces(mesh.faces, loops)
    cut = replace(mesh, vertices=mesh.vertices[origin], faces=faces, vertex_ids=mesh.vertex_ids[origin])
    return cut, origin


def cut_faces(faces: Ints, loops: list[Ints]) -> tuple[Ints, Ints]:
    """:func:`cut_along` for faces (m, 3): those of the cut surface, and the old number of each vertex."""
    table = edge_table(faces)
    n = int(faces.max()) + 1
    cut = np.zeros(len(table.edges), dtype=bool)
    for loop in loops:
        cut[_edges_on(table, loop, n)] = True
    number, fan = fans(faces, cut_edges(table, np.flatnonzero(cut)))
    first = np.full(number, faces.size)
    np.minimum.at(first, fan.ravel(), np.arange(faces.size))
    # Vertices keep their order, and copies of one follow each other, as repair leaves them.
    vertex = faces.ravel()[first]
    order = np.lexsort((first, vertex))
    rank = np.empty(number, dtype=np.int64)
    rank[order] = np.arange(number)
    return rank[fan], vertex[order]


def loop_lengths(vertices: Floats, loops: list[Ints]) -> Floats:
    """Length of each loop, in the units of the vertices (n, 3)."""
    return np.array([np.linalg.norm(vertices[loop] - vertices[np.roll(loop, -1)], axis=1).sum() for loop in loops])


def handles_note(mesh: Mesh, loops: list[Ints], done: str) -> str:
    """One line about the handles of a mesh: how many, what was done, and where their loops are."""
    unit = unit_box(mesh.vertices)
    lengths = loop_lengths(unit, loops) / np.sqrt(areas(mesh.vertices, mesh.faces).sum())
    places = [
        f"{length:.2g} at vertex {mesh.vertex_ids[loop].min()}" for length, loop in zip(lengths, loops, strict=True)
    ]
    listed = ", ".join(places[:LISTED]) + (", ..." if len(places) > LISTED else "")
    return f"{count(len(loops), 'handle', 'handles')} {done} (length of the loop per sqrt(area): {listed})."


def _edges_on(table: EdgeTable, loop: Ints, n: int) -> Ints:
    """The edges of a loop (l,), as numbers in the table."""
    ends = np.sort(np.stack([loop, np.roll(loop, -1)], axis=1), axis=1)
    return np.searchsorted(table.edges[:, 0] * n + table.edges[:, 1], ends[:, 0] * n + ends[:, 1])


@dataclass(frozen=True, eq=False)
class Graph:
    """The edges of a surface, and the triangles on both sides of each.

    Parameters
    ----------
    vertices, faces, table
        The surface, and its edges.
    lengths
        (E,) of the edges.
    start, half_edges
        (n + 1,) and (2 E,): the edges at vertex v are ``half_edges[start[v] : start[v + 1]]``.
    sides, n_sides
        (E, 2) triangles of each edge; a boundary loop counts as one more triangle.
    boundary
        (n,) bool, the vertices on the boundary.
    """

    vertices: Floats
    faces: Ints
    table: EdgeTable
    lengths: Floats
    start: Ints
    half_edges: Ints
    sides: Ints
    n_sides: int
    boundary: np.ndarray

    @classmethod
    def of(cls, vertices: Floats, faces: Ints) -> Graph:
        """The graph of a manifold, (n, 3) and (m, 3)."""
        table = edge_table(faces)
        n, ends = len(vertices), table.edges.ravel()
        sides, rim = table.edge_faces.copy(), table.counts == 1
        loops, label = labels_of(n, *table.edges[rim].T)
        # Labels of single vertices, which are no loops, are not in use.
        sides[rim, 1] = len(faces) + label[table.edges[rim, 0]]
        boundary = np.zeros(n, dtype=bool)
        boundary[table.edges[rim]] = True
        return cls(
            vertices,
            faces,
            table,
            lengths=np.linalg.norm(vertices[table.edges[:, 0]] - vertices[table.edges[:, 1]], axis=1),
            start=np.concatenate([[0], np.cumsum(np.bincount(ends, minlength=n))]),
            half_edges=np.argsort(ends, kind="stable") // 2,
            sides=sides,
            n_sides=len(faces) + loops,
            boundary=boundary,
        )

    def loops_from(
        self, root: int, limit: float, blocked: np.ndarray, cut: np.ndarray
    ) -> tuple[list[tuple[float, Ints]], Floats]:
        """Loops through a root that separate nothing, with their lengths, and the distance of each vertex (n,).

        The path that leads from the root to a loop and back is left out, but counts for the limit.
        """
        distance, parent = np.empty(len(self.vertices)), np.empty(len(self.vertices), np.int64)
        edges = self.table.edges
        shortest_tree(root, limit, self.start, self.half_edges, edges, self.lengths, blocked, distance, parent)
        closing = closing_edges(limit, edges, self.lengths, self.sides, self.n_sides, cut, distance, parent)
        loops = [loop_of(edge, edges, distance, parent) for edge in closing.tolist()]
        return list(zip(loop_lengths(self.vertices, loops).tolist(), loops, strict=True)), distance

    def from_several_roots(self, blocked: np.ndarray, cut: np.ndarray) -> list[tuple[float, Ints]]:
        """Loops through roots that are far from each other, the shortest first."""
        # The first root is the farthest from the middle: it does not depend on the numbers of vertices.
        away = np.linalg.norm(self.vertices - self.vertices.mean(axis=0), axis=1)
        away[blocked] = -np.inf
        distances, found = np.where(blocked, -np.inf, np.inf), list[tuple[float, Ints]]()
        for _ in range(min(ROOTS, int((~blocked).sum()))):
            root = int((distances if found else away).argmax())
            loops, row = self.loops_from(root, np.inf, blocked, cut)
            found += loops
            away = distances = np.minimum(distances, row)
            distances[root] = -np.inf
        return sorted(found, key=lambda one: one[0])

    def shortened(self, length: float, loop: Ints, blocked: np.ndarray, cut: np.ndarray) -> Ints | None:
        """A loop that separates nothing, near a given one and not longer; None if there is none.

        Roots on the loop tighten it, those beside it slide it along a handle to where that is narrower.
        """
        best: Ints | None = None
        while True:
            limit = length / SHORTER if best is None else length * SHORTER
            roots = loop[np.unique(np.linspace(0, len(loop), ROOTS_ON_LOOP, endpoint=False).astype(int))]
            near, found = np.full(len(blocked), np.inf), list[tuple[float, Ints]]()
            for k in range(len(roots) + ROOTS_BESIDE):
                if k < len(roots):
                    root = int(roots[k])
                else:
                    root = int(np.where(near <= limit / 2, near, -1.0).argmax())
                loops, row = self.loops_from(root, limit, blocked, cut)
                found += loops
                near = np.minimum(near, row)
            if not found:
                return best
            length, loop = min(found, key=lambda one: one[0])
            best = loop

    def separate_loops(self, number: int) -> list[Ints]:
        """At most so many loops that separate nothing together, and touch neither each other nor the boundary."""
        blocked, cut = self.boundary.copy(), np.zeros(len(self.lengths), dtype=bool)
        found = list[Ints]()
        for length, loop in self.from_several_roots(blocked, cut):
            if len(found) == number:
                break
            if blocked[loop].any():
                continue
            short = self.shortened(length, loop, blocked, cut)
            if short is not None:
                found.append(short)
                blocked[short] = True
                cut[_edges_on(self.table, short, len(self.vertices))] = True
        return found

    def touching_loop(self) -> list[Ints]:
        """One short loop that may touch the boundary, where coarse meshes leave no room beside it."""
        free, cut = np.zeros(len(self.vertices), dtype=bool), np.zeros(len(self.lengths), dtype=bool)
        before = number_of_handles(self.faces, self.table)
        for _, loop in self.from_several_roots(free, cut):
            faces, _ = cut_faces(self.faces, [loop])
            # A loop that touches the boundary twice may cut off what lies between.
            if components(faces)[0] == 1 and number_of_handles(faces) < before:
                return [loop]
        return []
