"""What is measured of a set of matches, on meshes that :func:`mobius_match.mesh.repair` gave."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from ..geometry.farthest_points import farthest_points
from ..geometry.geodesics import edge_graph, geodesic_solver
from ..mesh import Mesh
from ..mesh.measure import areas, box_scale, unit_box

SWEEPS = 30
"""Farthest points that the diameter is looked for among."""


def geodesic_distances(mesh: Mesh, sources: np.ndarray, targets: np.ndarray, method: str = "exact") -> np.ndarray:
    """Geodesic distances (Q,) between pairs of vertices, in the units of the mesh.

    Parameters
    ----------
    mesh
        A connected manifold mesh.
    sources, targets
        (Q,) vertex numbers in ``mesh``.
    method
        ``"exact"`` on the polyhedron (Mitchell et al. 1987), or ``"heat"`` (robust heat method from ``sources``).

    Notes
    -----
    An exact shortest path from s to t, no longer than the shortest one along edges, of length u, stays where
    \\|x - s\\| + \\|x - t\\| <= u, as no distance in space exceeds one on the surface. So only the faces that reach
    into this ellipsoid are given to the solver, which makes close pairs cheap and changes no result.
    """
    between = {"exact": _exact, "heat": _heat}[method]
    out = np.zeros(len(sources))
    apart = np.flatnonzero(np.asarray(sources) != np.asarray(targets))
    if len(apart):
        distances = between(unit_box(mesh.vertices), mesh.faces)
        for group in _groups(np.asarray(sources)[apart]):
            rows = apart[group]
            ends, back = np.unique(np.asarray(targets)[rows], return_inverse=True)
            out[rows] = distances(int(sources[rows[0]]), ends)[back]
    return out * box_scale(mesh.vertices)


def _groups(values: np.ndarray) -> Iterator[np.ndarray]:
    """For each different value the places where it stands."""
    order = np.argsort(values, kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(values[order])) + 1)


_Between = Callable[[int, np.ndarray], np.ndarray]


def _heat(vertices: np.ndarray, faces: np.ndarray) -> _Between:
    solver = geodesic_solver(vertices, faces, "heat")
    return lambda source, targets: solver(source)[targets]


def _exact(vertices: np.ndarray, faces: np.ndarray) -> _Between:
    graph = edge_graph(vertices, faces)
    corners = vertices[faces]
    # No point of a triangle is farther from the closest corner than this.
    slack = np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max(axis=1) / np.sqrt(3)

    def distances(source: int, targets: np.ndarray) -> np.ndarray:
        apart = np.linalg.norm(vertices - vertices[source], axis=1)
        along_edges = _along_edges(graph, source, targets, apart[targets].max())
        return np.array([one(apart, source, int(t), u) for t, u in zip(targets, along_edges, strict=True)])

    def one(apart: np.ndarray, source: int, target: int, bound: float) -> float:
        reach = apart + np.linalg.norm(vertices - vertices[target], axis=1)
        near = faces[reach[faces].min(axis=1) - 2 * slack <= bound * (1 + 1e-9)]
        kept = np.unique(near)
        ends = np.searchsorted(kept, [source, target])
        found = _solve(vertices[kept], np.searchsorted(kept, near), *ends)
        # The solver's answer for a part that it could not cross would be one of these.
        if not apart[target] * (1 - 1e-9) <= found <= bound * (1 + 1e-9):
            found = _solve(vertices, faces, source, target)
        return found

    return distances


def _solve(vertices: np.ndarray, faces: np.ndarray, source: int, target: int) -> float:
    import igl

    vertices, faces = np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.int64)
    return float(igl.exact_geodesic(vertices, faces, VS=np.array([source]), VT=np.array([target]))[0])


def _along_edges(graph: sp.csr_matrix, source: int, targets: np.ndarray, guess: float) -> np.ndarray:
    """Lengths of the shortest edge paths to the targets, looking no farther than needed."""
    limit = 1.5 * guess
    while True:
        found = dijkstra(graph, directed=False, indices=source, limit=limit)[targets]
        if np.isfinite(found).all():
            return found
        limit *= 2


def diameter(mesh: Mesh, method: str = "exact") -> float:
    """Estimate of the largest geodesic distance on the mesh, in its units.

    The two most distant of 30 farthest points and all vertices by heat distances; with ``"exact"`` the distance
    of these two is then exact. It does not depend on any setting of the matching, other than
    :attr:`mobius_match.Surface.diameter`, the largest distance from the sample points.
    """
    solver = geodesic_solver(unit_box(mesh.vertices), mesh.faces, "heat")
    best = (0.0, 0, 0)
    for start, row in farthest_points(solver, solver(0), SWEEPS):
        best = max(best, (float(row.max()), start, int(np.argmax(row))))
    if method == "heat":
        return best[0] * box_scale(mesh.vertices)
    return float(geodesic_distances(mesh, np.array([best[1]]), np.array([best[2]]), method)[0])


def coverage(mesh: Mesh, vertices: np.ndarray) -> dict[str, float]:
    """How evenly vertices lie over a mesh.

    Distances here are those of shortest edge paths, some percent too long.

    Returns
    -------
    dict
        ``mean``, ``largest``: mean over the area, and largest, distance of the surface from the nearest of the
        vertices, per sqrt(area).
        ``evenness``: each of the Q vertices has the part of the surface that is nearest to it, the share a_q of the
        area; exp(-sum a_q log a_q) / Q is 1 if all parts are equal and 1/Q if one has everything.
    """
    unit, faces = unit_box(mesh.vertices), mesh.faces
    weights = np.bincount(faces.ravel(), np.repeat(areas(mesh.vertices, faces) / 3, 3), len(unit))
    total = weights.sum()
    places = np.unique(vertices)
    distances, _, nearest = dijkstra(
        edge_graph(unit, faces), directed=False, indices=places, min_only=True, return_predecessors=True
    )
    shares = np.bincount(np.searchsorted(places, nearest), weights, len(places)) / total
    shares = shares[shares > 0]
    return {
        "mean": float(distances @ weights / total / np.sqrt(total)),
        "largest": float(distances.max() / np.sqrt(total)),
        "evenness": float(np.exp(-(shares @ np.log(shares))) / len(places)),
    }


def ranking(confidence: np.ndarray, errors: np.ndarray) -> float | None:
    """Spearman's rank correlation of confidence (Q,) with minus error (Q,): 1 if the surest are the best.

    Errors that are not known (NaN) do not count; None where nothing can be ranked.
    """
    known = ~np.isnan(errors)
    if known.sum() < 3 or any(np.ptp(values[known]) == 0 for values in (confidence, errors)):
        return None
    return float(np.corrcoef(_ranks(confidence[known]), _ranks(-errors[known]))[0, 1])


def _ranks(values: np.ndarray) -> np.ndarray:
    """Places in order of size, equal values sharing the mean of theirs."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]
