"""A map of a whole surface from a few matches, or from a rough map: where every point of the source goes.

Beyond the paper. Distances from the matches begin it, and spectral upsampling (Melzi et al. 2019) refines it; transport
in place of nearest points leaves no part of the target over.
"""

from __future__ import annotations

import numpy as np

from ..geometry.optimal_transport import Transport
from ..geometry.spectral import functional_map
from ..landmarks.constraints import LandmarkConstraints
from ..surface.surface import Surface

NEIGHBOR = 10
"""See :class:`Transport`; divided by the step where only every so many-th point is used."""

FEATURE_SCALE = 0.3
"""Distance per sqrt(area) over which a match has a say in the first map."""

UPSAMPLING = (20, 30, 40, 50)
"""Numbers of eigenfunctions from one refinement of the map to the next."""

COARSE = 2
"""All maps but the last are between every so many-th point of the proxies."""

ROUGH = 4
"""The same where many maps are to be compared."""

DESCRIPTORS = 0.4
"""How much the descriptors of points count against their eigenfunctions, by root mean square."""


def coarse_map(
    source: Surface, target: Surface, matches: np.ndarray, constraints: LandmarkConstraints | None = None
) -> np.ndarray:
    """A map of the whole proxy from matches of samples (q, 2) and hints.

    Returns
    -------
    numpy.ndarray
        (P1, P2) float32: which part of each point of the source's proxy goes where in the target's; rows sum to 1.
    """
    plan = _begun(source, target, matches, constraints, COARSE)
    first, second = (surface.eigenfunctions[surface.proxy] for surface in (source, target))
    for count in UPSAMPLING:
        # Each point is sent to the mean of the places that its mass goes to.
        transfer = functional_map(first[::COARSE, :count], plan @ second[::COARSE, :count])
        step = 1 if count == UPSAMPLING[-1] else COARSE
        plan = _transport(source, target, first[:, :count] @ transfer, second[:, :count], step).plan
    return plan


def quick_image(
    source: Surface, target: Surface, matches: np.ndarray, constraints: LandmarkConstraints | None = None
) -> np.ndarray:
    """Where :func:`coarse_map` sends every :data:`ROUGH`-th point of the source's proxy, about, in a tenth of the time.

    Returns
    -------
    numpy.ndarray
        (P1 / ROUGH,) int64: points of the target's proxy.
    """
    plan, count = _begun(source, target, matches, constraints, ROUGH), UPSAMPLING[0]
    first, second = (surface.eigenfunctions[surface.proxy, :count] for surface in (source, target))
    first = first @ functional_map(first[::ROUGH], plan @ second[::ROUGH])
    return _transport(source, target, first, second, ROUGH).plan.argmax(axis=1) * ROUGH


def _begun(
    source: Surface, target: Surface, matches: np.ndarray, constraints: LandmarkConstraints | None, step: int
) -> np.ndarray:
    """The plan between every so many-th point of the proxies that distances from matches and hints tell."""
    features = []
    for side, surface in enumerate((source, target)):
        apart = surface.proxy_distances[matches[:, side]]
        if constraints is not None:
            apart = np.concatenate([apart, constraints.distances[side][:, surface.proxy]])
        features.append(np.exp(-apart.T[::step] / (FEATURE_SCALE * np.sqrt(surface.area))))
    return Transport(features[0], features[1], neighbor=NEIGHBOR // step).plan


def _transport(source: Surface, target: Surface, first: np.ndarray, second: np.ndarray, step: int = 1) -> Transport:
    """Between the proxies, or every so many-th of their points, by eigenfunctions and descriptors.

    The eigenfunctions, (P1, k) and (P2, k), have been brought together.
    """
    here, there = source.proxy[::step], target.proxy[::step]
    return Transport(
        _described(source, here, first[::step], second),
        _described(target, there, second[::step], second),
        neighbor=NEIGHBOR // step,
    )


def _described(surface: Surface, vertices: np.ndarray, functions: np.ndarray, of_proxy: np.ndarray) -> np.ndarray:
    """Eigenfunctions (q, k) and descriptors of vertices (q,), at a ratio that the target's proxy (P2, k) tells."""
    scale = DESCRIPTORS * np.sqrt(np.einsum("ij,ij->", of_proxy, of_proxy) / len(of_proxy))
    return np.hstack([functions, scale * surface.descriptors[vertices]])


def refined_targets(source: Surface, target: Surface, image: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Where a map of the proxy (P1,) to target vertices sends vertices of the source: target vertices (q,) int64."""
    first, second = _brought_together(source, target, image)
    of_proxy, everywhere = second[target.proxy], np.arange(len(second))
    return _transport(source, target, first[source.proxy], of_proxy).images(
        _described(source, vertices, first[vertices], of_proxy), _described(target, everywhere, second, of_proxy)
    )


def balanced_targets(source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
    """The same for the source's proxy, (P1,), to points of the target's proxy alone, of which nothing is left over."""
    return np.asarray(target.proxy[transport_plan(source, target, image).argmax(axis=1)])


def transport_plan(source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
    """Which part of each point of the source's proxy goes where in the target's, (P1, P2), by a map (P1,) as above."""
    first, second = _brought_together(source, target, image)
    return _transport(source, target, first[source.proxy], second[target.proxy]).plan


def _brought_together(source: Surface, target: Surface, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenfunctions (n1, k) of the source, as a map (P1,) sees them on the target, and the target's (n2, k)."""
    transfer = functional_map(source.eigenfunctions[source.proxy], target.eigenfunctions[image])
    return source.eigenfunctions @ transfer, target.eigenfunctions
