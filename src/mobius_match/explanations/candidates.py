"""Candidate explanations of two surfaces: from the best triplets, and from their extremities."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from .._core.threads import each
from ..landmarks.constraints import ASTRAY, Hints
from ..settings import MatchSettings
from ..surface.surface import Surface
from ..voting.kernel import explained_pairs
from ..voting.mobius import homogeneous
from ..voting.votes import Votes, cast_votes
from .coarse_map import ROUGH, rough_image, spread
from .cost import compare, weighted
from .explanation import Explanation, badness_of
from .extremities import tip_groups
from .groups import GROUP_RADIUS, agreed_matches, group_triplets, purest_half

UNSURE, HARD = 1.5, 2.0
"""Badness of the best explanation above which the ends of limbs are tried, too; and above which the shapes are taken to
differ: contenders are begun in other ways, and the winner is bent until it settles."""


CONTEST, CONTENDERS = 1.5, 4
"""Difference of badness up to which explanations are compared once more, and how many at most."""


TIPPED = 5
"""Of how many likely ways to match tips an explanation is made, where no other fits well."""


def explanations(
    source: Surface,
    target: Surface,
    votes: Votes,
    hints: Hints | None = None,
    jobs: int | None = 1,
    limbs: bool = True,
) -> list[Explanation]:
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
    pairs = explained_pairs(homogeneous(source.positions), homogeneous(target.positions), votes.best1, votes.best2)
    distances = target.normalized_distances
    groups = group_triplets(pairs, distances, votes.totals)

    def judged(image: np.ndarray) -> dict[str, float]:
        evidence = compare(source, target, image)
        if hints is not None:
            astray = hints.astray(source, target, target.proxy[image])
            evidence["landmarks"] = float(np.maximum(astray - ASTRAY, 0.0).mean())
        return evidence

    def explained(matches: np.ndarray, share: float, backward: bool = False) -> Explanation:
        """The explanation by matches of samples, from a map of the source or, backward, of the target."""
        if backward:
            image = spread(target, source, matches[:, ::-1], hints and hints.inverse).argmax(axis=0)
        else:
            image = spread(source, target, matches, hints).argmax(axis=1)
        evidence = judged(image)
        return Explanation(target.proxy[image], evidence, weighted(evidence), share, hints=hints)

    def agreed(part: np.ndarray) -> np.ndarray:
        return agreed_matches(pairs[part], votes.totals[part], len(target.samples))

    def roughly(matches: np.ndarray) -> float:
        return weighted(compare(source, target, rough_image(source, target, matches, hints), ROUGH))

    shares = [len(group) / len(pairs) for group in groups]
    found = each(lambda i, _: explained(agreed(groups[i]), shares[i]), len(groups), jobs, None)
    least = min((one.badness for one in found), default=0.0)
    if least > HARD:
        # A map that began well may have gone astray. Other ways to begin do not go astray alike.
        order = sorted(range(len(found)), key=lambda i: found[i].badness)[:CONTENDERS]
        near = [i for i in order if found[i].badness <= least + CONTEST]
        tasks = [
            (i, part, backward)
            for i in near
            for part, backward in product((groups[i], purest_half(pairs, distances, groups[i])), (True, False))
            if backward or part is not groups[i]
        ]
        others = each(lambda k, _: explained(agreed(tasks[k][1]), 0.0, tasks[k][2]), len(tasks), jobs, None)
        for (i, _, _), other in zip(tasks, others, strict=True):
            found[i] = min(found[i], replace(other, share=shares[i]), key=badness_of)
    if limbs and least > UNSURE:
        # All of the triplets that were drawn may be wrong.
        ends = [agreed_matches(*group, len(target.samples)) for group in tip_groups(source, target)]
        ends = [matches for matches in ends if len(matches) > 2]
        rough = each(lambda i, _: roughly(ends[i]), len(ends), jobs, None)
        best = np.argsort(rough, kind="stable")[:TIPPED]
        found += each(lambda k, _: explained(ends[best[k]], 0.0), len(best), jobs, None)
        return distinct(target, found)
    return sorted(found, key=badness_of)


def distinct(target: Surface, found: list[Explanation]) -> list[Explanation]:
    """Explanations, best first, without those that send the source where a better one does."""
    places, kept = target.mesh.vertices / np.sqrt(target.area), list[Explanation]()
    for one in sorted(found, key=badness_of):
        apart = [np.linalg.norm(places[one.image] - places[other.image], axis=1).mean() for other in kept]
        same = int(np.argmin(apart)) if kept else 0
        if kept and apart[same] < GROUP_RADIUS / 2:
            kept[same] = replace(kept[same], share=max(kept[same].share, one.share))
        else:
            kept.append(one)
    return kept


def heeding(
    source: Surface, target: Surface, votes: Votes, settings: MatchSettings, hints: Hints | None
) -> tuple[Votes, list[Explanation]]:
    """The explanations, best first, and the votes that they come from, in the light of what is known.

    Where the votes lead to no explanation that agrees with the hints, they are cast once more with them. Where they do,
    hints have no say in it: on shapes of other proportions distances from them mislead.
    """
    found = explanations(source, target, votes, hints, settings.jobs)
    if hints is None or (found and not found[0].evidence["landmarks"]):
        return votes, found
    disagreement = hints.disagreement(source, target, source.samples, target.samples)
    votes = cast_votes(source, target, replace(settings, votes=votes.n_triplets), disagreement=disagreement)
    return votes, distinct(target, found + explanations(source, target, votes, hints, settings.jobs))
