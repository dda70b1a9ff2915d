"""Simplification of large meshes to a subset of their vertices, without change of topology.

Vertices are collapsed into a neighbour (half-edge collapse), those first that move the surface least by the quadrics of
the planes around them (Garland and Heckbert 1997). A small multiple of the squared distance to the vertices that a
vertex replaces is added, which makes triangles round and equally large. A collapse that would change the topology (link
condition) or turn a face over is not made, so the result is a manifold if the mesh was one.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .mesh import Floats, Ints
from .quadrics import add_quadrics, cost, squared_length, unit_normal
from .rings import MOST_FACES, after, around, before, collapse, neighbour, opposite_corners

FIRST, GROWTH = 0.25, 1.6
"""The quantile of the collapse costs that is the first threshold, and the factor from one threshold to the next."""

MIN_COSINE, MIN_HEIGHT = 0.3, 0.15
"""Bounds on a face after a collapse: the cosine between its normals before and after, and its height over its longest
edge, which may be less where it grows."""


def simplify(vertices: Floats, faces: Ints, count: int) -> tuple[Ints, Ints, Ints]:
    """Collapse vertices until ``count`` are left.

    Parameters
    ----------
    vertices, faces
        (n, 3) float64 and (m, 3) int64: a consistently oriented manifold, with or without boundary, in which every
        vertex is used.
    count
        Number of vertices wanted. More are left where no further collapse is allowed.

    Returns
    -------
    kept : (k,) int64
        Numbers of the remaining vertices, ascending.
    simple : (j, 3) int64
        Faces between them, in numbers from 0 to k - 1.
    home : (n,) int64
        For each given vertex the remaining one that it was collapsed into, from 0 to k - 1.
    """
    corners = faces.astype(np.int32).ravel()
    opposite = opposite_corners(faces)
    quadrics = np.zeros((len(vertices), 10))
    add_quadrics(vertices, corners, opposite, quadrics)
    home = np.arange(len(vertices), dtype=np.int32)
    corner_of = np.zeros(len(vertices), np.int32)
    corner_of[corners] = np.arange(len(corners))
    # Lower bounds of the cost of collapsing each vertex; NaN where the neighbourhood has changed.
    least = _all_costs(vertices, corners, opposite, corner_of, quadrics)
    threshold = max(float(np.quantile(least, FIRST)), 1e-30)
    # At least a tetrahedron remains: fewer vertices have no closed manifold.
    _collapse_vertices(vertices, corners, opposite, corner_of, quadrics, least, threshold, home, max(count, 4))
    kept = np.flatnonzero(home == np.arange(len(home)))
    rank = np.full(len(vertices), -1)
    rank[kept] = np.arange(len(kept))
    whole = corners[::3] >= 0
    return kept, rank[corners.reshape(-1, 3)[whole]], rank[_ends(home)]


@jit
def _ends(home: np.ndarray) -> np.ndarray:
    """The last vertex of the chain of collapses from each vertex."""
    for i in range(len(home)):
        end = i
        while home[end] != end:
            end = home[end]
        at = i
        while home[at] != end:  # so do all vertices of the chain
            home[at], at = end, home[at]
    return home


@jit
def _all_costs(
    vertices: np.ndarray, corners: np.ndarray, opposite: np.ndarray, corner_of: np.ndarray, quadrics: np.ndarray
) -> np.ndarray:
    """The least cost of collapsing each vertex into a neighbour, (n,) float32."""
    ring, costs = np.empty(MOST_FACES, np.int32), np.empty(MOST_FACES + 1)
    least = np.empty(len(vertices), np.float32)
    for i in range(len(vertices)):
        least[i] = _cheapest(i, vertices, corners, opposite, corner_of, quadrics, ring, costs)
    return least


@jit
def _collapse_vertices(
    vertices: np.ndarray,
    corners: np.ndarray,
    opposite: np.ndarray,
    corner_of: np.ndarray,
    quadrics: np.ndarray,
    least: np.ndarray,
    threshold: float,
    home: np.ndarray,
    count: int,
) -> None:
    """Collapse vertices of a cost below a threshold, which is raised step by step."""
    n = len(vertices)
    ring, other = np.empty(MOST_FACES, np.int32), np.empty(MOST_FACES, np.int32)
    costs, stamp = np.empty(MOST_FACES + 1), np.zeros(n + 1, np.int32)
    alive = np.arange(n).astype(np.int32)
    left = n
    n_alive = n
    idle = 0
    while left > count and idle < 12:
        before = left
        for place in range(n_alive):
            u = alive[place]
            if home[u] != u or least[u] > threshold:
                continue
            cheapest = _cheapest(u, vertices, corners, opposite, corner_of, quadrics, ring, costs)
            least[u] = cheapest
            if cheapest > threshold:
                continue
            number, closed = around(corner_of[u], opposite, ring)
            target = _choose(
                u, vertices, corners, opposite, corner_of, ring, number, closed, other, costs, stamp, threshold
            )
            if target < 0:
                least[u] = np.inf
                continue
            v = neighbour(target, ring, number, corners)
            for k in range(10):
                quadrics[v, k] += quadrics[u, k]
            for k in range(number + (not closed)):
                least[neighbour(k, ring, number, corners)] = np.nan
            collapse(u, v, target, ring, number, closed, corners, opposite, corner_of)
            home[u] = v
            left -= 1
            if left <= count:
                break
        idle = idle + 1 if left == before else 0
        threshold *= GROWTH
        kept = 0
        for place in range(n_alive):
            if home[alive[place]] == alive[place]:
                alive[kept] = alive[place]
                kept += 1
        n_alive = kept


@jit
def _cheapest(
    u: int,
    vertices: np.ndarray,
    corners: np.ndarray,
    opposite: np.ndarray,
    corner_of: np.ndarray,
    quadrics: np.ndarray,
    ring: np.ndarray,
    costs: np.ndarray,
) -> float:
    """Write the cost of collapsing vertex u into each neighbour; return the least."""
    number, closed = around(corner_of[u], opposite, ring)
    cheapest = np.inf
    for k in range(number + (not closed)):
        # A vertex at the boundary only moves along it.
        if closed or k == 0 or k == number:
            v = neighbour(k, ring, number, corners)
            costs[k] = max(cost(quadrics[u], quadrics[v], vertices[v]), 0.0)
            cheapest = min(cheapest, costs[k])
        else:
            costs[k] = np.inf
    return cheapest


@jit
def _choose(
    u: int,
    vertices: np.ndarray,
    corners: np.ndarray,
    opposite: np.ndarray,
    corner_of: np.ndarray,
    ring: np.ndarray,
    number: int,
    closed: bool,
    other: np.ndarray,
    costs: np.ndarray,
    stamp: np.ndarray,
    threshold: float,
) -> int:
    """The place in the ring of the cheapest neighbour that u may be collapsed into, -1 if there is none."""
    n_neighbours = number + (not closed)
    stamp[-1] += 1  # the last place counts the calls
    for k in range(n_neighbours):
        stamp[neighbour(k, ring, number, corners)] = stamp[-1]
    while True:
        best = -1
        for k in range(n_neighbours):
            if costs[k] <= threshold and (best < 0 or costs[k] < costs[best]):
                best = k
        if best < 0:
            return -1
        v = neighbour(best, ring, number, corners)
        size, v_closed = around(corner_of[v], opposite, other)
        common = 0
        for k in range(size + (not v_closed)):
            common += stamp[neighbour(k, other, size, corners)] == stamp[-1]
        # The link condition: the ends share the neighbours across their edge and no more.
        allowed = size > 0 and common == (2 if closed else 1) and size + number - 4 < MOST_FACES
        if not closed:  # a face with two boundary edges must keep its outer vertex
            corner = ring[min(best, number - 1)]
            allowed = (
                allowed and max(opposite[corner], opposite[after(corner) if best < number else before(corner)]) >= 0
            )
        if allowed and _stays_upright(u, v, vertices, corners, ring, number):
            return best
        costs[best] = np.inf


@jit
def _stays_upright(u: int, v: int, vertices: np.ndarray, corners: np.ndarray, ring: np.ndarray, number: int) -> bool:
    """Whether no face around u turns over or becomes a sliver if u is collapsed into v."""
    old, new = np.empty(3), np.empty(3)
    for k in range(number):
        a, b = corners[after(ring[k])], corners[before(ring[k])]
        if v in (a, b):
            continue
        area_old, area_new = unit_normal(vertices, u, a, b, old), unit_normal(vertices, v, a, b, new)
        if not area_new > 0.0:
            return False
        if area_old > 0.0 and old[0] * new[0] + old[1] * new[1] + old[2] * new[2] < MIN_COSINE:
            return False
        base = squared_length(vertices, a, b)
        height_new = area_new / max(base, squared_length(vertices, v, a), squared_length(vertices, v, b))
        if height_new < MIN_HEIGHT:
            longest = max(base, squared_length(vertices, u, a), squared_length(vertices, u, b))
            if not (longest > 0.0 and height_new > area_old / longest):
                return False
    return True
