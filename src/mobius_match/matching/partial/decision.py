"""Whether two surfaces correspond as wholes, one is a part of the other, or each lacks something."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...alignments.alignment import Alignment
from ...alignments.cost import registered_map_cost
from ...alignments.parameters import AlignmentParameters
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration
from ...surface.surface import Surface
from .coverage import Coverage
from .matches import boundary_length
from .pair import PartPair
from .parameters import PartialParameters
from .part import PartMatch


def coverage_of_pair(
    source: Surface,
    target: Surface,
    part_match: PartMatch | None,
    notes: list[str],
    alignment: Alignment | None,
    parameters: PartialParameters,
    of_alignment: AlignmentParameters,
) -> tuple[Coverage, list[str]]:
    """Decide between a match of wholes and a match of a part, once the surfaces have been registered as wholes.

    Parameters
    ----------
    source, target
        The surfaces.
    part_match, notes
        The result of :func:`.part.match_part`.
    alignment
        The alignment of the two as wholes that was chosen; None if there is none.
    parameters, of_alignment
        Constants of the method.

    Returns
    -------
    coverage
        How much of each other the surfaces cover.
    notes
        What the user should know about it, a line each.
    """
    both_open = min(boundary_length(source), boundary_length(target)) > parameters.opening
    if alignment is None or not both_open:
        return (Coverage.WHOLE if part_match is None else Coverage.PART), notes
    registration = alignment.registered(source, target, of_alignment)
    cost = registered_map_cost(source, target, registration, of_alignment.cost)
    if part_match is not None:
        whole = cost < parameters.same_cost or fit_as_wholes(
            source, target, registration, part_match, parameters, of_alignment.registration
        )
        return (Coverage.WHOLE, []) if whole else (Coverage.PART, notes)
    if cost <= parameters.incomplete_cost:
        return Coverage.WHOLE, notes
    return Coverage.BOTH_INCOMPLETE, [
        *notes,
        f"{source.mesh.name} and {target.mesh.name} both have large openings and differ as wholes: where each lacks a "
        f"part of the other, matches are wrong; all confidences were reduced",
    ]


def fit_as_wholes(
    source: Surface,
    target: Surface,
    wholes: Registration,
    part_match: PartMatch,
    parameters: PartialParameters,
    registration: RegistrationParameters,
) -> bool:
    """Whether two open surfaces fit each other as wholes, rim on rim, at least as well as one fits as a part.

    Two discs of similar shape are not parts of each other because one of them is smaller in its file. So the source,
    registered as a whole, is measured by the same cost, at the size at which both have the same area.

    Parameters
    ----------
    source, target, wholes
        The surfaces, and the source registered to the target.
    part_match
        The place of one of them as a part of the other.
    parameters, registration
        Constants of the method, and of registration.
    """
    if rim_gap(source, target, wholes) > parameters.rim_gap:
        return False
    size = float(target.scale / source.scale)
    return PartPair(source, target, parameters, registration).scaled(size).cost(wholes) <= part_match.cost


def rim_gap(source: Surface, target: Surface, registration: Registration) -> float:
    """How far apart the rims of two surfaces lie where one is registered to the other, per sqrt(area).

    The mean distance in space of the source's rim from the target's, or that of the target's from the source's,
    whichever is larger: a rim may coincide with a piece of a longer one. Infinite if one of the surfaces is closed.
    """
    if not (len(source.rim) and len(target.rim)):
        return np.inf
    here = registration.positions[np.unique(source.nearest_proxy[source.rim])]
    there = target.mesh.vertices[np.unique(target.rim)]
    gaps = (cKDTree(one).query(other)[0].mean() for one, other in ((here, there), (there, here)))
    return float(max(gaps) / target.scale)
