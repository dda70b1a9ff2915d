"""Candidates that depend on no draw of triplets: the extremities of two shapes, matched in every likely way.

Beyond the paper. Between shapes of other proportions few triplets are right, and another seed may draw none of them.
Extremities, such as the ends of limbs, are so few that all ways to match them can be compared; three of them make a
triplet.
"""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np

from ..surface.surface import Surface
from ..voting.kernel import mutual_pairs
from ..voting.mobius import homogeneous
from ..voting.parameters import VotingParameters
from ..voting.votes import triplet_weights_of
from .parameters import ExtremityParameters


def extremities(surface: Surface, parameters: ExtremityParameters) -> np.ndarray:
    """Samples (t,) at the extremities of a surface, the farthest from the rest of it first."""
    distances, average = surface.normalized_distances, surface.average_distances
    farthest = np.where(distances < parameters.radius, average, 0.0).max(axis=1)
    samples = np.flatnonzero(average >= farthest)
    return samples[np.argsort(-average[samples], kind="stable")][: parameters.most]


def extremity_matchings(
    source: Surface, target: Surface, parameters: ExtremityParameters, softening: float
) -> list[np.ndarray]:
    """The likely ways to match extremities, the likeliest first: pairs of samples (q, 2) each, q > 2.

    Their cost is the mean absolute difference of the logarithms of their mutual distances. One extremity of the surface
    that has fewer may be left out, at a cost. The softening, per sqrt(area), is added before the logarithm.
    """
    ends1, ends2 = extremities(source, parameters), extremities(target, parameters)
    between1, between2 = source.normalized_distances, target.normalized_distances
    matchings: list[tuple[np.ndarray, np.ndarray]] = []
    costs: list[np.ndarray] = []
    most = min(len(ends1), len(ends2))
    for size in range(most, max(most - 2, 2), -1):
        i, j = np.triu_indices(size, 1)
        images = ends2[np.array(list(permutations(range(len(ends2)), size)))]
        there = between2[images[:, i], images[:, j]]
        for subset in combinations(ends1, size):
            chosen = np.array(subset)
            here = between1[chosen[i], chosen[j]]
            differences = np.abs(np.log((here + softening) / (there + softening))).mean(axis=1)
            costs.append(differences + parameters.omission_cost * (most - size))
            matchings.extend((chosen, image) for image in images)
    if not matchings:
        return []
    likely = np.argsort(np.concatenate(costs), kind="stable")[: parameters.likely]
    return [np.stack(matchings[k], axis=1) for k in likely]


def extremity_triplets(
    source: Surface, target: Surface, parameters: ExtremityParameters, softening: float, voting: VotingParameters
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The triplets of each likely way to match extremities.

    Returns
    -------
    list of tuple
        The target sample that each triplet pairs each source sample with, (i, N1) int, -1 for none, and the weights of
        the triplets (i,), as in :class:`.Votes`.
    """
    matchings = extremity_matchings(source, target, parameters, softening)
    if not matchings:
        return []
    triplets = [matching[np.array(list(combinations(range(len(matching)), 3)))] for matching in matchings]
    triplets1, triplets2 = (np.ascontiguousarray(np.concatenate(triplets)[:, :, side]) for side in (0, 1))
    pairs = mutual_pairs(homogeneous(source.positions), homogeneous(target.positions), triplets1, triplets2)
    weights = triplet_weights_of(source, target, triplets1, triplets2, voting)
    ends = np.cumsum([len(one) for one in triplets])[:-1]
    return list(zip(np.split(pairs, ends), np.split(weights, ends), strict=True))
