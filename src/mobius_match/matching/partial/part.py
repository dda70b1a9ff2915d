"""A surface that was cut off from a larger one, found on it.

Beyond the paper, whose surfaces are whole. A part has another conformal structure, other eigenfunctions and another
area than the whole that it belongs to; what it keeps are lengths, curvature and, away from the cut, distances and the
ways that shortest paths run. So both are measured in common units, at the size at which the part fits best. Triplets of
samples are judged by their paths instead of Möbius maps, the places that the best of them send the part to are
compared, and the part is bent onto the whole at the best. Each way of matching reads its matches off the bent part.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..._core.display import one_line
from ...geometry.points import SurfacePoints
from ...landmarks.constraints import LandmarkConstraints
from ...registration.sparse import Registration
from ...surface.surface import Surface
from .locate import PartPair, Placement
from .place import OPEN, boundary_length, points_on_part, points_on_whole

LARGEST, SMALLEST = 0.97, 0.1
"""Part of the whole's area that a part may have: above, it is taken for a whole, though it has a boundary."""

MOST = 0.75
"""Part of the whole's area up to which nothing is gained by matching a part as a whole."""

CLOSED = 0.5
"""What part of the part's boundary the whole's may have, per sqrt(area) each, if the two have different units."""

STEP, FAITH = 1.2, 0.03
"""Ratio of one size to the next that is tried, and by which part a size has to fit better for each step that it is off
the units of the files."""

DOUBTFUL = 0.1
"""How much worse another place is at most that a user is told of."""

WORST, LOOSEST, UNLIKE = 1.95, 0.0135, 0.5
"""Badness of a place, mean distance of the bent part from the whole, and 1 - the rank correlation of their mean
curvatures, above which the one is no part of the other."""

ALIKE, STRANGE = 1.0, 3.5
"""Cost of an alignment of two surfaces with large openings: below the first they correspond as wholes, and neither is a
part of the other; above the second each of them may lack something that the other one has."""

DISTRUST = 0.5
"""What chances are multiplied by then."""


class Coverage(Enum):
    """How much of each other two surfaces cover."""

    WHOLE = "whole"
    """Each of them covers the other one."""

    PART = "part"
    """One of them is a part of the other one."""

    BOTH_INCOMPLETE = "both incomplete"
    """Each of them may lack something that the other one has."""


@dataclass(frozen=True, eq=False)
class PartMatch:
    """Where one surface lies that is a part of the other.

    Parameters
    ----------
    points, chances
        (N1,) points of the target for the source's samples, and the chance that each is right, 0 for a sample that
        lies on what is missing.
    part, whole, registration, part_is_source
        The two surfaces in common units, the part bent onto the whole, and which of them is which.
    """

    points: SurfacePoints
    match_probabilities: np.ndarray
    part: Surface
    whole: Surface
    registration: Registration
    part_is_source: bool

    def __repr__(self) -> str:
        return one_line(self)


def match_part(
    source: Surface, target: Surface, seed: int, jobs: int | None = None, constraints: LandmarkConstraints | None = None
) -> tuple[PartMatch | None, list[str]]:
    """Where the source's samples lie on the target, if one of the two is a part of the other.

    Parameters
    ----------
    source, target
        The surfaces.
    seed
        Of the triplets.
    jobs
        Threads; None for as many as there are processors. The result does not depend on it.
    hints
        Pairs that are known.

    Returns
    -------
    places
        None if neither is a part of the other.
    notes
        What a user should know of it, a line each; none where neither looks like a part.
    """
    part, whole = (source, target) if is_part(source, target) else (target, source)
    if not is_part(part, whole):
        return None, []
    if constraints is not None and part is target:
        constraints = constraints.inverse
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        pair = PartPair(part, whole, constraints)
        size = likely_size(pair, part.area / whole.area, seed, pool)
        pair = pair.scaled(size)
        place = pair.locate(np.random.default_rng(seed), pool)
    share = f"{part.mesh.name} has a long boundary, and {part.area / whole.area:.0%} of the area of {whole.mesh.name}"
    closed, left = boundary_length(whole) <= OPEN, part.area * size**2 / whole.area
    sure = place is not None and credible(pair, place)
    if place is None or not (sure or (closed and left <= MOST)):
        return None, [f"{share}, but was not found on it; it was matched as a whole"]
    how = f"at {size:.3g} times its size" if sure else "but fits nowhere well, so that few matches are likely enough"
    notes = [f"{share}; it was matched as a part of it, {how}"]
    if place.margin <= DOUBTFUL:
        notes.append(
            f"another place for {part.mesh.name} is nearly as good (it lost by {place.margin:.2f}; below {DOUBTFUL} is "
            "close): look at the matches"
        )
    if not closed:
        notes.append(f"{whole.mesh.name} has a long boundary, too: what each of the two lacks may be matched wrongly")
    points, match_probabilities = points_on_whole(pair, place) if part is source else points_on_part(pair, place)
    return PartMatch(points, match_probabilities, pair.part, whole, place.registration, part is source), notes


