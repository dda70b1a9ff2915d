"""What a part that lies on a whole tells: points for the samples of either, and how far each can be trusted."""

from __future__ import annotations

import numpy as np
import scipy
import scipy.sparse as sp

from ...geometry.interpolation import interpolate_nearby
from ...geometry.nearest_neighbors import nearest_neighbors
from ...geometry.points import SurfacePoints, closest_points
from ...mesh.topology import boundary_edges
from ...registration.features import oriented_points
from ...registration.strain import edge_strain
from ...surface.surface import Surface
from .locate import REGISTRATION, PartPair, Placement

NEAR, SNAPPED = 0.15, 0.03
"""Over which a landmark has a say in how well distances agree, and how far its image may be from a known one."""

FLOOR = 0.01
SLOPES = {"distances": -0.83, "residual": -0.78, "cut": 0.80, "cost": -4.95, "curvature": -0.28, "stretch": -0.81}
OFFSET = -3.93
"""Logistic regression of being right on the logarithms of the evidence, over parts of animals and people; places on
what is missing count 21 times. The offset is lowered so that a chance of 0.5 here is one of 0.7 there."""

OPEN = 0.15
"""Length of the boundary of a surface that lacks something."""

MARGIN = 0.035
"""Distance from the cut below which no match is reported: what is sent there may as well lie beyond it."""

TORN = 0.3
"""How much distances around a place disagree, in the mean, above which it has been torn off what lies beside it."""

EVEN, ELSEWHERE = 0.05, 0.05
"""By how much a rival must be worse to count 1 / e, and the distance from which it sends a vertex elsewhere."""

ON_PART, ASTRAY = 0.02, 0.1
"""Distance of a point of the whole from the bent part, and along the surface, up to which it can belong to it."""


def cost_terms(pair: PartPair, place: Placement) -> dict[str, np.ndarray]:
    """What speaks against the place of each vertex of the part's proxy, or for it: how far the cut is; (P1,)."""
    found, part = place.registration, pair.part
    _, apart, snapped = pair.compared(pair.whole.nearest_proxy[found.image])
    weight = np.exp(-pair.paths1.lengths / NEAR - snapped[:, None] / SNAPPED) + 1e-12
    around, appearance_cost = (
        neighbour_means(part),
        np.abs(pair.curvatures1 - pair.curvatures2[found.image]).mean(axis=1),
    )
    return {
        "distances": (weight * apart).sum(axis=0) / weight.sum(axis=0),
        "residual": around @ found.residual,
        "curvature": around @ appearance_cost,
        "stretch": around @ (around @ edge_strain(part, pair.whole, found)),
        "cost": np.full(len(appearance_cost), place.cost),
        "cut": distance_to_boundary(part, part.mesh.vertices[part.proxy]) / np.sqrt(part.area),
    }


def neighbour_means(surface: Surface) -> sp.csr_matrix:
    """Takes values at the proxy to their means over each vertex's neighbours."""
    start, end = np.concatenate([surface.proxy_edges, surface.proxy_edges[:, ::-1]]).T
    size = len(surface.proxy)
    number = np.maximum(np.bincount(start, minlength=size), 1)
    return sp.csr_matrix((1 / number[start], (start, end)), shape=(size, size))


def distance_to_boundary(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Distances (q,) in space of points (q, 3) from the boundary of a surface that has one."""
    rim = surface.mesh.vertices[boundary_edges(surface.mesh.faces).ravel()]
    return np.asarray(scipy.spatial.cKDTree(rim).query(points)[0])


def match_probabilities(pair: PartPair, place: Placement) -> np.ndarray:
    """The chance (P1,) float64 in [0, 1] that the place of each vertex of the part's proxy is right."""
    found = cost_terms(pair, place)
    score = OFFSET + sum(slope * np.log(found[kind] + FLOOR) for kind, slope in SLOPES.items())
    inside = (found["cut"] >= MARGIN) & (found["distances"] <= TORN)
    if boundary_length(pair.whole) > OPEN:  # what it lacks in its turn is pressed against its rim
        inside &= distance_to_boundary(pair.whole, place.registration.positions) >= MARGIN * np.sqrt(pair.whole.area)
    return np.where(inside, support(place) / (1 + np.exp(-score)), 0.0)


def support(place: Placement) -> np.ndarray:
    """The share (P1,) of this place among all that are nearly as good, of those that agree with it at each vertex."""
    others = sum(np.exp(-worse / EVEN) * (apart > ELSEWHERE) for worse, apart in place.rivals)
    return np.asarray(1 / (1 + others + np.zeros(len(place.registration.image))))


def boundary_length(surface: Surface) -> float:
    """Length of the boundary per sqrt(area)."""
    ends = surface.mesh.vertices[boundary_edges(surface.mesh.faces)]
    return float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() / np.sqrt(surface.area))


def points_on_whole(pair: PartPair, place: Placement) -> tuple[SurfacePoints, np.ndarray]:
    """Points of the whole for the part's samples, and the chance of each."""
    mesh, scale, here, found = pair.whole.mesh, np.sqrt(pair.whole.area), pair.samples1, place.registration
    points = closest_points(mesh.vertices / scale, mesh.faces, found.positions[here] / scale, found.image[here])
    return points, match_probabilities(pair, place)[here]


def points_on_part(pair: PartPair, place: Placement) -> tuple[SurfacePoints, np.ndarray]:
    """Points of the part for the whole's samples, and the chance of each; 0 for those that are off the part."""
    mesh, found = pair.part.mesh, place.registration
    there, rest = (
        oriented_points(one.mesh.vertices / np.sqrt(one.area), one.mesh.faces, REGISTRATION.partial.normal)
        for one in (pair.whole, pair.part)
    )
    bent = np.hstack([found.positions / np.sqrt(pair.whole.area), there[found.image, 3:]])
    queries = there[pair.whole.samples]
    places = interpolate_nearby(bent, queries, rest[pair.part.proxy].T).T
    points = closest_points(rest[:, :3], mesh.faces, places[:, :3], nearest_neighbors(places, rest))
    node = scipy.spatial.cKDTree(bent).query(queries)[1]
    middles = bent[pair.part.proxy_edges].mean(axis=1)
    apart = scipy.spatial.cKDTree(np.concatenate([bent, middles])).query(queries)[0]
    # Along the surface too: what is missing may touch the part.
    astray = pair.paths2.lengths[np.arange(len(node)), pair.whole.nearest_proxy[found.image[node]]]
    return points, np.where((apart <= ON_PART) & (astray <= ASTRAY), match_probabilities(pair, place)[node], 0.0)
