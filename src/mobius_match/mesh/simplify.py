"""Simplification of large meshes, to fewer vertices that are some of the mesh's own, without change of topology.

Vertices are drawn into a neighbour one by one (half-edge collapse) where that moves the surface least, by quadrics of
the planes around (Garland and Heckbert 1997). To these is added a little of the squared distance to the vertices that a
vertex stands for, which makes triangles round and equally large. A collapse that would change the topology (link
condition) or turn a face over is not made, so that the result is as good a manifold as what was given.
"""

from __future__ import annotations

import numpy as np

from ..compiling import inlined, jit
from .mesh import Floats, Ints
from .topology import edge_table

ROUNDNESS = 0.05
"""What the distance to the vertices stood for counts, against that to the planes around."""

FIRST, GROWTH = 0.25, 1.6
"""Share of the vertices that the first threshold lets go, and the factor from one threshold to the next."""

MOST_FACES = 40
"""Vertices with so many faces around stay."""

LEAST_TURN, LEAST_HEIGHT = 0.3, 0.15
"""Least cosine between a face's normals before and after, and least height over longest edge, unless it grows."""

RIM = 10.0
"""What the planes through the boundary count, against those of faces."""


def simplify(vertices: Floats, faces: Ints, count: int) -> tuple[Ints, Ints, Ints]:
    """Draw vertices together until few are left.

    Parameters
    ----------
    vertices, faces
        (n, 3) float64 and (m, 3) int64: a consistently oriented manifold, with or without boundary, in which every
        vertex is used.
    count
        Number of vertices wanted. More may be left, where none can be drawn in without harm.

    Returns
    -------
    kept : (k,) int64
        Numbers of the vertices that are left, ascending.
    simple : (j, 3) int64
        Faces between them, in numbers from 0 to k - 1.
    home : (n,) int64
        For each given vertex the one of those left that it was drawn into, from 0 to k - 1.
    """
    corners = faces.astype(np.int32).ravel()
    opposite = opposite_corners(faces)
    quadrics = np.zeros((len(vertices), 10))
    _add_quadrics(vertices, corners, opposite, quadrics)
    home = np.arange(len(vertices), dtype=np.int32)
    _draw_in(vertices, corners, opposite, quadrics, home, count)
    kept = np.flatnonzero(home == np.arange(len(home)))
    rank = np.full(len(vertices), -1)
    rank[kept] = np.arange(len(kept))
    whole = corners[::3] >= 0
    return kept, rank[corners.reshape(-1, 3)[whole]], rank[_ends(home)]


def opposite_corners(faces: Ints) -> np.ndarray:
    """For each corner (3 m,) int32 the one that lies opposite it over the edge opposite to both; -1 at the boundary."""
    table = edge_table(faces)
    first, second = table.pairs
    opposite = np.full(faces.size, -1, np.int32)
    opposite[first] = second
    opposite[second] = first
    return opposite


@jit
def _ends(home: np.ndarray) -> np.ndarray:
    """Where each vertex ends that follows the chain."""
    for i in range(len(home)):
        end = i
        while home[end] != end:
            end = home[end]
        at = i
        while home[at] != end:  # all on the way end there too
            home[at], at = end, home[at]
    return home


@inlined
def _after(corner: int) -> int:
    return corner - 2 if corner % 3 == 2 else corner + 1


@inlined
def _before(corner: int) -> int:
    return corner + 2 if corner % 3 == 0 else corner - 1


@inlined
def _add_plane(quadric: np.ndarray, x: float, y: float, z: float, d: float, weight: float) -> None:
    quadric[0] += weight * x * x
    quadric[1] += weight * x * y
    quadric[2] += weight * x * z
    quadric[3] += weight * x * d
    quadric[4] += weight * y * y
    quadric[5] += weight * y * z
    quadric[6] += weight * y * d
    quadric[7] += weight * z * z
    quadric[8] += weight * z * d
    quadric[9] += weight * d * d


