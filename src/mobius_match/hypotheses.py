"""Several explanations of one pair of surfaces, and the choice between them.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong explanation (front taken for
back, head for feet) can gain more votes than the right one. The best triplets are grouped by where they send the
surface; each group's matches are extended to a map of the whole surface by spectral upsampling (Melzi et al. 2019) that
leaves no part of the target over, and the maps are compared by what the votes do not see: distances over all pairs,
the Laplacian, curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .geometry.spectral import functional_map
from .geometry.transport import Transport
from .matrix_processing import max_row_column
from .mobius import homogeneous
from .registration import Registration, described, register, stretching
from .surface import Surface
from .voting import Votes
from .voting.kernel import explained_pairs

import os
HARD, WITHIN = map(float, os.environ.get('HARD', '2.5,1.5').split(','))
S_DESC = float(os.environ.get('S_DESC', '0'))
GROUP_RADIUS = 0.2
"""Two triplets tell the same if they send the samples to places that differ by less, on average, per sqrt(area)."""

LEAST_SHARE = 0.6
"""Groups whose best triplet weighs less than this part of the best of all are not examined."""

MOST_GROUPS = 8
TRUSTED = 60
"""How many of a group's matches its map is made from."""

FEATURE_SCALE = 0.3
"""Distance per sqrt(area) over which a match has a say in the first map."""

UPSAMPLING = (20, 30, 40, 50)
"""Numbers of eigenfunctions from one refinement of the map to the next."""

COMPARED = 20
"""Number of eigenfunctions on which maps are compared with the Laplacian."""

WEIGHTS = {"distances": 5.0, "laplacian": 3.0, "mean curvature": 1.0, "gauss curvature": 3.0, "votes": 2.0}
"""What each kind of evidence counts."""

CONTEST, STRETCH = 1.0, 20.0
"""Difference of badness up to which explanations are compared once more, and what stretching counts then."""

CONTENDERS = 4


@dataclass(frozen=True, eq=False)
class Explanation:
    """One way to see the target as the source in another pose.

    Parameters
    ----------
    image
        (P1,) int64: target vertex of each vertex of the source's proxy.
    evidence
        How badly it fits, by kind: 0 is perfect.
    badness
        The weighted sum of the evidence; the smallest wins.
    share
        The part of the best triplets that tell this explanation.
    registration
        The source bent along it, if that has been done.
    """

    image: np.ndarray
    evidence: dict[str, float]
    badness: float
    share: float
    registration: Registration | None = None

    def registered(self, source: Surface, target: Surface) -> Registration:
        """The source bent onto the target along this explanation."""
        return self.registration or register(source, target, finer_targets(source, target, self, source.proxy))


def explanations(source: Surface, target: Surface, votes: Votes) -> list[Explanation]:
    """The explanations that the best triplets stand for, the best first.

    Parameters
    ----------
    source, target
        The surfaces.
    votes
        Votes of guided triplets on them. Without triplets there is no explanation.
    """
    pairs = explained_pairs(homogeneous(source.positions), homogeneous(target.positions), votes.best1, votes.best2)
    distances = target.normalized_distances

    def explained(group: np.ndarray, image: np.ndarray) -> Explanation:
        evidence = compare(source, target, image)
        evidence["votes"] = float(np.log(votes.totals[0] / votes.totals[group[0]]))
        badness = sum(WEIGHTS[kind] * value for kind, value in evidence.items())
        return Explanation(target.proxy[image], evidence, badness, len(group) / len(pairs))

    groups = group_triplets(pairs, distances, votes.totals)
    found = []
    for group in groups:
        matches = _matches(pairs[group], votes.totals[group], len(target.samples))
        found.append(explained(group, spread_to_surface(source, target, matches)))
    least = min((one.badness for one in found), default=0.0)
    if least > HARD:
        # Nothing fits well: the groups are impure or the maps were drawn to a wrong place. Other ways to begin help.
        for i, group in enumerate(groups):
            if found[i].badness - least > WITHIN: continue
            half = _purest(pairs, distances, group)
            for part in (group, half):
                matches = _matches(pairs[part], votes.totals[part], len(target.samples))
                tried = [] if part is group else [explained(group, spread_to_surface(source, target, matches))]
                tried.append(explained(group, _plan(target, source, matches[:, ::-1]).argmax(axis=0)))
                found[i] = min([found[i], *tried], key=lambda one: one.badness)
    return sorted(found, key=lambda explanation: explanation.badness)


