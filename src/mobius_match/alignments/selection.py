"""The choice between alignments of similar cost, by how much registration along each strains the source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .._core.threads import Progress, map_threads
from ..registration.sparse import register_coarsely
from ..registration.strain import strain
from ..surface.surface import Surface
from .alignment import Alignment, by_cost, register_iteratively
from .coarse_map import balanced_targets
from .parameters import AlignmentParameters


def rerank_by_registration(
    source: Surface,
    target: Surface,
    candidates: list[Alignment],
    parameters: AlignmentParameters,
    jobs: int | None = 1,
) -> list[Alignment]:
    """Alignments, the cheapest first, after those of similar cost have been compared by registration.

    A coarse registration shows what is right on the whole and wrong at a limb, a full one what is wrong on the whole.
    Both take long; so only contenders are registered, and only those that the coarse one leaves hope get the full one.
    The cost of each changes by the mean of the differences of its strains from those of the first. The winner has been
    registered, repeatedly where shapes differ.
    """
    if not candidates:
        return []
    selection = parameters.selection
    differ = candidates[0].cost > selection.different_above
    rivals = [
        one
        for one in candidates[: selection.most_contenders]
        if one.cost - candidates[0].cost <= selection.contest_margin
    ]

    def coarse_strain(i: int, _: Progress) -> float:
        image = balanced_targets(source, target, rivals[i].image, parameters.coarse_map)
        registration = register_coarsely(source, target, image, parameters.registration, rivals[i].constraints)
        return strain(source, target, registration, parameters.registration)

    strains = np.array(map_threads(coarse_strain, len(rivals), jobs, None) if len(rivals) > 1 else [0.0])
    totals = strains + [one.cost for one in rivals]
    least, likely = int(totals.argmin()), np.flatnonzero(totals <= totals.min() + selection.contest_margin).tolist()
    contenders = [replace(rivals[i], shapes_differ=differ) for i in likely]
    registrations = map_threads(
        lambda k, _: contenders[k].registered(source, target, parameters, jobs), len(likely), jobs, None
    )
    # As differences, since a full registration strains less; the coarse one alone decides on the hopeless.
    full = np.array([strain(source, target, one, parameters.registration) for one in registrations])
    strains -= strains[least]
    strains[likely] = (strains[likely] + full - full[likely.index(least)]) / 2
    if len(rivals) > 1:
        for i, more in enumerate((strains - strains[0]).tolist()):
            rivals[i] = replace(
                rivals[i], cost_terms=rivals[i].cost_terms | {"strain": more}, cost=rivals[i].cost + more
            )
    winner = min(likely, key=lambda i: rivals[i].cost)
    chosen, registration = replace(rivals[winner], shapes_differ=differ), registrations[likely.index(winner)]
    if differ:
        registration = register_iteratively(source, target, chosen, parameters, jobs, registration)
    others = [*rivals[:winner], *rivals[winner + 1 :], *candidates[len(rivals) :]]
    return [replace(chosen, registration=registration), *sorted(others, key=by_cost)]


def ambiguity_warnings(alignments: list[Alignment], parameters: AlignmentParameters) -> list[str]:
    """Warnings about the choice between alignments, the cheapest first."""
    if alignments and alignments[0].cost_terms.get("landmarks"):
        return ["the landmarks agree with none of the alignments found. Check the landmarks, and the matches"]
    limit = parameters.selection.ambiguous_margin
    if len(alignments) < 2 or alignments[1].cost - alignments[0].cost > limit:
        return []
    margin = alignments[1].cost - alignments[0].cost
    return [
        "ambiguous: a second alignment (often left/right or front/back swapped) scores almost as well (margin "
        f"{margin:.2f}; below {limit} is close). Look at the matches and at the alternatives, or give one known pair "
        "as `landmarks`"
    ]
