"""How far a match can be trusted: the chance that it lies within 5 % of the diameter of its true place.

Beyond the paper, whose confidence is a share of the votes. Each vertex of the source's proxy is asked how well its
place on the target agrees with all that is known around it; four answers together give the chance.
"""

from __future__ import annotations

import numpy as np

from ..geometry.interpolation import interpolate_nearby, inverse_distance_means, squared_distances
from ..mesh.measure import cross_products
from ..surface.surface import Surface
from .register import Registration, edge_stretches

NEAR = 0.15
"""Distance per sqrt(area) over which a sample has a say in how well the distances around another agree."""

BESIDE = 0.06
"""Distance per sqrt(area) at which the misfit and the stretch around a vertex count 1 / e."""

AROUND = 0.12
"""Distance per sqrt(area) up to which the surface around a place tells how firmly it is held there."""


FLOORS = {"distances": 0.01, "residual": 0.01, "stretch": 0.02, "stability": 0.02}
"""What each kind of evidence is at least, in the units it is measured in, so that its logarithm tells little near 0."""

SLOPES = {"distances": -0.60, "residual": -2.54, "stretch": -1.19, "stability": 1.14}
OFFSET = -8.5
"""A logistic function of the logarithms of the evidence, over animals and people in many poses: the ratio of the slopes
is amid those that rank first what is within 3 % of the diameter, their size and the offset are for 5 %."""


def match_probabilities(
    source: Surface, target: Surface, registration: Registration, distances: np.ndarray
) -> np.ndarray:
    """The chance (P1,) float64 in [0, 1] that the place of each vertex of the source's proxy is right.

    Parameters
    ----------
    source, target, registration
        The surfaces, and the source on the target.
    distances
        (N1, N2), as :func:`distances_to_images` gives them.
    """
    found = confidence_features(source, target, registration, distances)
    score = OFFSET + sum(slope * np.log(found[kind] + FLOORS[kind]) for kind, slope in SLOPES.items())
    return np.asarray(1 / (1 + np.exp(-score)))


def confidence_features(
    source: Surface, target: Surface, registration: Registration, distances: np.ndarray
) -> dict[str, np.ndarray]:
    """The features (P1,) of each vertex of the proxy that :func:`match_probabilities` is a function of."""
    # Distances from the places to the target's samples, and from the source's samples to where those come from.
    here, there = _distances_to_origins(source, target, registration), distances / np.sqrt(target.area)
    weight = np.exp(-np.minimum(here, there) / NEAR)
    disagreement = (weight * np.abs(here - there)).sum(axis=1) / weight.sum(axis=1)
    beside = np.exp(-((source.proxy_geodesics / BESIDE) ** 2))
    beside /= beside.sum(axis=1, keepdims=True)
    return {
        "distances": inverse_distance_means(source.proxy_distances.T, disagreement[None])[0],
        "residual": beside @ registration.residual,
        "stretch": beside @ edge_strain(source, target, registration),
        "stability": stability(target, target.mesh.vertices[registration.image]),
    }


def stability(surface: Surface, places: np.ndarray) -> np.ndarray:
    """How firmly the shape around places (p, 3) of a surface holds a copy of it: (p,), from 0 to 1/3.

    The least eigenvalue of the mean of n n', n being the normals of the faces around. It is 0 where a copy could slide
    without changing the picture, in a plane or along a cylinder, and 1/3 at the end of a finger.
    """
    vertices, faces = surface.mesh.vertices / np.sqrt(surface.area), surface.mesh.faces
    crosses = cross_products(vertices, faces)
    sizes = np.maximum(np.linalg.norm(crosses, axis=1, keepdims=True), np.finfo(float).tiny)
    of_faces = (crosses[:, :, None] * crosses[:, None] / sizes[:, None]).reshape(-1, 9)
    # Each face stands at the vertices of the proxy that its corners are nearest to: as many, but no more than these.
    nearest_proxy, size = surface.nearest_proxy[faces].ravel(), len(surface.proxy)
    sums = np.stack([np.bincount(nearest_proxy, np.repeat(entry, 3), size) for entry in of_faces.T], axis=1)
    near = (squared_distances(places / np.sqrt(surface.area), vertices[surface.proxy]) <= AROUND**2).astype(float)
    means = (near @ sums).reshape(-1, 3, 3)
    traces = np.maximum(np.trace(means, axis1=1, axis2=2), np.finfo(float).tiny)
    return np.asarray(np.linalg.eigvalsh(means / traces[:, None, None])[:, 0])


def edge_strain(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """How much the edges at each vertex of the proxy are stretched or pressed, (P1,): mean logarithms."""
    stretches = np.abs(edge_stretches(source, target, registration))
    number = np.maximum(np.bincount(source.proxy_edges.ravel(), minlength=len(source.proxy)), 1)
    sums = [np.bincount(ends, stretches, len(source.proxy)) for ends in source.proxy_edges.T]
    return np.asarray(sum(sums) / number)


def distances_to_images(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Geodesic distances (N1, N2) of the places of the source's samples from the target's samples, target's units."""
    vertices = target.mesh.vertices
    places = vertices[registration.image[np.searchsorted(source.proxy, source.samples)]]
    return interpolate_nearby(vertices[target.proxy], places, target.proxy_distances).T


def _distances_to_origins(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Distances (N1, N2) per sqrt(area) of the source's samples from where the target's samples come from."""
    images = target.mesh.vertices[registration.image]
    found = interpolate_nearby(images, target.mesh.vertices[target.samples], source.proxy_distances)
    return found / np.sqrt(source.area)
