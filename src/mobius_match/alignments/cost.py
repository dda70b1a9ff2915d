"""The cost of a map between two surfaces: a weighted sum of terms that are 0 for a perfect one.

Beyond the paper. The votes see triplets; a map of the whole surface is judged by what they do not see: distances over
all pairs, the Laplacian, curvature.
"""

from __future__ import annotations

import numpy as np

from ..geometry.curvature import rank_correlation
from ..geometry.spectral import functional_map
from ..registration.sparse import Registration
from ..surface.surface import Surface
from .parameters import CostParameters, CostWeights


def cost_terms(
    source: Surface, target: Surface, image: np.ndarray, parameters: CostParameters, step: int = 1
) -> dict[str, float]:
    """Terms of the cost of a map of the proxy, or of every so many-th point of it, to points of the target's proxy.

    Their names are the fields of :class:`.CostWeights`.
    """
    points, images = source.proxy[::step], target.proxy[image]
    # Distances are known from samples only: a sample stands for the point nearest to it, another one for its image.
    here = source.proxy_distances[:, ::step] / source.scale
    there = target.proxy_distances / target.scale
    sample_images = there[:, image[here.argmin(axis=1)]].argmin(axis=0)
    ratios = np.log((here + parameters.softening) / (there[sample_images][:, image] + parameters.softening))
    count = parameters.eigenfunctions
    transfer = functional_map(source.eigenfunctions[points, :count], target.eigenfunctions[images, :count])
    low, high = source.eigenvalues[: transfer.shape[0]], target.eigenvalues[: transfer.shape[1]]
    commutator = np.linalg.norm(transfer * high - low[:, None] * transfer)
    gauss, mean = (
        1 - rank_correlation(source.curvatures[row, points], target.curvatures[row, images]) for row in (0, 2)
    )
    return {
        "distances": float(np.abs(ratios).mean()),
        "laplacian": float(commutator / np.linalg.norm(low[:, None] * transfer)),
        "mean_curvature": mean,
        "gauss_curvature": gauss,
    }


def total_cost(terms: dict[str, float], weights: CostWeights) -> float:
    """The weighted sum of the terms."""
    return sum(getattr(weights, name) * value for name, value in terms.items())


def registered_map_cost(
    source: Surface, target: Surface, registration: Registration, parameters: CostParameters
) -> float:
    """The cost of the map that a registration ends with."""
    terms = cost_terms(source, target, target.nearest_proxy[registration.image], parameters)
    return total_cost(terms, parameters.weights)
