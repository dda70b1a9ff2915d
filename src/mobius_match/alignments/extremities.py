"""Explanations that do not hang on what was drawn: the ends of limbs of two shapes, matched in every likely way.

Beyond the paper. Between shapes of other proportions few triplets tell the truth, and another seed may draw none of
them. The ends of limbs are few, so that all ways to match them can be looked at; three of them make a triplet.
"""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np

from ..surface.surface import Surface
from ..voting.kernel import mutual_pairs
from ..voting.mobius import homogeneous
from ..voting.votes import triplet_weights_of

REACH = 0.25
"""A tip is farther from the rest of the surface than all samples within this distance, per sqrt(area)."""

MOST, LIKELY = 6, 120
"""How many tips of a surface, and how many ways to match them, are looked at."""

SOFT, LEFT_OUT = 0.1, 0.05
"""Added to distances per sqrt(area) before they are compared, and what it costs to leave a tip out."""


def extremities(surface: Surface) -> np.ndarray:
    """Samples (t,) at the ends of limbs, the farthest from the rest first."""
    distances, central = surface.normalized_distances, surface.average_distances
    farthest = np.where(distances < REACH, central, 0.0).max(axis=1)
    found = np.flatnonzero(central >= farthest)
    return found[np.argsort(-central[found], kind="stable")][:MOST]


def extremity_matchings(source: Surface, target: Surface) -> list[np.ndarray]:
    """The likely ways to match tips, the likeliest first: pairs of samples (q, 2) each, q > 2.

    Mutual distances tell: the mean difference of their logarithms. One tip of the surface that has fewer may be left
    out.
    """
    ends1, ends2 = extremities(source), extremities(target)
    between1, between2 = source.normalized_distances, target.normalized_distances
    ways: list[tuple[np.ndarray, np.ndarray]] = []
    costs: list[np.ndarray] = []
    most = min(len(ends1), len(ends2))
    for size in range(most, max(most - 2, 2), -1):
        i, j = np.triu_indices(size, 1)
        images = ends2[np.array(list(permutations(range(len(ends2)), size)))]
        there = between2[images[:, i], images[:, j]]
        for chosen in combinations(ends1, size):
            some = np.array(chosen)
            here = between1[some[i], some[j]]
            differences = np.abs(np.log((here + SOFT) / (there + SOFT))).mean(axis=1)
            costs.append(differences + LEFT_OUT * (most - size))
            ways.extend((some, image) for image in images)
    if not ways:
        return []
    likely = np.argsort(np.concatenate(costs), kind="stable")[:LIKELY]
    return [np.stack(ways[k], axis=1) for k in likely]


def extremity_triplets(source: Surface, target: Surface) -> list[tuple[np.ndarray, np.ndarray]]:
    """The triplets of each likely way to match tips.

    Returns
    -------
    list of tuple
        Which sample of the target each triplet pairs each source sample with, (i, N1) int, -1 for none, and the sums of
        the triplets' weights (i,), as in :class:`Votes`.
    """
    ways = extremity_matchings(source, target)
    if not ways:
        return []
    triplets = [way[np.array(list(combinations(range(len(way)), 3)))] for way in ways]
    triplets1, triplets2 = (np.ascontiguousarray(np.concatenate(triplets)[:, :, side]) for side in (0, 1))
    pairs = mutual_pairs(homogeneous(source.positions), homogeneous(target.positions), triplets1, triplets2)
    triplet_weights = triplet_weights_of(source, target, triplets1, triplets2)
    ends = np.cumsum([len(some) for some in triplets])[:-1]
    return list(zip(np.split(pairs, ends), np.split(triplet_weights, ends), strict=True))
