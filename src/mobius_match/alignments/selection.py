"""The choice between alignments: each likely one is registered, and gets a probability from the evidence for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .._core.threads import Progress, map_threads
from ..geometry.nearest_neighbors import nearest_neighbors
from ..settings import LEAST_ALIGNMENT_PROBABILITY
from .alignment import Alignment, by_cost, register_iteratively
from .candidates import Candidates
from .cost import cost_terms, total_cost
from .evidence import evidence, log_odds
from .parameters import AlignmentParameters


def choose_alignment(candidates: Candidates, found: list[Alignment]) -> list[Alignment]:
    """Alignments, the most probable first, which is registered: repeatedly where shapes differ.

    Registration takes long; so only the cheapest ones are registered, and the others have probability 0. Where none of
    them is beyond doubt, further candidates are looked for, and compared with them.

    Parameters
    ----------
    candidates
        Makes further ones.
    found
        Those known, the cheapest first.
    """
    selection = candidates.parameters.selection
    differ = bool(found) and found[0].cost > selection.different_above
    rivals, left = _registered(candidates, found, differ)
    if not rivals or rivals[0].probability < selection.sure_above:
        more, none = _registered(candidates, candidates.further(rivals + left), differ)
        rivals, left = rivals + more, left + none
    rivals = with_probabilities(distinct_registrations(candidates, rivals), candidates.parameters)
    if not rivals:
        return []
    same = equivalent(candidates, rivals)
    if len(same) + 1 >= selection.most_contenders:  # there may be more of them
        more, left = _registered(candidates, left, differ)
        rivals = with_probabilities(distinct_registrations(candidates, rivals + more), candidates.parameters)
        same = equivalent(candidates, rivals)
    chosen, *others = rivals
    chosen = replace(chosen, probability=chosen.probability + sum(one.probability for one in same), order=1 + len(same))
    if differ:
        # What was registered once is where the repetition starts.
        once, chosen = chosen.registration, replace(chosen, registration=None)
        arguments = candidates.source, candidates.target, chosen, candidates.parameters, candidates.jobs
        chosen = replace(chosen, registration=register_iteratively(*arguments, once))
        others = [replace(one, registration=None) for one in others]
    return [chosen, *others, *sorted(left, key=by_cost)]


def _registered(
    candidates: Candidates, found: list[Alignment], differ: bool
) -> tuple[list[Alignment], list[Alignment]]:
    """The cheapest of some alignments, registered, with their evidence and probabilities; and the others."""
    source, target, parameters = candidates.source, candidates.target, candidates.parameters
    selection = parameters.selection
    rivals = [
        replace(one, shapes_differ=differ)
        for one in found[: selection.most_contenders]
        if one.cost - found[0].cost <= selection.contest_margin
    ]

    def with_evidence(i: int, _: Progress) -> Alignment:
        registration = rivals[i].registered(source, target, parameters, candidates.jobs)
        terms = evidence(source, target, registration)
        return replace(rivals[i], registration=registration, evidence=terms)

    registered = map_threads(with_evidence, len(rivals), candidates.jobs, None)
    return with_probabilities(registered, parameters), found[len(rivals) :]


def distinct_registrations(candidates: Candidates, alignments: list[Alignment]) -> list[Alignment]:
    """Alignments without those whose registration ends where that of a more probable one does.

    As in :func:`.distinct_alignments`; different beginnings may come to one end.
    """
    kept = list[Alignment]()
    places = list[np.ndarray]()
    for one in with_probabilities(alignments, candidates.parameters):
        if one.registration is not None:
            here = one.registration.positions / candidates.target.scale
            apart = [np.linalg.norm(here - other, axis=1).mean() for other in places]
            if min(apart, default=np.inf) >= candidates.parameters.clusters.radius / 2:
                kept.append(one)
                places.append(here)
    return kept


def equivalent(candidates: Candidates, alignments: list[Alignment]) -> list[Alignment]:
    """The alignments that differ from the first one by a symmetry of the source, by which all are as right as it.

    Such a one is about as likely as the first one, and takes the source to itself, forth by the one and back by the
    other, as to a shape in another pose at most.
    """
    chosen, *others = alignments
    source, parameters = candidates.source, candidates.parameters
    if chosen.registration is None:
        return []
    found = []
    for one in others:
        if one.registration is not None and one.probability >= chosen.probability / 2:
            onto_itself = nearest_neighbors(one.registration.positions, chosen.registration.positions)
            terms = cost_terms(source, source, onto_itself, parameters.cost)
            if total_cost(terms, parameters.cost.weights) <= parameters.selection.different_above:
                found.append(one)
    return found


def with_probabilities(alignments: list[Alignment], parameters: AlignmentParameters) -> list[Alignment]:
    """Alignments with their probabilities from the evidence for them and from landmarks, the most probable first."""
    if not alignments:
        return []
    terms = [one.evidence for one in alignments if one.evidence is not None]
    violations = np.array([one.cost_terms.get("landmarks", 0.0) for one in alignments])
    scores = log_odds(terms, parameters.choice) - parameters.cost.weights.landmarks * violations
    chances = probabilities(scores)
    return [replace(alignments[i], probability=float(chances[i])) for i in np.argsort(-chances, kind="stable")]


def probabilities(scores: np.ndarray) -> np.ndarray:
    """The probability (c,) that each alignment is the right one, from the scores (c,).

    Conditional logistic (McFadden 1974): p_i = exp(s_i) / (1 + sum_j exp(s_j)). The 1 stands for none of them.
    """
    highest = max(scores.max(), 0.0)
    odds = np.exp(scores - highest)
    return np.asarray(odds / (np.exp(-highest) + odds.sum()))


def choice_warnings(alignments: list[Alignment], parameters: AlignmentParameters) -> list[str]:
    """Warnings about the choice between alignments, the most probable first."""
    if not alignments:
        return []
    if alignments[0].cost_terms.get("landmarks"):
        return ["the landmarks agree with none of the alignments found. Check the landmarks, and the matches"]
    first, *others = (one.probability for one in alignments)
    second = max(others, default=0.0)
    notes = []
    if (order := alignments[0].order) > 1:
        notes = [f"the shapes look the same in {order} alignments; the matches are right up to this symmetry"]
    if first >= parameters.selection.doubted_below:
        return notes
    if first < LEAST_ALIGNMENT_PROBABILITY:
        return [f"the two shapes may not belong together: no alignment is likely (probability {first:.2f})"]
    if second >= first / 2 and not notes:
        return [
            "ambiguous: a second alignment (often left/right or front/back swapped) is almost as likely (probability "
            f"{first:.2f} and {second:.2f}). Look at the matches and at the alternatives, or give one known pair as "
            "`landmarks`"
        ]
    return [
        *notes,
        f"doubtful: the alignment is right with a probability of {first:.2f} only. Look at the matches, or give known "
        "pairs as `landmarks`",
    ]
