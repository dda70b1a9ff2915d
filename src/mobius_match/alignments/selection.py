"""The choice between explanations that are close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .._core.threads import Progress, map_threads
from ..registration.register import register_coarsely, strain
from ..surface.surface import Surface
from .alignment import Alignment, cost_of, register_iteratively
from .candidates import CONTENDERS, CONTEST, HARD
from .coarse_map import balanced_targets

HOPELESS = 3.0
"""By how much one is worse than another after it was bent in haste to be left at that."""


CLOSE = 0.3
"""Difference of two explanations' badness below which the choice between them is called close."""


def rerank_by_registration(
    source: Surface, target: Surface, found: list[Alignment], jobs: int | None = 1
) -> list[Alignment]:
    """Explanations, best first, after those that are close have been compared once more: by how the source is bent.

    What is right on the whole and wrong at a limb shows when the surface is bent in haste, and what is wrong on the
    whole when it is bent with care. Both take long; so only contenders are. Their badness changes by how much worse
    they are bent than the first of them. The winner has been bent, where shapes differ until it settled.
    """
    if not found:
        return []
    shapes_differ = found[0].cost > HARD
    rivals = [one for one in found[:CONTENDERS] if one.cost - found[0].cost <= CONTEST]

    def coarse_strain(i: int, _: Progress) -> float:
        image = balanced_targets(source, target, rivals[i].image)
        return strain(source, target, register_coarsely(source, target, image, rivals[i].constraints))

    strains = np.array(map_threads(coarse_strain, len(rivals), jobs, None) if len(rivals) > 1 else [0.0])
    triplet_weights = strains + [one.cost for one in rivals]
    least, likely = (
        int(triplet_weights.argmin()),
        np.flatnonzero(triplet_weights <= triplet_weights.min() + HOPELESS).tolist(),
    )
    contenders = [replace(rivals[i], shapes_differ=shapes_differ) for i in likely]
    bent = map_threads(lambda k, _: contenders[k].registered(source, target, jobs), len(likely), jobs, None)
    # Each way weighs half; haste alone tells of the hopeless. As differences, since careful bending strains less.
    careful = np.array([strain(source, target, one) for one in bent])
    strains -= strains[least]
    strains[likely] = (strains[likely] + careful - careful[likely.index(least)]) / 2
    if len(rivals) > 1:
        for i, more in enumerate((strains - strains[0]).tolist()):
            cost_terms = rivals[i].cost_terms | {"strain": more}
            rivals[i] = replace(rivals[i], cost_terms=cost_terms, cost=rivals[i].cost + more)
    first = min(likely, key=lambda i: rivals[i].cost)
    winner, begun = replace(rivals[first], shapes_differ=shapes_differ), bent[likely.index(first)]
    winner = replace(
        winner, registration=register_iteratively(source, target, winner, jobs, begun) if shapes_differ else begun
    )
    others = [*rivals[:first], *rivals[first + 1 :], *found[len(rivals) :]]
    return [winner, *sorted(others, key=cost_of)]


def ambiguity_warnings(found: list[Alignment]) -> list[str]:
    """What a user should know of the choice between explanations, best first."""
    if found and found[0].cost_terms.get("landmarks"):
        return ["the landmarks fit with none of the explanations that were found: are they right? Look at the matches"]
    if len(found) < 2 or found[1].cost - found[0].cost > CLOSE:
        return []
    margin = found[1].cost - found[0].cost
    return [
        f"another explanation of the two shapes is nearly as good (it lost by {margin:.2f}; below {CLOSE} is close): "
        "look at the matches, and at the alternatives"
    ]
