"""How much a registration stretches the source."""

from __future__ import annotations

import numpy as np

from ..surface.surface import Surface
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
