"""Cavities: closed pieces that face against the solid that they lie in. Compiled; imported for several pieces only."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .measure import cross_products, unit_box
from .mesh import Floats, Ints

INSIDE = 0.5
"""Generalised winding number above which a point is inside: it is near 1 inside a surface, and near 0 outside."""


def cavities_among(vertices: Floats, faces: Ints, label: Ints, closed: np.ndarray) -> np.ndarray:
    """Which pieces (k,) bool are cavities: closed, and facing against the solid that they lie in.

    Parameters
    ----------
    vertices, faces, label
        The mesh (n, 3) and (m, 3), with the piece (m,) of each face. Each piece is consistently oriented.
    closed
        (k,) bool: which pieces have no boundary.
    """
    unit = unit_box(vertices)
    volume = np.bincount(label, np.einsum("ij,ij->i", unit[faces[:, 0]], cross_products(unit, faces)), len(closed))
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(len(closed) + 1))
    corners = unit[faces[order]]
    low, high = (
        np.stack([reduce.reduceat(bound(corners, axis=1)[:, axis], start[:-1]) for axis in range(3)], axis=1)
        for reduce, bound in ((np.minimum, np.min), (np.maximum, np.max))
    )
    found = np.zeros(len(closed), bool)
    _mark_cavities(corners, start, low, high, volume, closed, INSIDE, found)
    return found


@jit
def _mark_cavities(
    corners: np.ndarray,
    start: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    volume: np.ndarray,
    closed: np.ndarray,
    inside: float,
    found: np.ndarray,
) -> None:
    """Mark each closed piece (k,) at which the winding number of all others has the sign opposite to its volume."""
    for piece in range(len(closed)):
        if not closed[piece] or volume[piece] == 0.0:
            continue
        winding = 0.0
        point = corners[start[piece], 0]
        for other in range(len(closed)):
            # What lies inside a surface has a smaller box.
            if other == piece or not ((low[other] < low[piece]).all() and (high[other] > high[piece]).all()):
                continue
            for face in range(start[other], start[other + 1]):
                winding += _solid_angle(corners[face], point)
        found[piece] = winding * np.sign(volume[piece]) < -inside * 4 * np.pi


@jit
def _solid_angle(corners: np.ndarray, point: np.ndarray) -> float:
    """Solid angle of a triangle seen from a point, with its sign (Van Oosterom and Strackee 1983)."""
    a, b, c = corners[0] - point, corners[1] - point, corners[2] - point
    la, lb, lc = np.sqrt((a * a).sum()), np.sqrt((b * b).sum()), np.sqrt((c * c).sum())
    determinant = (
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return 2 * np.arctan2(determinant, la * lb * lc + (a * b).sum() * lc + (b * c).sum() * la + (c * a).sum() * lb)
