"""A piece laid onto another one of much the same shape: closest points with one similarity (Besl and McKay 1992)."""

from __future__ import annotations

import numpy as np
import scipy

from ...geometry.moving_least_squares import similarity
from ...geometry.normals import vertex_normals
from ...geometry.points import closest_points
from ...mesh import Mesh
from ...results.surface_map import SurfaceMap

ROUNDS = 40
"""Largest number of rounds of closest points; they end when no more pairs change."""

NEARER = 0.05
"""Weight of the distance from where a piece was carried, against the distance that is left between the two pieces."""


def laid_on(source: Mesh, target: Mesh, start: np.ndarray, normal: float) -> SurfaceMap:
    """The map that lays one piece onto another one, from where it has been carried.

    Parameters
    ----------
    source, target
        The two pieces.
    start
        (n1, 3) positions of the source's vertices near the target, from which the search begins.
    normal
        Weight of normals against positions per size of the target, when closest points are searched.

    Returns
    -------
    SurfaceMap
        The map: each vertex to the closest point of the other piece, once they lie on each other.
    """
    size = size_of(target.vertices)
    there, normals = target.vertices / size, vertex_normals(target.vertices / size, target.faces)
    rest = source.vertices / size_of(source.vertices)
    carried = start / size
    best, least = carried, np.inf
    # Carried as it is; and in the middle of the target, its principal axes along the target's: what was carried far
    # may be off by more than its size, and turned. Of two that fit, the one nearer to where it was carried is taken.
    for begin in (carried, *_along_axes(rest, there)):
        positions, error = _closest_copy(rest, source.faces, begin, there, normals, normal)
        error += NEARER * float(np.linalg.norm(positions - carried, axis=1).mean())
        if error < least:
            best, least = positions, error
    own_normals = vertex_normals(best, source.faces)
    first, second = np.hstack([best, normal * own_normals]), np.hstack([there, normal * normals])
    near, back = scipy.spatial.cKDTree(second).query(first)[1], scipy.spatial.cKDTree(first).query(second)[1]
    points = closest_points(there, target.faces, best, near)
    back_points = closest_points(best, source.faces, there, back)
    return SurfaceMap(source, target, points, back_points, np.ones(len(best), bool), np.ones(len(there), bool))


def laid_positions(source: Mesh, target: Mesh, start: np.ndarray, normal: float) -> np.ndarray:
    """Positions (n1, 3) of the source as a similar copy on the target, from where it has been carried."""
    size = size_of(target.vertices)
    there, normals = target.vertices / size, vertex_normals(target.vertices / size, target.faces)
    rest, carried = source.vertices / size_of(source.vertices), start / size
    begins = carried, carried - carried.mean(axis=0) + there.mean(axis=0)
    laid = [_closest_copy(rest, source.faces, begin, there, normals, normal) for begin in begins]
    return min(laid, key=lambda one: one[1])[0] * size


def _along_axes(rest: np.ndarray, there: np.ndarray) -> list[np.ndarray]:
    """The four turns of points (n, 3) without reflection that bring their principal axes to those of others (n2, 3)."""
    middle = there.mean(axis=0)
    here, axes = (np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2] for points in (rest, there))
    signs = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    found = []
    for first, second in signs:
        third = first * second * np.linalg.det(here) * np.linalg.det(axes)
        turn = here.T @ (np.array([first, second, third])[:, None] * axes)
        found.append((rest - rest.mean(axis=0)) @ turn + middle)
    return found


def size_of(points: np.ndarray) -> float:
    """The root mean square distance of points (n, 3) from their centre; never zero."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())) or 1.0


def _closest_copy(
    rest: np.ndarray, faces: np.ndarray, start: np.ndarray, there: np.ndarray, normals: np.ndarray, normal: float
) -> tuple[np.ndarray, float]:
    """Positions (n, 3) of a similar copy of points on others (n2, 3), and the mean distance that is left both ways."""
    positions = similarity(rest, start)
    tree, before = scipy.spatial.cKDTree(np.hstack([there, normal * normals])), None
    for _ in range(ROUNDS):
        here = np.hstack([positions, normal * vertex_normals(positions, faces)])
        near, back = tree.query(here)[1], scipy.spatial.cKDTree(here).query(tree.data)[1]
        pairs = np.concatenate([near, back])
        if before is not None and np.array_equal(pairs, before):
            break
        before = pairs
        # Both ways, or a copy would shrink to where all of it lies close.
        ends = np.concatenate([there[near], there])
        positions = similarity(np.concatenate([rest, rest[back]]), ends, apply_to=rest)
    forward, backward = (
        scipy.spatial.cKDTree(there).query(positions)[0],
        scipy.spatial.cKDTree(positions).query(there)[0],
    )
    return positions, float(forward.mean() + backward.mean()) / 2