def credible(pair: PartPair, place: Placement) -> bool:
    """Whether the part is likely to lie there, or at least nowhere else."""
    cost_terms = pair.cost_terms(place.registration)
    return place.cost <= WORST and cost_terms["residual"] <= LOOSEST and cost_terms["mean curvature"] <= UNLIKE


def is_part(surface: Surface, other: Surface) -> bool:
    """Whether a surface may be a part of another.

    It has a long boundary, and in the units of the files less area; or these must differ, and the other is closed.
    """
    share, opening = surface.area / other.area, boundary_length(surface)
    if SMALLEST <= share <= LARGEST:
        return opening * np.sqrt(share) > OPEN
    return not LARGEST < share < 1 / LARGEST and opening > max(OPEN, boundary_length(other) / CLOSED)


def coverage_of_pair(
    source: Surface, target: Surface, part_match: PartMatch | None, notes: list[str], cost: float | None
) -> tuple[Coverage, list[str]]:
    """Decide between a match of wholes and a match of a part, once the surfaces have been aligned as wholes.

    Parameters
    ----------
    source, target
        The surfaces.
    part_match, notes
        The result of :func:`match_part`.
    cost
        Cost of the best alignment of the two as wholes; None if there is none.

    Returns
    -------
    coverage
        How much of each other the surfaces cover.
    notes
        What the user should know about it, a line each.
    """
    if part_match is not None:
        if cost is not None and cost < ALIKE:
            return Coverage.WHOLE, []
        return Coverage.PART, notes
    if cost is not None and cost > STRANGE and min(boundary_length(source), boundary_length(target)) > OPEN:
        return Coverage.BOTH_INCOMPLETE, [
            *notes,
            f"{source.mesh.name} and {target.mesh.name} both have large openings and differ as wholes: where each "
            "lacks a part of the other, matches are wrong; their confidence was halved",
        ]
    return Coverage.WHOLE, notes


def likely_size(pair: PartPair, share: float, seed: int, pool: ThreadPoolExecutor) -> float:
    """The size of the part, as a multiple of what its file says, at which it fits best on the whole.

    Parameters
    ----------
    pair
        The two, at the sizes of the files.
    share
        The part's area, at that size, per that of the whole.
    seed, pool
        Of the triplets, and who judges them.
    """
    # Steps up or down to a part as large as its whole, and to the smallest.
    most, least = (np.log(limit / share) / (2 * np.log(STEP)) for limit in (LARGEST, SMALLEST))
    known = least <= 0 <= most
    fits = dict.fromkeys([0.0] if known else np.arange(most, least, -1.0).tolist(), -1.0)
    while True:
        for step, fit in fits.items():
            if fit < 0:
                worth = pair.scaled(STEP**step).fit(np.random.default_rng(seed), pool)
                fits[step] = worth * (1 - known * FAITH * abs(step))
        best = max(fits, key=fits.__getitem__)
        beside = [step for step in (best - 1, best + 1) if least <= step <= most]
        if all(step in fits for step in beside):
            break
        fits |= dict.fromkeys((step for step in beside if step not in fits), -1.0)
    if len(beside) == 2:
        # The top of the parabola through three sizes.
        below, fit, above = fits[best - 1], fits[best], fits[best + 1]
        best += (below - above) / (2 * (below - 2 * fit + above) or 1.0)
    return float(STEP**best)
