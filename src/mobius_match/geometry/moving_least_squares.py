"""Points beside a surface carried along with it: moving least squares with similarities (Schaefer et al. 2006).

Each point has a similarity transformation of its own: the one that takes control points to their images best, where a
control point counts the more the nearer it is. A point next to the surface moves as its surroundings do, a distant one
as the surface does on the whole; there is no radius to choose.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .rotations import nearest_rotations

LEAST_DISTANCE = 1e-4
"""Added (as a square) to squared distances, in units of half the extent of the control points: a point that is nearer
to a control point moves as that."""


def carried(
    points: np.ndarray, controls: np.ndarray, images: np.ndarray, anchors: np.ndarray, anchor_images: np.ndarray
) -> np.ndarray:
    """Positions (q, 3) of points after a deformation that is known at control points.

    The position of a point p is T(p), where T is the similarity (rotation, scale and translation, no reflection) that
    minimises sum_i w_i |T(c_i) - c'_i|^2 over the control points c_i and their images c'_i, with
    w_i = 1 / (|p - c_i|^2 + LEAST_DISTANCE^2)^2.

    Parameters
    ----------
    points
        (q, 3) positions before.
    controls, images
        (k, 3) control points, and where they end.
    anchors, anchor_images
        (q, 3) one more control point for each point, and where it ends.
    """
    low, high = controls.min(axis=0), controls.max(axis=0)
    centre, scale = (low + high) / 2, float((high - low).max() / 2) or 1.0
    centre2, scale2 = images.mean(axis=0), float(np.ptp(images, axis=0).max() / 2) or 1.0
    here, own, fixed = ((one - centre) / scale for one in (points, anchors, controls))
    own_images, fixed_images = ((one - centre2) / scale2 for one in (anchor_images, images))
    means, image_means = np.empty((len(here), 3)), np.empty((len(here), 3))
    covariances, variances = np.empty((len(here), 3, 3)), np.empty(len(here))
    _moments(here, fixed, fixed_images, own, own_images, LEAST_DISTANCE, means, image_means, covariances, variances)
    rotations = nearest_rotations(covariances)
    stretch = np.einsum("qij,qij->q", rotations, covariances) / np.maximum(variances, np.finfo(float).tiny)
    turned = np.einsum("qi,qij->qj", here - means, rotations)
    return (stretch[:, None] * turned + image_means) * scale2 + centre2


def similarity(points: np.ndarray, images: np.ndarray, apply_to: np.ndarray | None = None) -> np.ndarray:
    """Points moved by the similarity without reflection that brings points (q, 3) nearest to their images (q, 3).

    Parameters
    ----------
    points, images
        (q, 3) positions before and after.
    apply_to
        The points that are moved; by default the given ones.
    """
    middle, end = points.mean(axis=0), images - images.mean(axis=0)
    start = points - middle
    covariance = start.T @ end
    rotation = nearest_rotations(covariance[None])[0]
    stretch = (rotation * covariance).sum() / max((start * start).sum(), np.finfo(float).tiny)
    moved = start if apply_to is None else apply_to - middle
    return stretch * moved @ rotation + images.mean(axis=0)


@jit
def _moments(
    points: np.ndarray,
    controls: np.ndarray,
    images: np.ndarray,
    own: np.ndarray,
    own_images: np.ndarray,
    least: float,
    means: np.ndarray,
    image_means: np.ndarray,
    covariances: np.ndarray,
    variances: np.ndarray,
) -> None:
    """Weighted means of the control points and of their images, their covariance, and the variance of the former."""
    k = len(controls)
    weights = np.empty(k + 1)
    for i in range(len(points)):
        total = 0.0
        mean, image_mean = np.zeros(3), np.zeros(3)
        for j in range(k + 1):
            control = controls[j] if j < k else own[i]
            image = images[j] if j < k else own_images[i]
            square = least * least
            for axis in range(3):
                square += (points[i, axis] - control[axis]) ** 2
            weights[j] = 1.0 / (square * square)
            total += weights[j]
            for axis in range(3):
                mean[axis] += weights[j] * control[axis]
                image_mean[axis] += weights[j] * image[axis]
        mean /= total
        image_mean /= total
        variance = 0.0
        covariance = np.zeros((3, 3))
        for j in range(k + 1):
            control = controls[j] if j < k else own[i]
            image = images[j] if j < k else own_images[i]
            for axis in range(3):
                along = weights[j] * (control[axis] - mean[axis])
                variance += along * (control[axis] - mean[axis])
                for other in range(3):
                    covariance[axis, other] += along * (image[other] - image_mean[other])
        means[i], image_means[i], covariances[i], variances[i] = mean, image_mean, covariance, variance
