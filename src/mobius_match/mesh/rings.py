"""Corner table of a manifold as plain arrays for kernels: corners, their opposite corners, rings around vertices.

A corner is 3 * face + k and has a vertex (Rossignac et al. 2001). In a consistently oriented mesh, ``after`` and
``before`` lead around the face, and ``opposite`` leads across the edge opposite to the corner.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .mesh import Ints
from .topology import edge_table

MOST_FACES = 40
"""Number of faces of the longest ring; vertices with more faces are not collapsed."""


def opposite_corners(faces: Ints) -> np.ndarray:
    """For each corner (3 m,) int32 the one that lies opposite it over the edge opposite to both; -1 at the boundary."""
    table = edge_table(faces)
    first, second = table.pairs
    opposite = np.full(faces.size, -1, np.int32)
    opposite[first] = second
    opposite[second] = first
    return opposite


@jit
def after(corner: int) -> int:
    """The next corner of the face, counter-clockwise."""
    return corner - 2 if corner % 3 == 2 else corner + 1


@jit
def before(corner: int) -> int:
    """The next corner of the face, clockwise."""
    return corner + 2 if corner % 3 == 0 else corner - 1


@jit
def neighbour(k: int, ring: np.ndarray, number: int, corners: np.ndarray) -> int:
    """Neighbour k of the vertex with this ring; an open ring has one neighbour more than faces."""
    return corners[after(ring[k])] if k < number else corners[before(ring[number - 1])]


@jit
def around(corner: int, opposite: np.ndarray, ring: np.ndarray) -> tuple[int, bool]:
    """Write the corners of a vertex in counter-clockwise order, given one of them.

    Returns
    -------
    number, closed
        Number of corners, 0 for a ring of more than :data:`MOST_FACES`, and whether the ring is closed.
    """
    first = corner
    closed = True
    for _ in range(MOST_FACES + 1):
        across = opposite[before(first)]
        if across < 0:
            closed = False
            break
        first = before(across)
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
        across = opposite[after(at)]
        if across < 0:
            break
        at = after(across)
        if at == first:
            break
    return number, closed


@jit
def collapse(
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
    """Collapse u into v, its neighbour at place ``target`` of the ring, and remove the faces between them."""
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
        ahead, behind = after(corner), before(corner)
        # The edges opposite to u's corner and to v's corner become one.
        across_u, across_v = opposite[corner], opposite[ahead if side == 0 else behind]
        if across_u >= 0:
            opposite[across_u] = across_v
        if across_v >= 0:
            opposite[across_v] = across_u
        far = corners[behind if side == 0 else ahead]
        known = across_u if across_u >= 0 else across_v
        one, two = after(known), before(known)
        swap = (side == 0) != (across_u >= 0)
        corner_of[far], corner_of[v] = (two, one) if swap else (one, two)
        corners[corner] = corners[ahead] = corners[behind] = -1