def _purest(pairs: np.ndarray, distances: np.ndarray, group: np.ndarray) -> np.ndarray:
    apart = _differences(pairs[group], pairs[group[0]], distances)
    return group[np.sort(np.argsort(apart, kind="stable")[: (len(group) + 1) // 2])]


def contested(source: Surface, target: Surface, found: list[Explanation]) -> list[Explanation]:
    """Explanations, best first, after those that are close have been compared once more: by how much they stretch.

    What is right on the whole and wrong at a limb shows when the surface is bent, which takes long; so only contenders
    are. Their badness changes by how much more they stretch than the first of them. The winner has been bent.
    """
    rivals = [one for one in found[:CONTENDERS] if one.badness - found[0].badness <= CONTEST]
    judged: list[Explanation] = []
    for one in rivals:
        registration = one.registered(source, target)
        evidence = one.evidence | {"stretch": stretching(source, target, registration)}
        more = evidence["stretch"] - (judged or [one])[0].evidence.get("stretch", evidence["stretch"])
        judged.append(Explanation(one.image, evidence, one.badness + STRETCH * more, one.share, registration))
    return sorted(judged + found[len(rivals) :], key=lambda explanation: explanation.badness)


def group_triplets(
    pairs: np.ndarray,
    distances: np.ndarray,
    totals: np.ndarray,
    radius: float = GROUP_RADIUS,
    most: int = MOST_GROUPS,
) -> list[np.ndarray]:
    """Group triplets by where they send the samples.

    Parameters
    ----------
    pairs
        (B, N1) int, the target sample of each source sample under each triplet, -1 for none, best triplet first.
    distances
        (N2, N2) between the target's samples per sqrt(area).
    totals
        (B,) weights of the triplets, not increasing.
    radius, most
        Largest mean distance of a triplet's places from those of its group's best, and how many groups at most.

    Returns
    -------
    list of numpy.ndarray
        Numbers of the triplets of each group; the first of each is its best, and the groups are in their order.
    """
    left = np.flatnonzero(totals >= LEAST_SHARE * totals.max(initial=0.0))
    groups: list[np.ndarray] = []
    while len(left) and len(groups) < most:
        same = _differences(pairs[left], pairs[left[0]], distances) < radius
        same[0] = True
        groups.append(left[same])
        left = left[~same]
    return groups


def _differences(pairs: np.ndarray, leader: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Mean distances (B,) of the places of the samples under triplets (B, N1) and under another (N1,)."""
    shared = (pairs >= 0) & (leader >= 0)
    sums = np.where(shared, distances[pairs, leader], 0.0).sum(axis=1)
    return np.where(shared.any(axis=1), sums / np.maximum(shared.sum(axis=1), 1), np.inf)


def _matches(pairs: np.ndarray, totals: np.ndarray, n2: int) -> np.ndarray:
    """The matches (q, 2) that a group of triplets agrees on."""
    votes = np.zeros((pairs.shape[1], n2))
    for row, total in zip(pairs, totals, strict=True):
        paired = np.flatnonzero(row >= 0)
        votes[paired, row[paired]] += total**2
    return max_row_column(votes)[0][:TRUSTED]


def spread_to_surface(source: Surface, target: Surface, matches: np.ndarray) -> np.ndarray:
    """A map of the whole proxy from matches of samples (q, 2): numbers (P1,) in the target's proxy."""
    return _plan(source, target, matches).argmax(axis=1)


def _plan(source: Surface, target: Surface, matches: np.ndarray) -> np.ndarray:
    plan = Transport(
        *(
            np.exp(-surface.proxy_distances[matches[:, side]].T / (FEATURE_SCALE * np.sqrt(surface.area)))
            for side, surface in enumerate((source, target))
        )
    ).plan
    first, second = (surface.eigenfunctions[surface.proxy] for surface in (source, target))
    d1, d2 = (described(surface)[surface.proxy] for surface in (source, target))
    for count in UPSAMPLING:
        # Each point is sent to the mean of the places that its mass goes to.
        transfer = functional_map(first[:, :count], plan @ second[:, :count])
        one, two = first[:, :count] @ transfer, second[:, :count]
        scale = S_DESC * np.sqrt((two**2).sum(1).mean())
        plan = Transport(np.hstack([one, scale * d1]), np.hstack([two, scale * d2])).plan
    return plan


def compare(source: Surface, target: Surface, image: np.ndarray) -> dict[str, float]:
    """Evidence against a map of the proxy (P1,) to the target's proxy; 0 is perfect in each kind."""
    # A sample and its image are replaced by the nearest points that distances are known from.
    mine, theirs = (surface.proxy_distances / np.sqrt(surface.area) for surface in (source, target))
    landing = theirs[:, image[mine.argmin(axis=1)]].argmin(axis=0)
    first, second = (surface.eigenfunctions[surface.proxy][:, :COMPARED] for surface in (source, target))
    transfer = functional_map(first, second[image])
    low, high = source.eigenvalues[: transfer.shape[0]], target.eigenvalues[: transfer.shape[1]]
    gauss, mean = (
        1 - rank_correlation(of_source, of_target[image])
        for of_source, of_target in zip(source.proxy_curvatures, target.proxy_curvatures, strict=True)
    )
    return {
        "distances": float(np.abs(np.log((mine + 0.1) / (theirs[landing][:, image] + 0.1))).mean()),
        "laplacian": float(
            np.linalg.norm(transfer * high - low[:, None] * transfer) / np.linalg.norm(low[:, None] * transfer)
        ),
        "mean curvature": mean,
        "gauss curvature": gauss,
    }


def rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Spearman's, ties in order; 0 where one of the two does not vary. (Importing scipy.stats takes half a second.)"""
    if np.ptp(first) == 0 or np.ptp(second) == 0:
        return 0.0
    ranks1, ranks2 = (np.argsort(np.argsort(values, kind="stable")) for values in (first, second))
    return float(np.corrcoef(ranks1, ranks2)[0, 1])


def finer_targets(source: Surface, target: Surface, explanation: Explanation, vertices: np.ndarray) -> np.ndarray:
    """Where an explanation sends vertices of the source, no longer bound to samples: target vertices (q,) int64."""
    transfer = functional_map(source.eigenfunctions[source.proxy], target.eigenfunctions[explanation.image])
    first, second = source.eigenfunctions @ transfer, target.eigenfunctions
    d1, d2 = (described(surface) for surface in (source, target))
    scale = S_DESC * np.sqrt((second[target.proxy]**2).sum(1).mean())
    first, second = np.hstack([first, scale * d1]), np.hstack([second, scale * d2])
    return Transport(first[source.proxy], second[target.proxy]).images(first[vertices], second)
