"""What speaks against a map between two surfaces, in numbers of one scale: 0 is perfect.

Beyond the paper. The votes see triplets; a map of the whole surface is judged by what they do not see: distances over
all pairs, the Laplacian, curvature.
"""

from __future__ import annotations

import numpy as np

from ..geometry.curvature import rank_correlation
from ..geometry.spectral import functional_map
from ..registration.register import Registration, strain
from ..surface.surface import Surface

COMPARED = 20
"""Number of eigenfunctions on which maps are compared with the Laplacian."""

WEIGHTS = {
    "distances": 5.0,
    "laplacian": 3.0,
    "mean curvature": 1.0,
    "gauss curvature": 3.0,
    "landmarks": 20.0,
}
"""What each kind of evidence counts; "landmarks" is how far known pairs are sent elsewhere, where there are any."""


def cost_terms(source: Surface, target: Surface, image: np.ndarray, step: int = 1) -> dict[str, float]:
    """Evidence against a map of the proxy, or of every so many-th point of it, to the target's; 0 is perfect."""
    some = source.proxy[::step]
    # A sample and its image are replaced by the nearest points that distances are known from.
    mine = source.proxy_distances[:, ::step] / np.sqrt(source.area)
    theirs = target.proxy_distances / np.sqrt(target.area)
    landing = theirs[:, image[mine.argmin(axis=1)]].argmin(axis=0)
    transfer = functional_map(
        source.eigenfunctions[some, :COMPARED], target.eigenfunctions[target.proxy[image], :COMPARED]
    )
    low, high = source.eigenvalues[: transfer.shape[0]], target.eigenvalues[: transfer.shape[1]]
    gauss, mean = (
        1 - rank_correlation(source.curvatures[row, some], target.curvatures[row, target.proxy[image]])
        for row in (0, 2)
    )
    return {
        "distances": float(np.abs(np.log((mine + 0.1) / (theirs[landing][:, image] + 0.1))).mean()),
        "laplacian": float(
            np.linalg.norm(transfer * high - low[:, None] * transfer) / np.linalg.norm(low[:, None] * transfer)
        ),
        "mean curvature": mean,
        "gauss curvature": gauss,
    }


def total_cost(cost_terms: dict[str, float]) -> float:
    """The weighted sum of evidence: how bad an explanation is."""
    return sum(WEIGHTS[kind] * value for kind, value in cost_terms.items())


def registration_cost(source: Surface, target: Surface, registration: Registration) -> float:
    """What speaks against the source bent in one way, to be compared with another: its strain, and what maps tell."""
    return strain(source, target, registration) + total_cost(
        cost_terms(source, target, target.nearest_proxy[registration.image])
    )
