"""Maps of a whole proxy: from a few matches of samples, or from a map that is given.

Beyond the paper. Distances from the matches give the first map, and spectral upsampling (Melzi et al. 2019) refines it;
unbalanced optimal transport in place of nearest points leaves no part of the target over.
"""

from __future__ import annotations

import numpy as np

from ..geometry.optimal_transport import Transport
from ..geometry.spectral import functional_map
from ..landmarks.constraints import LandmarkConstraints
from ..surface.surface import Surface
from .parameters import CoarseMapParameters


def coarse_map(
    source: Surface,
    target: Surface,
    matches: np.ndarray,
    parameters: CoarseMapParameters,
    constraints: LandmarkConstraints | None = None,
) -> np.ndarray:
    """A map of the whole proxy from matches of samples (q, 2) and from landmarks.

    Returns
    -------
    numpy.ndarray
        (P1, P2) float32, a transport plan: the fraction of each point of the source's proxy that goes to each point of
        the target's; rows sum to 1.
    """
    thinning = parameters.thinning
    plan = _plan_by_distances(source, target, matches, parameters, constraints, thinning)
    first, second = (surface.eigenfunctions[surface.proxy] for surface in (source, target))
    most = min(first.shape[1], second.shape[1])
    for count in (*range(2 * parameters.upsampling_step, most, parameters.upsampling_step), most):
        # The functional map of a plan sends each point to the mean of the places that its mass goes to.
        transfer = functional_map(first[::thinning, :count], plan @ second[::thinning, :count])
        step = 1 if count == most else thinning
        plan = _transport(source, target, first[:, :count] @ transfer, second[:, :count], parameters, step).plan
    return plan


def quick_image(
    source: Surface,
    target: Surface,
    matches: np.ndarray,
    parameters: CoarseMapParameters,
    constraints: LandmarkConstraints | None = None,
) -> np.ndarray:
    """About where :func:`coarse_map` sends every so many-th point of the source's proxy, in a tenth of the time.

    Returns
    -------
    numpy.ndarray
        (ceil(P1 / quick_thinning),) int64: points of the target's proxy.
    """
    step, count = parameters.quick_thinning, 2 * parameters.upsampling_step
    plan = _plan_by_distances(source, target, matches, parameters, constraints, step)
    first, second = (surface.eigenfunctions[surface.proxy, :count] for surface in (source, target))
    first = first @ functional_map(first[::step], plan @ second[::step])
    return _transport(source, target, first, second, parameters, step).plan.argmax(axis=1) * step


def _plan_by_distances(
    source: Surface,
    target: Surface,
    matches: np.ndarray,
    parameters: CoarseMapParameters,
    constraints: LandmarkConstraints | None,
    step: int,
) -> np.ndarray:
    """The plan between every so many-th point of the proxies by their distances from matches and landmarks."""
    features = []
    for side, surface in enumerate((source, target)):
        distances = surface.proxy_distances[matches[:, side]]
        if constraints is not None:
            distances = np.concatenate([distances, constraints.distances[side][:, surface.proxy]])
        features.append(np.exp(-distances.T[::step] / (parameters.match_radius * surface.scale)))
    return _between(features[0], features[1], parameters, step).plan


def _between(first: np.ndarray, second: np.ndarray, parameters: CoarseMapParameters, step: int) -> Transport:
    """Transport between features of every so many-th point of the proxies."""
    transport = parameters.transport
    return Transport(
        first,
        second,
        balance=transport.balance,
        sharpness=transport.sharpness,
        neighbor=transport.neighbor // step,
        iterations=transport.iterations,
    )


def _transport(
    source: Surface,
    target: Surface,
    first: np.ndarray,
    second: np.ndarray,
    parameters: CoarseMapParameters,
    step: int = 1,
) -> Transport:
    """Transport between every so many-th point of the proxies.

    Points are compared by aligned eigenfunctions (P1, k) and (P2, k), and by descriptors.
    """
    here, there = source.proxy[::step], target.proxy[::step]
    weight = _descriptor_weight(second, parameters)
    return _between(
        _with_descriptors(source, here, first[::step], weight),
        _with_descriptors(target, there, second[::step], weight),
        parameters,
        step,
    )


def _descriptor_weight(eigenfunctions: np.ndarray, parameters: CoarseMapParameters) -> float:
    """Weight of descriptors beside the target's eigenfunctions (P2, k), relative to the root mean square of these."""
    mean_square = np.einsum("ij,ij->", eigenfunctions, eigenfunctions) / len(eigenfunctions)
    return parameters.descriptor_weight * np.sqrt(mean_square)


def _with_descriptors(surface: Surface, vertices: np.ndarray, functions: np.ndarray, weight: float) -> np.ndarray:
    """Eigenfunctions (q, k) and weighted descriptors of vertices (q,)."""
    return np.hstack([functions, weight * surface.descriptors[vertices]])


def refined_targets(
    source: Surface, target: Surface, image: np.ndarray, vertices: np.ndarray, parameters: CoarseMapParameters
) -> np.ndarray:
    """Where a map of the proxy (P1,) to target vertices sends vertices of the source: target vertices (q,) int64."""
    first, second = _aligned_eigenfunctions(source, target, image)
    of_proxy, everywhere = second[target.proxy], np.arange(len(second))
    weight = _descriptor_weight(of_proxy, parameters)
    return _transport(source, target, first[source.proxy], of_proxy, parameters).images(
        _with_descriptors(source, vertices, first[vertices], weight),
        _with_descriptors(target, everywhere, second, weight),
    )


def balanced_targets(
    source: Surface, target: Surface, image: np.ndarray, parameters: CoarseMapParameters
) -> np.ndarray:
    """Where a map (P1,) sends the source's proxy among the target's, nearly surjectively: target vertices (P1,)."""
    return np.asarray(target.proxy[transport_plan(source, target, image, parameters).argmax(axis=1)])


def transport_plan(source: Surface, target: Surface, image: np.ndarray, parameters: CoarseMapParameters) -> np.ndarray:
    """The transport plan (P1, P2) between the proxies along a map of the source's to target vertices (P1,)."""
    first, second = _aligned_eigenfunctions(source, target, image)
    return _transport(source, target, first[source.proxy], second[target.proxy], parameters).plan


def _aligned_eigenfunctions(source: Surface, target: Surface, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenfunctions (n1, k) of the source, brought to the target by a map (P1,), and the target's (n2, k)."""
    transfer = functional_map(source.eigenfunctions[source.proxy], target.eigenfunctions[image])
    return source.eigenfunctions @ transfer, target.eigenfunctions
