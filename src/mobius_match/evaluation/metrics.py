"""Measures of a set of matches, on meshes repaired by :func:`mobius_match.mesh.repair`."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from ..geometry.farthest_points import farthest_points
from ..geometry.geodesics import edge_graph, geodesic_solver
from ..mesh import Mesh
from ..mesh.measure import areas, box_scale, unit_box
from ..mesh.pieces import MIN_FACES, main_piece, part_of_mesh
from ..mesh.topology import components

SWEEPS = 30
"""Number of farthest points from which the diameter is searched."""


def geodesic_distances(mesh: Mesh, sources: np.ndarray, targets: np.ndarray, method: str = "exact") -> np.ndarray:
    """Geodesic distances (Q,) between pairs of vertices, in the units of the mesh.

    Parameters
    ----------
    mesh
        A manifold mesh. Between two pieces the distance is that along edges and the bridges of
        :func:`mobius_match.geometry.geodesics.bridges`.
    sources, targets
        (Q,) vertex numbers in ``mesh``.
    method
        ``"exact"`` on the polyhedron (Mitchell et al. 1987), or ``"heat"`` (robust heat method from ``sources``).

    Notes
    -----
    A shortest path from s to t is not longer than the shortest path along edges, of length u, and a distance in space
    is not longer than one on the surface. So the path stays in the ellipsoid \\|x - s\\| + \\|x - t\\| <= u. The solver
    gets only the faces that reach into it, which makes close pairs fast and does not change the result.
    """
    number, label = components(mesh.faces)
    if number > 1:
        return _among_pieces(mesh, label, np.asarray(sources), np.asarray(targets), method)
    make_distances = {"exact": _exact, "heat": _heat}[method]
    out = np.zeros(len(sources))
    different = np.flatnonzero(np.asarray(sources) != np.asarray(targets))
    if len(different):
        distances = make_distances(unit_box(mesh.vertices), mesh.faces)
        for group in _groups(np.asarray(sources)[different]):
            rows = different[group]
            ends, back = np.unique(np.asarray(targets)[rows], return_inverse=True)
            out[rows] = distances(int(sources[rows[0]]), ends)[back]
    return out * box_scale(mesh.vertices)


def _among_pieces(mesh: Mesh, label: np.ndarray, sources: np.ndarray, targets: np.ndarray, method: str) -> np.ndarray:
    """:func:`geodesic_distances` on a mesh of several pieces, with the piece (m,) of each face."""
    piece = np.full(len(mesh.vertices), -1, np.int64)
    piece[mesh.faces.ravel()] = np.repeat(label, 3)
    graph = edge_graph(unit_box(mesh.vertices), mesh.faces)
    out = np.zeros(len(sources))
    together = piece[sources] == piece[targets]
    for group in _groups(piece[sources]):
        number = piece[sources[group[0]]]
        faces = label == number
        rows = group[together[group]]
        if len(rows) and faces.sum() >= MIN_FACES:
            one = part_of_mesh(mesh, piece == number, faces)
            place = np.cumsum(piece == number) - 1
            out[rows] = geodesic_distances(one, place[sources[rows]], place[targets[rows]], method)
            group = group[~together[group]]
        for some in _groups(sources[group]) if len(group) else ():
            lengths = dijkstra(graph, directed=False, indices=int(sources[group[some[0]]]))
            out[group[some]] = lengths[targets[group[some]]] * box_scale(mesh.vertices)
    return out


def _groups(values: np.ndarray) -> Iterator[np.ndarray]:
    """The indices of each distinct value."""
    order = np.argsort(values, kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(values[order])) + 1)


_Distances = Callable[[int, np.ndarray], np.ndarray]


def _heat(vertices: np.ndarray, faces: np.ndarray) -> _Distances:
    solver = geodesic_solver(vertices, faces, "heat")
    return lambda source, targets: solver(source)[targets]


def _exact(vertices: np.ndarray, faces: np.ndarray) -> _Distances:
    graph = edge_graph(vertices, faces)
    corners = vertices[faces]
    # No point of a triangle is farther from its closest corner than this.
    slack = np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max(axis=1) / np.sqrt(3)

    def distances(source: int, targets: np.ndarray) -> np.ndarray:
        in_space = np.linalg.norm(vertices - vertices[source], axis=1)
        along_edges = _along_edges(graph, source, targets, in_space[targets].max())
        return np.array([distance(in_space, source, int(t), u) for t, u in zip(targets, along_edges, strict=True)])

    def distance(in_space: np.ndarray, source: int, target: int, bound: float) -> float:
        sums = in_space + np.linalg.norm(vertices - vertices[target], axis=1)
        inside = faces[sums[faces].min(axis=1) - 2 * slack <= bound * (1 + 1e-9)]
        kept = np.unique(inside)
        ends = np.searchsorted(kept, [source, target])
        length = _solve(vertices[kept], np.searchsorted(kept, inside), *ends)
        # Outside the bounds the solver has failed on the part of the mesh.
        if not in_space[target] * (1 - 1e-9) <= length <= bound * (1 + 1e-9):
            length = _solve(vertices, faces, source, target)
        return length

    return distances


def _solve(vertices: np.ndarray, faces: np.ndarray, source: int, target: int) -> float:
    import igl

    vertices, faces = np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.int64)
    return float(igl.exact_geodesic(vertices, faces, VS=np.array([source]), VT=np.array([target]))[0])


def _along_edges(graph: sp.csr_matrix, source: int, targets: np.ndarray, guess: float) -> np.ndarray:
    """Lengths of the shortest edge paths to the targets, with a search radius that grows as needed."""
    limit = 1.5 * guess
    while True:
        lengths = dijkstra(graph, directed=False, indices=source, limit=limit)[targets]
        if np.isfinite(lengths).all():
            return lengths
        limit *= 2


def diameter(mesh: Mesh, method: str = "exact") -> float:
    """Estimate of the largest geodesic distance on the mesh, of several pieces on the main one, in its units.

    The largest heat distance between one of 30 farthest points and any vertex; with ``"exact"`` the exact distance of
    these two. It does not depend on the settings of a match, unlike :attr:`mobius_match.Surface.diameter`, which is
    the largest distance from the sample points.
    """
    mesh = main_piece(mesh)
    solver = geodesic_solver(unit_box(mesh.vertices), mesh.faces, "heat")
    best = (0.0, 0, 0)
    for start, row in farthest_points(solver, solver(0), SWEEPS):
        best = max(best, (float(row.max()), start, int(np.argmax(row))))
    if method == "heat":
        return best[0] * box_scale(mesh.vertices)
    return float(geodesic_distances(mesh, np.array([best[1]]), np.array([best[2]]), method)[0])


def coverage(mesh: Mesh, vertices: np.ndarray) -> dict[str, float]:
    """How evenly vertices are distributed over a mesh.

    Distances are those of shortest edge paths, which are a few percent too long.

    Returns
    -------
    dict
        ``mean``, ``largest``: mean over the area, and largest, distance of the surface from the nearest of the
        vertices, per sqrt(area).
        ``evenness``: exp(-sum a_q log a_q) / Q, where a_q is the share of the area that is nearest to vertex q; 1 if
        all shares are equal, 1/Q if one vertex has everything.
    """
    unit, faces = unit_box(mesh.vertices), mesh.faces
    weights = np.bincount(faces.ravel(), np.repeat(areas(mesh.vertices, faces) / 3, 3), len(unit))
    total = weights.sum()
    centres = np.unique(vertices)
    distances, _, nearest = dijkstra(
        edge_graph(unit, faces), directed=False, indices=centres, min_only=True, return_predecessors=True
    )
    shares = np.bincount(np.searchsorted(centres, nearest), weights, len(centres)) / total
    shares = shares[shares > 0]
    return {
        "mean": float(distances @ weights / total / np.sqrt(total)),
        "largest": float(distances.max() / np.sqrt(total)),
        "evenness": float(np.exp(-(shares @ np.log(shares))) / len(centres)),
    }


def ranking(confidence: np.ndarray, errors: np.ndarray) -> float | None:
    """Spearman's rank correlation of confidence (Q,) and negative error (Q,): 1 if the most confident are the best.

    Unknown errors (NaN) are ignored; None if fewer than three are known, or all are equal.
    """
    known = ~np.isnan(errors)
    if known.sum() < 3 or any(np.ptp(values[known]) == 0 for values in (confidence, errors)):
        return None
    return float(np.corrcoef(_ranks(confidence[known]), _ranks(-errors[known]))[0, 1])


def _ranks(values: np.ndarray) -> np.ndarray:
    """Ranks of the values; equal values have their mean rank."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]
