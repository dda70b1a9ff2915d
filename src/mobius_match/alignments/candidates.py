"""Candidate explanations of two surfaces: from the best triplets, and from their extremities."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from .._core.threads import map_threads
from ..landmarks.constraints import LandmarkConstraints
from ..settings import MatchSettings
from ..surface.surface import Surface
from ..voting.kernel import mutual_pairs
from ..voting.mobius import homogeneous
from ..voting.votes import Votes, cast_votes
from .alignment import Alignment, cost_of
from .coarse_map import ROUGH, coarse_map, quick_image
from .cost import cost_terms, total_cost
from .extremities import extremity_triplets
from .groups import GROUP_RADIUS, agreed_matches, cluster_triplets, most_consistent_half

UNSURE, HARD = 1.5, 2.0
"""Badness of the best explanation above which the ends of limbs are tried, too; and above which the shapes are taken to
differ: contenders are begun in other ways, and the winner is bent until it settles."""


CONTEST, CONTENDERS = 1.5, 4
"""Difference of badness up to which explanations are compared once more, and how many at most."""


TIPPED = 5
"""Of how many likely ways to match tips an explanation is made, where no other fits well."""


def alignments(
    source: Surface,
    target: Surface,
    votes: Votes,
    constraints: LandmarkConstraints | None = None,
    jobs: int | None = 1,
    limbs: bool = True,
) -> list[Alignment]:
    """The explanations that the best triplets stand for, the best first.

    Parameters
    ----------
    source, target
        The surfaces.
    votes
        Votes of guided triplets on them. Without triplets there is no explanation.
    hints
        Pairs that are known: maps begin with them too, and are the worse the farther they send them elsewhere.
    jobs
        Threads; None for every processor. The result does not depend on it.
    limbs
        Whether the ends of limbs may be matched; those of a surface with itself would find themselves.
    """
    pairs = mutual_pairs(
        homogeneous(source.positions), homogeneous(target.positions), votes.best_source, votes.best_target
    )
    distances = target.normalized_distances
    groups = cluster_triplets(pairs, distances, votes.triplet_weights)

    def judged(image: np.ndarray) -> dict[str, float]:
        terms = cost_terms(source, target, image)
        if constraints is not None:
            displacement = constraints.displacement(source, target, target.proxy[image])
            tolerance = constraints.parameters.displacement_tolerance
            terms["landmarks"] = float(np.maximum(displacement - tolerance, 0.0).mean())
        return terms

    def explained(matches: np.ndarray, share: float, backward: bool = False) -> Alignment:
        """The explanation by matches of samples, from a map of the source or, backward, of the target."""
        if backward:
            image = coarse_map(target, source, matches[:, ::-1], constraints and constraints.inverse).argmax(axis=0)
        else:
            image = coarse_map(source, target, matches, constraints).argmax(axis=1)
        cost_terms = judged(image)
        return Alignment(target.proxy[image], cost_terms, total_cost(cost_terms), share, constraints=constraints)

    def agreed(part: np.ndarray) -> np.ndarray:
        return agreed_matches(pairs[part], votes.triplet_weights[part], len(target.samples))

    def roughly(matches: np.ndarray) -> float:
        return total_cost(cost_terms(source, target, quick_image(source, target, matches, constraints), ROUGH))

    shares = [len(group) / len(pairs) for group in groups]
    found = map_threads(lambda i, _: explained(agreed(groups[i]), shares[i]), len(groups), jobs, None)
    least = min((one.cost for one in found), default=0.0)
    if least > HARD:
        # A map that began well may have gone astray. Other ways to begin do not go astray alike.
        order = sorted(range(len(found)), key=lambda i: found[i].cost)[:CONTENDERS]
        near = [i for i in order if found[i].cost <= least + CONTEST]
        tasks = [
            (i, part, backward)
            for i in near
            for part, backward in product((groups[i], most_consistent_half(pairs, distances, groups[i])), (True, False))
            if backward or part is not groups[i]
        ]
        others = map_threads(lambda k, _: explained(agreed(tasks[k][1]), 0.0, tasks[k][2]), len(tasks), jobs, None)
        for (i, _, _), other in zip(tasks, others, strict=True):
            found[i] = min(found[i], replace(other, share=shares[i]), key=cost_of)
    if limbs and least > UNSURE:
        # All of the triplets that were drawn may be wrong.
        ends = [agreed_matches(*group, len(target.samples)) for group in extremity_triplets(source, target)]
        ends = [matches for matches in ends if len(matches) > 2]
        rough = map_threads(lambda i, _: roughly(ends[i]), len(ends), jobs, None)
        best = np.argsort(rough, kind="stable")[:TIPPED]
        found += map_threads(lambda k, _: explained(ends[best[k]], 0.0), len(best), jobs, None)
        return distinct_alignments(target, found)
    return sorted(found, key=cost_of)


def distinct_alignments(target: Surface, found: list[Alignment]) -> list[Alignment]:
    """Explanations, best first, without those that send the source where a better one does."""
    places, kept = target.mesh.vertices / np.sqrt(target.area), list[Alignment]()
    for one in sorted(found, key=cost_of):
        apart = [np.linalg.norm(places[one.image] - places[other.image], axis=1).mean() for other in kept]
        same = int(np.argmin(apart)) if kept else 0
        if kept and apart[same] < GROUP_RADIUS / 2:
            kept[same] = replace(kept[same], share=max(kept[same].share, one.share))
        else:
            kept.append(one)
    return kept


def alignments_with_landmarks(
    source: Surface, target: Surface, votes: Votes, settings: MatchSettings, constraints: LandmarkConstraints | None
) -> tuple[Votes, list[Alignment]]:
    """The explanations, best first, and the votes that they come from, in the light of what is known.

    Where the votes lead to no explanation that agrees with the hints, they are cast once more with them. Where they do,
    hints have no say in it: on shapes of other proportions distances from them mislead.
    """
    found = alignments(source, target, votes, constraints, settings.jobs)
    if constraints is None or (found and not found[0].cost_terms["landmarks"]):
        return votes, found
    disagreement = constraints.disagreement(source, target, source.samples, target.samples)
    votes = cast_votes(source, target, replace(settings, votes=votes.n_triplets), disagreement=disagreement)
    return votes, distinct_alignments(target, found + alignments(source, target, votes, constraints, settings.jobs))
