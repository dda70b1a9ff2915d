"""The evidence for an alignment: how well the two surfaces agree once the source is registered along it.

Beyond the paper. Each term is bounded, 0 where nothing speaks against the alignment, and looks at both directions where
these differ. :mod:`.selection` makes probabilities of them.
"""

from __future__ import annotations

import numpy as np

from ..geometry.curvature import rank_correlation
from ..geometry.nearest_neighbors import nearest_neighbors
from ..geometry.rotations import rigid_residual
from ..registration.sparse import Registration
from ..registration.strain import edge_stretches
from ..surface.surface import Surface
from .parameters import ChoiceParameters, Evidence


def evidence(source: Surface, target: Surface, registration: Registration) -> Evidence[float]:
    """The evidence for the alignment that a registration of the source to the target was made along."""
    here, there = registration.positions / target.scale, target.mesh.vertices[target.proxy] / target.scale
    back = nearest_neighbors(there, here)
    # Vertices of both surfaces that correspond: the source's with their images, and the target's with their preimages.
    forth = source.proxy, registration.image
    pairs = (forth, (source.proxy[back], target.proxy))
    mean, gauss = (
        np.mean([1 - rank_correlation(source.curvatures[row, i], target.curvatures[row, j]) for i, j in pairs])
        for row in (2, 0)
    )
    start, end = source.proxy_edges.T
    traces = np.einsum("nij,nij->n", registration.rotations[start], registration.rotations[end])
    at_rest = source.mesh.vertices[source.proxy] / source.scale
    return Evidence(
        mean_curvature=float(mean),
        gauss_curvature=float(gauss),
        stretch=float(np.tanh(np.abs(edge_stretches(source, target, registration))).mean()),
        turning=float(registration.normal_deviation.mean()),
        bending=float(np.arccos(np.clip((traces - 1) / 2, -1, 1)).mean() / np.pi),
        rigidity=float(np.sqrt(rigid_residual(at_rest, here))),
        residual=float(registration.residual.mean()),
        gap=float(np.linalg.norm(there - here[back], axis=1).mean()),
    )


def log_odds(terms: list[Evidence[float]], parameters: ChoiceParameters) -> np.ndarray:
    """The score (c,) of each alignment: the logarithm of the odds that it, and not none of them, is right."""
    return np.array([one.values() for one in terms]) @ parameters.weights.values() + parameters.offset
