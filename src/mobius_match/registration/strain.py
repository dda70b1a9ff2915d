"""How much a registration strains the source: what tells a right alignment from a wrong one that fits as closely."""

from __future__ import annotations

import numpy as np

from ..surface.surface import Surface
from .parameters import RegistrationParameters
from .sparse import Registration

NO_LENGTH = 1e-6
"""Added to lengths per sqrt(area), so that they have a logarithm."""


def edge_stretches(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Logarithms (E,) of how many times longer the edges of the proxy have become, both surfaces having area 1."""
    start, end = source.proxy_edges.T
    rest, deformed = source.mesh.vertices[source.proxy], registration.positions
    before, after = (np.linalg.norm(points[start] - points[end], axis=1) for points in (rest, deformed))
    return np.asarray(np.log((after / target.scale + NO_LENGTH) / (before / source.scale + NO_LENGTH)))


def mean_stretch(source: Surface, target: Surface, registration: Registration) -> float:
    """Mean absolute logarithm of the stretches of the proxy's edges."""
    return float(np.abs(edge_stretches(source, target, registration)).mean())


def edge_strain(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Mean absolute logarithm of the stretches of the edges at each vertex of the proxy, (P1,)."""
    stretches = np.abs(edge_stretches(source, target, registration))
    number = np.maximum(np.bincount(source.proxy_edges.ravel(), minlength=len(source.proxy)), 1)
    sums = [np.bincount(ends, stretches, len(source.proxy)) for ends in source.proxy_edges.T]
    return np.asarray(sum(sums) / number)


def strain(source: Surface, target: Surface, registration: Registration, parameters: RegistrationParameters) -> float:
    """The strain of a registration, to be compared with that of another one of the same surfaces.

    A weighted sum of the logarithms of the mean stretch and of the mean normal deviation.
    """
    terms = mean_stretch(source, target, registration), float(registration.normal_deviation.mean())
    return sum(
        weight * float(np.log(term + parameters.strain_floor))
        for weight, term in zip(parameters.strain_weights, terms, strict=True)
    )
