"""The evidence for an alignment: how well the two surfaces agree once the source is registered along it.

Beyond the paper. Each term is bounded, 0 where nothing speaks against the alignment, and looks at both directions where
these differ. :mod:`.choice` makes a probability of them.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..geometry.rotations import rigid_residual
from ..geometry.spectral import functional_map
from ..registration.sparse import Registration
from ..registration.strain import edge_stretches
from ..surface.surface import Surface
from .cost import cost_terms
from .parameters import ChoiceParameters, CostParameters, Evidence


def evidence(
    source: Surface,
    target: Surface,
    registration: Registration,
    cost: CostParameters,
    parameters: ChoiceParameters,
) -> Evidence[float]:
    """The evidence for the alignment that a registration was made along.

    Parameters
    ----------
    source, target, registration
        The surfaces, and the source on the target.
    cost, parameters
        Constants of the terms that the cost has as well, and of the others.
    """
    here, there = registration.positions / target.scale, target.mesh.vertices[target.proxy] / target.scale
    # Places in the other surface's proxy of the images of the source's, and of the preimages of the target's.
    gaps, back = scipy.spatial.cKDTree(here).query(there)
    forth = target.nearest_proxy[registration.image]
    both = [cost_terms(source, target, forth, cost), cost_terms(target, source, back, cost)]
    correlations = [
        _correlation(source.descriptors[source.proxy], target.descriptors[target.proxy[forth]]),
        _correlation(target.descriptors[target.proxy], source.descriptors[source.proxy[back]]),
    ]
    round_trip, roughness = _carried_functions(source, target, forth, back, parameters.diffusion_time)
    start, end = source.proxy_edges.T
    traces = np.einsum("nij,nij->n", registration.rotations[start], registration.rotations[end])
    at_rest = source.mesh.vertices[source.proxy] / source.scale
    return Evidence(
        **{name: float(np.mean([one[name] for one in both])) for name in both[0]},
        descriptors=1 - float(np.mean(correlations)),
        stretch=float(np.tanh(np.abs(edge_stretches(source, target, registration))).mean()),
        turning=float(registration.normal_deviation.mean()),
        bending=float(np.arccos(np.clip((traces - 1) / 2, -1, 1)).mean() / np.pi),
        rigidity=float(np.sqrt(rigid_residual(at_rest, here))),
        round_trip=round_trip,
        roughness=roughness,
        residual=float(registration.residual.mean()),
        gap=float(gaps.mean()),
    )


def log_odds(terms: list[Evidence[float]], parameters: ChoiceParameters) -> np.ndarray:
    """The score (c,) of each alignment: the logarithm of the odds that it, and not none of them, is right."""
    return np.array([one.values() for one in terms]) @ parameters.weights.values() + parameters.offset


def _carried_functions(
    source: Surface, target: Surface, forth: np.ndarray, back: np.ndarray, time: float
) -> tuple[float, float]:
    """The terms ``round_trip`` and ``roughness`` of a map of the proxies, (P1,) and (P2,).

    A function with independent normal coefficients, diffused, has coefficients of standard deviations exp(-t lambda);
    so the expected square of what a linear map makes of it is a Frobenius norm, and nothing has to be drawn.
    """
    first, second = (one.eigenfunctions[one.proxy].astype(np.float64) for one in (source, target))
    heat1, heat2 = (np.exp(-time * one.eigenvalues) for one in (source, target))
    from_target, to_target = functional_map(first, second[forth]), functional_map(second, first[back])
    errors = [
        np.linalg.norm((from_target @ to_target - np.eye(len(heat1))) * heat1) / np.linalg.norm(heat1),
        np.linalg.norm((to_target @ from_target - np.eye(len(heat2))) * heat2) / np.linalg.norm(heat2),
    ]
    lost = [_unexplained(first, (second * heat2)[forth]), _unexplained(second, (first * heat1)[back])]
    return float(np.mean(errors)), float(np.mean(lost))


def _unexplained(basis: np.ndarray, functions: np.ndarray) -> float:
    """Share of the variance of functions (p, k) that a basis (p, l) does not explain."""
    rest = functions - basis @ functional_map(basis, functions)
    return float((rest**2).sum() / ((functions - functions.mean(axis=0)) ** 2).sum())


def _correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of two sets of rows (p, d) about zero; 0 where one of them vanishes."""
    sizes = np.sqrt((first**2).sum() * (second**2).sum())
    return float((first * second).sum() / sizes) if sizes else 0.0
