"""Matches that a placement of a part gives: points for the samples of either surface, and their probabilities."""

from __future__ import annotations

import numpy as np
import scipy
import scipy.sparse as sp

from ...geometry.interpolation import interpolate_nearby
from ...geometry.nearest_neighbors import nearest_neighbors
from ...geometry.points import SurfacePoints, closest_points
from ...registration.features import oriented_points
from ...registration.strain import edge_strain
from ...surface.surface import Surface
from .coverage import may_be_part
from .locate import Placement
from .pair import PartPair
from .parameters import PartialParameters


def distance_to_boundary(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Distances (q,) in space, per the surface's scale, of points (q, 3) from its boundary, which must exist."""
    boundary = surface.mesh.vertices[surface.open_edges.ravel()]
    return np.asarray(scipy.spatial.cKDTree(boundary).query(points)[0] / surface.scale)


def features(pair: PartPair, placement: Placement) -> dict[str, np.ndarray]:
    """What the probability of each vertex of the part's proxy is a function of, (P1,) each."""
    registration, part = placement.registration, pair.part
    mean = _neighbour_means(part)
    return {
        "distances": pair.weighted_errors(pair.whole.nearest_proxy[registration.image], axis=0),
        "residual": mean @ registration.residual,
        "boundary": distance_to_boundary(part, part.mesh.vertices[part.proxy]),
        "stretch": mean @ (mean @ edge_strain(part, pair.whole, registration)),
        "cost": np.full(len(registration.image), placement.cost),
    }


def _neighbour_means(surface: Surface) -> sp.csr_matrix:
    """The matrix that replaces each value at the proxy by the mean over its neighbours."""
    start, end = np.concatenate([surface.proxy_edges, surface.proxy_edges[:, ::-1]]).T
    size = len(surface.proxy)
    number = np.maximum(np.bincount(start, minlength=size), 1)
    return sp.csr_matrix((1 / number[start], (start, end)), shape=(size, size))


def probability(of: dict[str, np.ndarray], constants: PartialParameters, floor: float) -> np.ndarray:
    """Logistic function (q,) of the logarithms of :func:`features`, to which the floor is added before."""
    slopes = {
        "distances": constants.distance_slope,
        "residual": constants.residual_slope,
        "boundary": constants.boundary_slope,
        "stretch": constants.stretch_slope,
        "cost": constants.cost_slope,
    }
    score = constants.offset + sum(slope * np.log(of[kind] + floor) for kind, slope in slopes.items())
    return np.asarray(1 / (1 + np.exp(-score)))


def match_probabilities(pair: PartPair, placement: Placement) -> np.ndarray:
    """The probability (P1,) that the image of each vertex of the part's proxy is right; 0 near a cut."""
    found, constants = features(pair, placement), pair.parameters
    inside = found["boundary"] >= constants.boundary_margin
    if may_be_part(pair.whole, constants):  # what the whole lacks is pressed against its boundary
        positions = placement.registration.positions
        inside &= distance_to_boundary(pair.whole, positions) >= constants.boundary_margin
    likely = probability(found, constants, pair.registration.confidence.floor)
    return np.where(inside, support(placement, constants) * likely, 0.0)


def support(placement: Placement, constants: PartialParameters) -> np.ndarray:
    """Share (P1,), among all placements weighted by exp(-cost), of those with the same image of a vertex."""
    others = sum(
        np.exp(-margin / constants.close_margin) * (distances > constants.distinct)
        for margin, distances in placement.rivals
    )
    return np.asarray(1 / (1 + others + np.zeros(len(placement.registration.image))))


def points_on_whole(pair: PartPair, placement: Placement) -> tuple[SurfacePoints, np.ndarray]:
    """Points of the whole for the part's samples, and the probability of each."""
    mesh, scale, samples, registration = pair.whole.mesh, pair.whole.scale, pair.samples1, placement.registration
    positions = registration.positions[samples] / scale
    points = closest_points(mesh.vertices / scale, mesh.faces, positions, registration.image[samples])
    return points, match_probabilities(pair, placement)[samples]


def points_on_part(pair: PartPair, placement: Placement) -> tuple[SurfacePoints, np.ndarray]:
    """Points of the part for the whole's samples, and the probability of each; 0 for those beyond the part."""
    faces, (deformed, queries) = pair.part.mesh.faces, _deformed_and_samples(pair, placement)
    rest = oriented_points(pair.part.mesh.vertices / pair.part.scale, faces, pair.registration.partial.normal)
    sources = interpolate_nearby(deformed, queries, rest[pair.part.proxy].T).T
    points = closest_points(rest[:, :3], faces, sources[:, :3], nearest_neighbors(sources, rest))
    vertex, covered = covered_by_part(pair, placement)
    return points, np.where(covered, match_probabilities(pair, placement)[vertex], 0.0)


def covered_by_part(pair: PartPair, placement: Placement) -> tuple[np.ndarray, np.ndarray]:
    """The part's vertex (N2,) of the proxy nearest to each sample of the whole, and whether the part covers it.

    It does if the part lies close in space, and that vertex along the surface, too: what is missing may touch the part.
    """
    constants, (deformed, queries) = pair.parameters, _deformed_and_samples(pair, placement)
    vertex = scipy.spatial.cKDTree(deformed).query(queries)[1]
    middles = deformed[pair.part.proxy_edges].mean(axis=1)
    in_space = scipy.spatial.cKDTree(np.concatenate([deformed, middles])).query(queries)[0]
    image = pair.whole.nearest_proxy[placement.registration.image[vertex]]
    along_surface = pair.paths2.lengths[np.arange(len(vertex)), image]
    return vertex, (in_space <= constants.boundary_margin) & (along_surface <= constants.distinct)


def _deformed_and_samples(pair: PartPair, placement: Placement) -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals (P1, 6) of the deformed proxy of the part, and (N2, 6) of the whole's samples."""
    registration, scale = placement.registration, pair.whole.scale
    whole = oriented_points(pair.whole.mesh.vertices / scale, pair.whole.mesh.faces, pair.registration.partial.normal)
    deformed = np.hstack([registration.positions / scale, whole[registration.image, 3:]])
    return deformed, whole[pair.whole.samples]
