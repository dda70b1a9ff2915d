"""Several explanations of one pair of surfaces, and the choice between them.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong explanation (front taken for
back, head for feet) can gain more votes than the right one. The best triplets are grouped by where they send the
surface; each group's matches are extended to a map of the whole surface by spectral upsampling (Melzi et al. 2019) that
leaves no part of the target over, and the maps are compared by what the votes do not see: distances over all pairs,
the Laplacian, curvature.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .geometry.spectral import functional_map
from .geometry.transport import Transport
from .hints import ASTRAY, Hints
from .matrix_processing import max_row_column
from .mobius import homogeneous
from .registration import Registration, register, stretching
from .settings import MatchSettings
from .surface import Surface
from .voting import Votes, cast_votes
from .voting.kernel import explained_pairs

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

WEIGHTS = {
    "distances": 5.0,
    "laplacian": 3.0,
    "mean curvature": 1.0,
    "gauss curvature": 3.0,
    "votes": 2.0,
    "landmarks": 20.0,
}
"""What each kind of evidence counts; the last is how far known pairs are sent elsewhere, where there are any."""

CONTEST, STRETCH = 1.0, 20.0
"""Difference of badness up to which explanations are compared once more, and what stretching counts then."""

CONTENDERS = 4

CLOSE = 0.3
"""Difference of two explanations' badness below which the choice between them is called close."""


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
    hints
        Pairs that are known, for bending.
    """

    image: np.ndarray
    evidence: dict[str, float]
    badness: float
    share: float
    registration: Registration | None = None
    hints: Hints | None = None

    def registered(self, source: Surface, target: Surface) -> Registration:
        """The source bent onto the target along this explanation."""
        return self.registration or register(
            source, target, finer_targets(source, target, self, source.proxy), hints=self.hints
        )


def explanations(source: Surface, target: Surface, votes: Votes, hints: Hints | None = None) -> list[Explanation]:
    """The explanations that the best triplets stand for, the best first.

    Parameters
    ----------
    source, target
        The surfaces.
    votes
        Votes of guided triplets on them. Without triplets there is no explanation.
    hints
        Pairs that are known: maps begin with them too, and are the worse the farther they send them elsewhere.
    """
    pairs = explained_pairs(homogeneous(source.positions), homogeneous(target.positions), votes.best1, votes.best2)
    found = []
    for group in group_triplets(pairs, target.normalized_distances, votes.totals):
        matches = _matches(pairs[group], votes.totals[group], len(target.samples))
        image = spread_to_surface(source, target, matches, hints)
        evidence = compare(source, target, image)
        evidence["votes"] = float(np.log(votes.totals[0] / votes.totals[group[0]]))
        if hints is not None:
            astray = hints.astray(source, target, target.proxy[image])
            evidence["landmarks"] = float(np.maximum(astray - ASTRAY, 0.0).mean())
        badness = sum(WEIGHTS[kind] * value for kind, value in evidence.items())
        found.append(Explanation(target.proxy[image], evidence, badness, len(group) / len(pairs), hints=hints))
    return sorted(found, key=lambda explanation: explanation.badness)


def heeding(
    source: Surface, target: Surface, votes: Votes, settings: MatchSettings, hints: Hints | None
) -> tuple[Votes, list[Explanation]]:
    """The explanations, best first, and the votes that they come from, in the light of what is known.

    Where the votes lead to no explanation that agrees with the hints, they are cast once more with them. Where they do,
    hints have no say in it: on shapes of other proportions distances from them mislead.
    """
    found = explanations(source, target, votes, hints)
    if hints is None or (found and not found[0].evidence["landmarks"]):
        return votes, found
    votes = cast_votes(source, target, replace(settings, votes=votes.n_triplets), hints=hints)
    found = sorted(found + explanations(source, target, votes, hints), key=lambda explanation: explanation.badness)
    places, distinct = target.mesh.vertices / np.sqrt(target.area), found[:1]
    for one in found[1:]:
        apart = [np.linalg.norm(places[one.image] - places[other.image], axis=1).mean() for other in distinct]
        if min(apart) >= GROUP_RADIUS / 2:
            distinct.append(one)
    return votes, distinct


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
        badness = one.badness + STRETCH * more
        judged.append(replace(one, evidence=evidence, badness=badness, registration=registration))
    return sorted(judged + found[len(rivals) :], key=lambda explanation: explanation.badness)


def doubts(found: list[Explanation]) -> list[str]:
    """What a user should know of the choice between explanations, best first."""
    if found and found[0].evidence.get("landmarks"):
        return ["the landmarks fit with none of the explanations that were found: are they right? Look at the matches"]
    if len(found) < 2 or found[1].badness - found[0].badness > CLOSE:
        return []
    margin = found[1].badness - found[0].badness
    return [
        f"another explanation of the two shapes is nearly as good (it lost by {margin:.2f}; below {CLOSE} is close): "
        "look at the matches, and at the alternatives"
    ]


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
        leader = pairs[left[0]]
        shared = (pairs[left] >= 0) & (leader >= 0)
        apart = np.where(shared, distances[pairs[left], leader], 0.0).sum(axis=1) / np.maximum(shared.sum(axis=1), 1)
        same = (apart < radius) & shared.any(axis=1)
        same[0] = True
        groups.append(left[same])
        left = left[~same]
    return groups


def _matches(pairs: np.ndarray, totals: np.ndarray, n2: int) -> np.ndarray:
    """The matches (q, 2) that a group of triplets agrees on."""
    votes = np.zeros((pairs.shape[1], n2))
    for row, total in zip(pairs, totals, strict=True):
        paired = np.flatnonzero(row >= 0)
        votes[paired, row[paired]] += total**2
    return max_row_column(votes)[0][:TRUSTED]


def spread_to_surface(source: Surface, target: Surface, matches: np.ndarray, hints: Hints | None = None) -> np.ndarray:
    """A map of the whole proxy from matches of samples (q, 2) and hints: numbers (P1,) in the target's proxy."""
    features = []
    for side, surface in enumerate((source, target)):
        apart = surface.proxy_distances[matches[:, side]]
        if hints is not None:
            apart = np.concatenate([apart, hints.distances[side][:, surface.proxy]])
        features.append(np.exp(-apart.T / (FEATURE_SCALE * np.sqrt(surface.area))))
    plan = Transport(*features).plan
    first, second = (surface.eigenfunctions[surface.proxy] for surface in (source, target))
    for count in UPSAMPLING:
        # Each point is sent to the mean of the places that its mass goes to.
        transfer = functional_map(first[:, :count], plan @ second[:, :count])
        plan = Transport(first[:, :count] @ transfer, second[:, :count]).plan
    return plan.argmax(axis=1)


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
    return Transport(first[source.proxy], second[target.proxy]).images(first[vertices], second)
