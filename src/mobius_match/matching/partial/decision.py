"""Whether two surfaces correspond as wholes, one is a part of the other, or each lacks something.

A surface with a long rim may be a part, a whole with a hole, or a disc. All readings are tried, and compared by one
cost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from ...alignments.alignment import Alignment
from ...alignments.cost import registered_map_cost
from ...alignments.parameters import AlignmentParameters
from ...registration.sparse import Registration
from ...surface.surface import Surface
from .coverage import Coverage, may_be_part
from .openings import openings
from .pair import PartPair
from .parameters import PartialParameters
from .part import Located, PartMatch, distances_between

AS_WHOLE = "matched as a whole in spite of the openings"


def choose_coverage(
    source: Surface,
    target: Surface,
    locate: Callable[[], list[Located]],
    alignments: list[Alignment],
    parameters: PartialParameters,
    of_alignment: AlignmentParameters,
) -> tuple[Coverage, PartMatch | None, list[str]]:
    """Decide between a match of wholes and a match of a part.

    Parameters
    ----------
    source, target
        The surfaces.
    locate
        Gives the result of :func:`.part.locate_parts`, which takes long. It is not called where the wholes agree.
    alignments
        Of the two as wholes, the chosen one first, which is registered; or none.
    parameters, of_alignment
        Constants of the method.

    Returns
    -------
    coverage
        How much of each other the surfaces cover.
    part_match
        If one of them is a part, where it lies.
    notes
        What the user should know about it, a line each.
    """
    open_ones = [one.mesh.name for one in (source, target) if may_be_part(one, parameters)]
    if not open_ones:
        return Coverage.WHOLE, None, []
    notes = []
    registration = alignments[0].registered(source, target, of_alignment) if alignments else None
    error = map_cost = np.inf
    if registration is not None:
        error = whole_error(source, target, registration, parameters)
        map_cost = registered_map_cost(source, target, registration, of_alignment.cost)
    if error <= parameters.same_error:
        return Coverage.WHOLE, None, [f"{' and '.join(open_ones)}: {AS_WHOLE} (distances agree to {error:.0%})"]
    if parts := locate():
        costs = [part_error(one) * one.placement.cost for one in parts]
        best, as_whole = int(np.argmin(costs)), error * map_cost
        compared = f"cost {as_whole:.3g} as wholes, {costs[best]:.3g} as a part"
        as_part = as_whole > parameters.part_advantage * costs[best]
        if as_part and not (registration and fit_as_wholes(source, target, registration, parts[best])):
            return Coverage.PART, replace(parts[best].match(), cost=costs[best]), part_notes(parts[best], compared)
        notes.append(f"{' and '.join(open_ones)}: {AS_WHOLE} ({compared})")
    if registration is None or len(open_ones) < 2:
        return Coverage.WHOLE, None, notes
    if map_cost > parameters.incomplete_cost:
        notes.append(
            f"{source.mesh.name} and {target.mesh.name} both have large openings and differ as wholes: where each "
            f"lacks a part of the other, matches are wrong; all confidences were reduced"
        )
        return Coverage.BOTH_INCOMPLETE, None, notes
    return Coverage.WHOLE, None, notes


def fit_as_wholes(source: Surface, target: Surface, wholes: Registration, part: Located) -> bool:
    """Whether two open surfaces, registered as wholes, fit rim on rim, and hardly worse than one of them as a part.

    Two discs of similar shape are not parts of each other because their proportions differ. So the source is measured
    by the cost of a placement as well, at the size at which both have the same area.
    """
    constants = part.pair.parameters
    if rim_gap(source, target, wholes) > constants.rim_gap:
        return False
    pair = PartPair(source, target, constants, part.pair.registration).scaled(float(target.scale / source.scale))
    return pair.cost(wholes) <= part.placement.cost + constants.close_margin


def rim_gap(source: Surface, target: Surface, registration: Registration) -> float:
    """How far apart the rims of two surfaces lie where one is registered to the other, per sqrt(area).

    The mean distance in space of the source's rim from the target's, or that of the target's from the source's,
    whichever is larger: a rim may coincide with a piece of a longer one. Infinite if one of the surfaces is closed.
    """
    if not (len(source.rim) and len(target.rim)):
        return np.inf
    here = registration.positions[np.unique(source.nearest_proxy[source.rim])]
    there = target.mesh.vertices[np.unique(target.rim)]
    gaps = (scipy.spatial.cKDTree(one).query(other)[0].mean() for one, other in ((here, there), (there, here)))
    return float(max(gaps) / target.scale)


def part_notes(located: Located, compared: str) -> list[str]:
    """What the user should know about a match of a part."""
    name, other = located.pair.part.mesh.name, located.pair.whole.mesh.name
    placement, constants = located.placement, located.pair.parameters
    notes = [
        f"{name} has large openings and was treated as a partial scan of {other} (scale {located.size:.3g}), with "
        f"{located.share:.0%} of its area ({compared})"
    ]
    if placement.cost > constants.credible_cost:
        notes[0] += "; it fits nowhere well, so few matches are likely enough"
    if placement.margin <= constants.close_margin:
        notes.append(
            f"ambiguous: {name} fits another region of {other} almost as well (margin {placement.margin:.2f}; below "
            f"{constants.close_margin} is close). Check the matches with 'mobius view'"
        )
    if may_be_part(located.pair.whole, constants):
        notes.append(f"{other} has large openings, too: a region that only one of the two has may be matched wrongly")
    return notes


def part_error(located: Located) -> float:
    """:func:`distance_error` of taking one surface for a part of the other one."""
    pair, image = located.pair, located.placement.registration.image
    return distance_error(pair.part.normalized_distances, pair.whole, image[pair.samples1], pair.parameters)


def whole_error(source: Surface, target: Surface, registration: Registration, parameters: PartialParameters) -> float:
    """:func:`distance_error` of taking two surfaces for wholes: of the same area, once their openings are closed."""
    areas = [1 + openings(one).missing for one in (source, target)]
    image = registration.image[np.searchsorted(source.proxy, source.samples)]
    distances = source.normalized_distances * np.sqrt(areas[1] / areas[0])
    return distance_error(distances, target, image, parameters)


def distance_error(here: np.ndarray, target: Surface, image: np.ndarray, parameters: PartialParameters) -> float:
    """Mean absolute logarithm of the ratio of distances between samples and between their images.

    Parameters
    ----------
    here
        (N1, N1) distances between the samples, per sqrt(area) of the target at the size that is assumed.
    target
        The other surface.
    image
        (N1,) vertices of the target.
    parameters
        Constants of the method.
    """
    softening = parameters.landmark_distance
    ratios = np.log((here + softening) / (distances_between(target, image) + softening))
    return float(np.abs(ratios[np.triu_indices(len(image), 1)]).mean())
