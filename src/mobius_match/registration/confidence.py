"""The confidence in a match: the probability that it lies within 5 % of the diameter of its true place.

Beyond the paper, whose confidence is a share of the votes. Four features of each vertex of the source's proxy say how
well its place on the target agrees with its surroundings; a logistic model of their logarithms gives the probability.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..geometry.interpolation import interpolate_nearby, inverse_distance_means, squared_distances
from ..mesh.measure import cross_products
from ..surface.surface import Surface
from .parameters import ConfidenceParameters, ConfidenceTerms
from .sparse import Registration
from .strain import edge_strain


def match_probabilities(
    source: Surface,
    target: Surface,
    registration: Registration,
    distances: np.ndarray,
    parameters: ConfidenceParameters,
) -> np.ndarray:
    """The probability (P1,) float64 in [0, 1] that the place of each vertex of the source's proxy is right.

    Parameters
    ----------
    source, target, registration
        The surfaces, and the source on the target.
    distances
        (N1, N2), as :func:`distances_to_images` gives them.
    parameters
        The constants of the model.
    """
    terms = confidence_terms(source, target, registration, distances, parameters)
    pairs = zip(_values(terms), _values(parameters.slopes), strict=True)
    score = parameters.offset + sum(slope * np.log(term + parameters.floor) for term, slope in pairs)
    return np.asarray(1 / (1 + np.exp(-score)))


def _values(terms: ConfidenceTerms[Any]) -> tuple[Any, ...]:
    return terms.distances, terms.residual, terms.strain, terms.stability


def confidence_terms(
    source: Surface,
    target: Surface,
    registration: Registration,
    distances: np.ndarray,
    parameters: ConfidenceParameters,
) -> ConfidenceTerms[np.ndarray]:
    """The features (P1,) of each vertex of the proxy; see :func:`match_probabilities`."""
    # Distances from the places to the target's samples, and from the source's samples to where those come from.
    here, there = _distances_to_origins(source, target, registration), distances / target.scale
    weight = np.exp(-np.minimum(here, there) / parameters.radius)
    disagreement = (weight * np.abs(here - there)).sum(axis=1) / weight.sum(axis=1)
    nearby = np.exp(-((source.proxy_geodesics / (parameters.radius / 2)) ** 2))
    nearby /= nearby.sum(axis=1, keepdims=True)
    images = target.mesh.vertices[registration.image]
    return ConfidenceTerms(
        distances=inverse_distance_means(source.proxy_distances.T, disagreement[None])[0],
        residual=nearby @ registration.residual,
        strain=nearby @ edge_strain(source, target, registration),
        stability=stability(target, images, parameters.radius),
    )


def stability(surface: Surface, places: np.ndarray, radius: float) -> np.ndarray:
    """How well the shape around places (p, 3) of a surface resists sliding: (p,), from 0 to 1/3.

    The least eigenvalue of the mean of n n^T over the normals n of the faces within a radius per sqrt(area), the
    translational part of slippage analysis (Gelfand and Guibas 2004). It is 0 where a copy can slide on the surface, as
    in a plane or along a cylinder, and 1/3 at the end of a finger.
    """
    vertices, faces = surface.mesh.vertices / surface.scale, surface.mesh.faces
    crosses = cross_products(vertices, faces)
    sizes = np.maximum(np.linalg.norm(crosses, axis=1, keepdims=True), np.finfo(float).tiny)
    of_faces = (crosses[:, :, None] * crosses[:, None] / sizes[:, None]).reshape(-1, 9)
    # A face counts at the vertices of the proxy that are nearest to its corners.
    corners, size = surface.nearest_proxy[faces].ravel(), len(surface.proxy)
    sums = np.stack([np.bincount(corners, np.repeat(entry, 3), size) for entry in of_faces.T], axis=1)
    near = squared_distances(places / surface.scale, vertices[surface.proxy]) <= radius**2
    means = (near.astype(float) @ sums).reshape(-1, 3, 3)
    traces = np.maximum(np.trace(means, axis1=1, axis2=2), np.finfo(float).tiny)
    return np.asarray(np.linalg.eigvalsh(means / traces[:, None, None])[:, 0])


def distances_to_images(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Geodesic distances (N1, N2) of the images of the source's samples from the target's samples, in its units."""
    vertices = target.mesh.vertices
    places = vertices[registration.image[np.searchsorted(source.proxy, source.samples)]]
    return interpolate_nearby(vertices[target.proxy], places, target.proxy_distances).T


def _distances_to_origins(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Distances (N1, N2) per sqrt(area) of the source's samples from the preimages of the target's samples."""
    images = target.mesh.vertices[registration.image]
    distances = interpolate_nearby(images, target.mesh.vertices[target.samples], source.proxy_distances)
    return distances / source.scale
