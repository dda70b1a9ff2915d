"""Several explanations of one pair of surfaces, and the choice between them.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong explanation (front taken for
back, head for feet) can gain more votes than the right one. The best triplets are grouped by where they send the
surface; each group's matches are extended to a map of the whole surface by spectral upsampling (Melzi et al. 2019) that
leaves no part of the target over, and the maps are compared by what the votes do not see (`evidence.py`). Where none
fits well, the ends of limbs make triplets of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from operator import attrgetter

import numpy as np

from .evidence import compare, misgivings, weighted
from .hints import ASTRAY, Hints
from .mobius import homogeneous
from .preparing import each
from .registration import ALIKE, DIFFERENT, Registration, is_torn, register, sketched, strain
from .settings import MatchSettings
from .spreading import ROUGH, even_targets, finer_targets, rough_image, spread
from .surface import Progress, Surface
from .voting import Votes, cast_votes
from .voting.groups import GROUP_RADIUS, agreed_matches, group_triplets, purest_half
from .voting.kernel import explained_pairs
from .voting.tips import tip_groups

badness_of = attrgetter("badness")

UNSURE, HARD = 1.5, 2.0
"""Badness of the best explanation above which the ends of limbs are tried, too; and above which the shapes are taken to
differ: contenders are begun in other ways, and the winner is bent until it settles."""

AGAIN, LAST, TOGETHER = 4, 3, 0.05
"""How often the proxy is bent again, over how many of the last its positions are averaged, and how far from the best,
per sqrt(area), one counts."""

CONTEST, CONTENDERS = 1.5, 4
"""Difference of badness up to which explanations are compared once more, and how many at most."""

HOPELESS = 3.0
"""By how much one is worse than another after it was bent in haste to be left at that."""

TIPPED = 5
"""Of how many likely ways to match tips an explanation is made, where no other fits well."""

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
        How badly it fits, by kind: 0 is perfect; "strain", where it was contested, against that of the first.
    badness
        The weighted sum of the evidence; the smallest wins.
    share
        The part of the best triplets that tell this explanation.
    registration
        The source bent along it, if that has been done.
    differ
        Whether the shapes differ; then the registration, if it has been done, is where :func:`settled` leads.
    hints
        Pairs that are known, for bending.
    """

    image: np.ndarray
    evidence: dict[str, float]
    badness: float
    share: float
    registration: Registration | None = None
    differ: bool = False
    hints: Hints | None = None

    @property
    def seen(self) -> tuple[float, float]:
        """What descriptors and curvatures count when the source is bent along it."""
        return DIFFERENT if self.differ else ALIKE

    def begun(self, source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
        """Target vertices (P1,) that the source's proxy is drawn to at first, from a map of it (P1,).

        Where shapes differ, what leaves nothing of the target over is better than what is finer than its proxy.
        """
        if self.differ:
            return even_targets(source, target, image)
        return finer_targets(source, target, image, source.proxy)

    def registered(self, source: Surface, target: Surface, jobs: int | None = 1) -> Registration:
        """The source bent onto the target along this explanation."""
        if self.registration is not None:
            return self.registration
        image = self.begun(source, target, self.image)
        # A piece that was torn off by a few wrong points beside it is better believed.
        ways = (True, False) if is_torn(source, target, image) else (True,)
        found = each(
            lambda i, _: register(source, target, image, freeing=ways[i], seen=self.seen, hints=self.hints),
            len(ways),
            jobs,
            None,
        )
        return found[0] if len(found) == 1 else min(found, key=partial(misgivings, source, target))


def settled(
    source: Surface,
    target: Surface,
    explanation: Explanation,
    jobs: int | None = 1,
    begun: Registration | None = None,
) -> Registration:
    """The source's proxy bent along an explanation again and again, each time from where it had come to lie.

    A map that began badly gets better so, and what a single one is off along a limb averages out. The first time may
    have been ``begun``.
    """
    if explanation.differ and explanation.registration is not None:
        return explanation.registration
    found = [begun or explanation.registered(source, target, jobs)]
    for _ in range(AGAIN):
        image = explanation.begun(source, target, found[-1].image)
        found.append(register(source, target, image, seen=explanation.seen, hints=explanation.hints))
    # Where shapes differ, what is strained least is not what is right.
    best = found[-1] if explanation.differ else min(found, key=partial(misgivings, source, target))
    places = np.stack([best.positions, *(one.positions for one in found[-LAST:])])
    near = np.linalg.norm(places - best.positions, axis=2) <= TOGETHER * np.sqrt(target.area)
    return replace(best, positions=np.einsum("kp,kpd->pd", near, places) / near.sum(axis=0)[:, None])


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
    votes = cast_votes(source, target, replace(settings, votes=votes.n_triplets), hints=hints)
    return votes, distinct(target, found + explanations(source, target, votes, hints, settings.jobs))


def contested(source: Surface, target: Surface, found: list[Explanation], jobs: int | None = 1) -> list[Explanation]:
    """Explanations, best first, after those that are close have been compared once more: by how the source is bent.

    What is right on the whole and wrong at a limb shows when the surface is bent in haste, and what is wrong on the
    whole when it is bent with care. Both take long; so only contenders are. Their badness changes by how much worse
    they are bent than the first of them. The winner has been bent, where shapes differ until it settled.
    """
    if not found:
        return []
    differ = found[0].badness > HARD
    rivals = [one for one in found[:CONTENDERS] if one.badness - found[0].badness <= CONTEST]

    def hasty(i: int, _: Progress) -> float:
        image = even_targets(source, target, rivals[i].image)
        return strain(source, target, sketched(source, target, image, rivals[i].hints))

    strains = np.array(each(hasty, len(rivals), jobs, None) if len(rivals) > 1 else [0.0])
    totals = strains + [one.badness for one in rivals]
    least, likely = int(totals.argmin()), np.flatnonzero(totals <= totals.min() + HOPELESS).tolist()
    contenders = [replace(rivals[i], differ=differ) for i in likely]
    bent = each(lambda k, _: contenders[k].registered(source, target, jobs), len(likely), jobs, None)
    # Each way weighs half; haste alone tells of the hopeless. As differences, since careful bending strains less.
    careful = np.array([strain(source, target, one) for one in bent])
    strains -= strains[least]
    strains[likely] = (strains[likely] + careful - careful[likely.index(least)]) / 2
    if len(rivals) > 1:
        for i, more in enumerate((strains - strains[0]).tolist()):
            evidence = rivals[i].evidence | {"strain": more}
            rivals[i] = replace(rivals[i], evidence=evidence, badness=rivals[i].badness + more)
    first = min(likely, key=lambda i: rivals[i].badness)
    winner, begun = replace(rivals[first], differ=differ), bent[likely.index(first)]
    winner = replace(winner, registration=settled(source, target, winner, jobs, begun) if differ else begun)
    others = [*rivals[:first], *rivals[first + 1 :], *found[len(rivals) :]]
    return [winner, *sorted(others, key=badness_of)]


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
