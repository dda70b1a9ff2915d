"""Candidates for two shapes in one pose: the rigid motions that lay one over the other.

Beyond the paper. Tools, bones, teeth and birds in flight hardly bend, and votes may see nothing but a near symmetry of
theirs. The principal axes of two such shapes coincide up to the order and the signs of the axes; from each of the 24
rotations that are left, the closest points are sought by turns with the best rotation (Besl and McKay 1992).
"""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import scipy

from ..geometry.normals import vertex_normals
from ..geometry.rotations import nearest_rotations
from ..surface.surface import Surface
from .parameters import PoseParameters


def rigid_images(source: Surface, target: Surface, parameters: PoseParameters) -> list[np.ndarray]:
    """Where the best rigid motions send the source's proxy: points of the target's proxy, (P1,) int64 each.

    They are ordered by the mean squared distance that is left, in space and between normals, and end in different
    rotations.
    """
    (first, normals1, axes1), (second, normals2, axes2) = (_centred(one) for one in (source, target))
    tree = scipy.spatial.cKDTree(np.hstack([second, parameters.normal * normals2]))
    few = slice(None, None, parameters.thinning)
    found: list[tuple[float, np.ndarray]] = []
    for turn in _axis_rotations():
        rotation = axes1.T @ turn @ axes2
        for _ in range(parameters.steps):
            moved = np.hstack([first[few] @ rotation, parameters.normal * (normals1[few] @ rotation)])
            nearest = tree.query(moved)[1]
            rotation = nearest_rotations((first[few].T @ second[nearest])[None])[0]
        moved = np.hstack([first[few] @ rotation, parameters.normal * (normals1[few] @ rotation)])
        found.append((float((tree.query(moved)[0] ** 2).mean()), rotation))
    found.sort(key=lambda one: one[0])
    kept = list[np.ndarray]()
    for _, rotation in found:
        # The trace of R^T S is 1 + 2 cos of the angle between two rotations.
        if len(kept) < parameters.tried and all(
            np.trace(rotation.T @ other) < 1 + 2 * np.cos(parameters.distinct) for other in kept
        ):
            kept.append(rotation)
    return [np.asarray(tree.query(np.hstack([first @ one, parameters.normal * (normals1 @ one)]))[1]) for one in kept]


def _centred(surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The proxy's points (P, 3) per sqrt(area) about their mean, their normals, and right-handed principal axes."""
    points = surface.mesh.vertices / surface.scale
    normals = vertex_normals(points, surface.mesh.faces)[surface.proxy]
    points = points[surface.proxy] - points[surface.proxy].mean(axis=0)
    axes = np.linalg.svd(points, full_matrices=False)[2]
    axes[2] *= np.sign(np.linalg.det(axes))
    return points, normals, axes


def _axis_rotations() -> list[np.ndarray]:
    """The 24 rotations (3, 3) that send axes of coordinates to axes of coordinates."""
    matrices = (
        np.diag(signs).astype(float)[list(order)]
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
    )
    return [one for one in matrices if np.linalg.det(one) > 0]