@jit
def _add_quadrics(vertices: np.ndarray, corners: np.ndarray, opposite: np.ndarray, quadrics: np.ndarray) -> None:
    normal, along, rim = np.empty(3), np.empty(3), np.empty(3)
    for face in range(len(corners) // 3):
        a, b, c = corners[3 * face], corners[3 * face + 1], corners[3 * face + 2]
        area = 0.5 * _normal(vertices, a, b, c, normal)
        if not area > 0.0:
            continue
        offset = -(normal[0] * vertices[a, 0] + normal[1] * vertices[a, 1] + normal[2] * vertices[a, 2])
        for k in range(3):
            v = corners[3 * face + k]
            quadric = quadrics[v]
            _add_plane(quadric, normal[0], normal[1], normal[2], offset, area / 3)
            # A point is three planes through it.
            _add_plane(quadric, 1.0, 0.0, 0.0, -vertices[v, 0], ROUNDNESS * area / 3)
            _add_plane(quadric, 0.0, 1.0, 0.0, -vertices[v, 1], ROUNDNESS * area / 3)
            _add_plane(quadric, 0.0, 0.0, 1.0, -vertices[v, 2], ROUNDNESS * area / 3)
        for k in range(3):
            if opposite[3 * face + k] < 0:  # a plane through the edge, upright on the face, holds the boundary
                p, q = corners[_after(3 * face + k)], corners[_before(3 * face + k)]
                squared = 0.0
                for axis in range(3):
                    along[axis] = vertices[q, axis] - vertices[p, axis]
                    squared += along[axis] ** 2
                length = np.sqrt(squared)
                if length > 0.0:
                    for axis in range(3):
                        i, j = (axis + 1) % 3, (axis + 2) % 3
                        rim[axis] = (normal[i] * along[j] - normal[j] * along[i]) / length
                    offset_rim = -(rim[0] * vertices[p, 0] + rim[1] * vertices[p, 1] + rim[2] * vertices[p, 2])
                    for v in (p, q):
                        _add_plane(quadrics[v], rim[0], rim[1], rim[2], offset_rim, RIM * squared / 2)


@inlined
def _normal(vertices: np.ndarray, a: int, b: int, c: int, normal: np.ndarray) -> float:
    """Write the unit normal of a triangle; its length before, twice the area, is returned."""
    x1, y1, z1 = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    x2, y2, z2 = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
    normal[0], normal[1], normal[2] = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if length > 0.0:
        normal /= length
    return length


@inlined
def _cost(one: np.ndarray, two: np.ndarray, place: np.ndarray) -> float:
    """The quadrics of two vertices, taken at one place."""
    x, y, z = place[0], place[1], place[2]
    return (
        (one[0] + two[0]) * x * x
        + 2 * (one[1] + two[1]) * x * y
        + 2 * (one[2] + two[2]) * x * z
        + 2 * (one[3] + two[3]) * x
        + (one[4] + two[4]) * y * y
        + 2 * (one[5] + two[5]) * y * z
        + 2 * (one[6] + two[6]) * y
        + (one[7] + two[7]) * z * z
        + 2 * (one[8] + two[8]) * z
        + (one[9] + two[9])
    )


@jit
def _around(corner: int, opposite: np.ndarray, ring: np.ndarray) -> tuple[int, bool]:
    """Write a vertex's corners, one of which is given, in counter-clockwise order: how many, and if they close.

    A ring that is too long is given as empty.
    """
    first = corner
    closed = True
    for _ in range(MOST_FACES + 1):
        across = opposite[_before(first)]
        if across < 0:
            closed = False
            break
        first = _before(across)
        if first == corner:
            break
    else:
        return 0, True
    number, at = 0, first
    while True:
        if number == MOST_FACES:
            return 0, True
        ring[number] = at
        number += 1
        across = opposite[_after(at)]
        if across < 0:
            break
        at = _after(across)
        if at == first:
            break
    return number, closed


@jit
def _draw_in(
    vertices: np.ndarray,
    corners: np.ndarray,
    opposite: np.ndarray,
    quadrics: np.ndarray,
    home: np.ndarray,
    count: int,
) -> None:
    n = len(vertices)
    corner_of = np.full(n, -1, np.int32)
    for corner in range(len(corners)):
        corner_of[corners[corner]] = corner
    ring, other = np.empty(MOST_FACES, np.int32), np.empty(MOST_FACES, np.int32)
    costs = np.empty(MOST_FACES + 1)
    stamp = np.zeros(n + 1, np.int32)
    # What it would take to draw each vertex in: at least the cost noted, NaN where the neighbourhood has changed.
    least = np.full(n, np.nan, np.float32)
    alive = np.arange(n).astype(np.int32)
    for i in range(n):
        least[i] = _cheapest(i, vertices, corners, opposite, corner_of, quadrics, ring, costs)
    left = n
    threshold = max(np.partition(least, int(FIRST * n))[int(FIRST * n)], 1e-30)
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
            number, closed = _around(corner_of[u], opposite, ring)
            target = _choose(
                u, vertices, corners, opposite, corner_of, ring, number, closed, other, costs, stamp, threshold
            )
            if target < 0:
                least[u] = np.inf
                continue
            v = _neighbour(target, ring, number, corners)
            for k in range(10):
                quadrics[v, k] += quadrics[u, k]
            for k in range(number + (not closed)):
                least[_neighbour(k, ring, number, corners)] = np.nan
            _collapse(u, v, target, ring, number, closed, corners, opposite, corner_of)
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


@inlined
def _neighbour(k: int, ring: np.ndarray, number: int, corners: np.ndarray) -> int:
    """Neighbour k of the vertex whose ring it is; an open one has one neighbour more than faces."""
    return corners[_after(ring[k])] if k < number else corners[_before(ring[number - 1])]


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
    """Write what it costs to draw vertex u into each neighbour; the least of it."""
    number, closed = _around(corner_of[u], opposite, ring)
    cheapest = np.inf
    for k in range(number + (not closed)):
        # A vertex at the boundary only moves along it.
        if closed or k == 0 or k == number:
            v = _neighbour(k, ring, number, corners)
            costs[k] = max(_cost(quadrics[u], quadrics[v], vertices[v]), 0.0)
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
    """The place in the ring of the cheapest neighbour that u can be drawn into without harm, -1 if there is none."""
    n_neighbours = number + (not closed)
    stamp[-1] += 1  # the last place counts the calls
    for k in range(n_neighbours):
        stamp[_neighbour(k, ring, number, corners)] = stamp[-1]
    while True:
        best = -1
        for k in range(n_neighbours):
            if costs[k] <= threshold and (best < 0 or costs[k] < costs[best]):
                best = k
        if best < 0:
            return -1
        v = _neighbour(best, ring, number, corners)
        size, v_closed = _around(corner_of[v], opposite, other)
        common = 0
        for k in range(size + (not v_closed)):
            common += stamp[_neighbour(k, other, size, corners)] == stamp[-1]
        # The link condition: the ends share the neighbours across their edge and no more.
        fine = size > 0 and common == (2 if closed else 1) and size + number - 4 < MOST_FACES
        if not closed:  # a face with two edges at the boundary must not take its outer vertex along
            corner = ring[min(best, number - 1)]
            fine = fine and max(opposite[corner], opposite[_after(corner) if best < number else _before(corner)]) >= 0
        if fine and _stays_upright(u, v, vertices, corners, ring, number):
            return best
        costs[best] = np.inf


@jit
def _stays_upright(u: int, v: int, vertices: np.ndarray, corners: np.ndarray, ring: np.ndarray, number: int) -> bool:
    """Whether no face around u turns over or becomes a sliver if u is drawn into v."""
    old, new = np.empty(3), np.empty(3)
    for k in range(number):
        a, b = corners[_after(ring[k])], corners[_before(ring[k])]
        if v in (a, b):
            continue
        area_old, area_new = _normal(vertices, u, a, b, old), _normal(vertices, v, a, b, new)
        if not area_new > 0.0:
            return False
        if area_old > 0.0 and old[0] * new[0] + old[1] * new[1] + old[2] * new[2] < LEAST_TURN:
            return False
        base = _squared(vertices, a, b)
        height_new = area_new / max(base, _squared(vertices, v, a), _squared(vertices, v, b))
        if height_new < LEAST_HEIGHT:
            longest = max(base, _squared(vertices, u, a), _squared(vertices, u, b))
            if not (longest > 0.0 and height_new > area_old / longest):
                return False
    return True


@inlined
def _squared(vertices: np.ndarray, a: int, b: int) -> float:
    return (
        (vertices[a, 0] - vertices[b, 0]) ** 2
        + (vertices[a, 1] - vertices[b, 1]) ** 2
        + (vertices[a, 2] - vertices[b, 2]) ** 2
    )


@jit
def _collapse(
    u: int,
    v: int,
    target: int,
    ring: np.ndarray,
    number: int,
    closed: bool,
    corners: np.ndarray,
    opposite: np.ndarray,
    corner_of: np.ndarray,
) -> None:
    """Draw u into v, its neighbour at a place of the ring, and take the faces between them out."""
    for k in range(number):
        corners[ring[k]] = v
    for side in range(2):
        # Face `target` has the edge (u, v) clockwise of it, the one before it in the ring has it counter-clockwise.
        place = target - side
        if place < 0:
            if not closed:
                continue
            place = number - 1
        if place >= number:
            continue
        corner = ring[place]
        ahead, behind = _after(corner), _before(corner)
        # The edges opposite of u's corner and of v's corner become one.
        across_u, across_v = opposite[corner], opposite[ahead if side == 0 else behind]
        if across_u >= 0:
            opposite[across_u] = across_v
        if across_v >= 0:
            opposite[across_v] = across_u
        far = corners[behind if side == 0 else ahead]
        ends = (across_u, side == 0) if across_u >= 0 else (across_v, side == 1)
        corner_of[far] = _after(ends[0]) if ends[1] else _before(ends[0])
        corner_of[v] = _before(ends[0]) if ends[1] else _after(ends[0])
        corners[corner] = corners[ahead] = corners[behind] = -1
