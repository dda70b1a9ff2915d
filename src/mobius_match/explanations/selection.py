"""The choice between explanations that are close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .._core.threads import Progress, each
from ..registration.register import sketched, strain
from ..surface.surface import Surface
from .candidates import CONTENDERS, CONTEST, HARD
from .coarse_map import even_targets
from .explanation import Explanation, badness_of, settled

HOPELESS = 3.0
"""By how much one is worse than another after it was bent in haste to be left at that."""


CLOSE = 0.3
"""Difference of two explanations' badness below which the choice between them is called close."""


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
