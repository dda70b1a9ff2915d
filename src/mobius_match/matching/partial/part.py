"""A surface that is a part of the other one, located on it.

Beyond the paper, whose surfaces are whole. A part has another conformal structure, other eigenfunctions and another
area than the whole that it belongs to. Lengths, curvature and, away from the cut, distances and directions of shortest
paths are the same. So both are measured in the same units, at the size at which the part fits best. Triplets of samples
are evaluated by shortest paths instead of Möbius maps, the part is registered to the whole along the best of them, and
the matches are read off the registration of least cost.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..._core.display import one_line
from ...geometry.points import SurfacePoints
from ...landmarks.constraints import LandmarkConstraints
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration
from ...surface.surface import Surface
from ...voting.parameters import VotingParameters
from .locate import fit, locate
from .matches import boundary_length, points_on_part, points_on_whole
from .pair import PartPair
from .parameters import PartialParameters


@dataclass(frozen=True, eq=False)
class PartMatch:
    """Where a part lies on the whole.

    Parameters
    ----------
    cost
        The cost of this place.
    points, match_probabilities
        Points (N1,) of the target for the source's samples, and the probability (N1,) that each is right; 0 for a
        sample of what is missing.
    part, whole, registration, part_is_source
        The two surfaces in the same units, the part registered to the whole, and which of them is which.
    """

    cost: float
    points: SurfacePoints
    match_probabilities: np.ndarray
    part: Surface
    whole: Surface
    registration: Registration
    part_is_source: bool

    def __repr__(self) -> str:
        return one_line(self)


def match_part(
    source: Surface,
    target: Surface,
    parameters: PartialParameters,
    registration: RegistrationParameters,
    seed: int,
    jobs: int | None = None,
    constraints: LandmarkConstraints | None = None,
    voting: VotingParameters = VotingParameters(),
) -> tuple[PartMatch | None, list[str]]:
    """Match two surfaces if one of them is a part of the other.

    Parameters
    ----------
    source, target
        The surfaces.
    parameters, registration
        Constants of the method, and of registration.
    seed
        Of the triplets.
    jobs
        Threads; None for as many as there are processors. The result does not depend on it.
    constraints
        Given pairs of points.
    voting
        Constants of triplets.

    Returns
    -------
    part_match
        None if neither is a part of the other.
    notes
        What the user should know about it, a line each; none where neither looks like a part.
    """
    part, whole = (source, target) if is_part(source, target, parameters) else (target, source)
    if not is_part(part, whole, parameters):
        return None, []
    if constraints is not None and part is target:
        constraints = constraints.inverse
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        pair = PartPair(part, whole, parameters, registration, constraints, voting)
        size, fits = best_size(pair, part.area / whole.area, seed, pool)
        pair = pair.scaled(size)
        placement = locate(pair, np.random.default_rng(seed), pool) if fits else None
    name, other = part.mesh.name, whole.mesh.name
    closed, share = boundary_length(whole) <= parameters.opening, part.area * size**2 / whole.area
    credible = placement is not None and placement.cost <= parameters.credible_cost
    if placement is None or not (credible or (closed and share <= parameters.forced_share)):
        return None, [f"{name} has large openings but was not located on {other} as a part; it was matched as a whole"]
    notes = [f"{name} has large openings and was treated as a partial scan of {other} (scale {size:.3g})"]
    if not credible:
        notes[0] += "; it fits nowhere well, so few matches are likely enough"
    if placement.margin <= parameters.close_margin:
        notes.append(
            f"ambiguous: {name} fits another region of {other} almost as well (margin {placement.margin:.2f}; below "
            f"{parameters.close_margin} is close). Check the matches with 'mobius view'"
        )
    if not closed:
        notes.append(f"{other} has large openings, too: a region that only one of the two has may be matched wrongly")
    points, probabilities = (points_on_whole if part is source else points_on_part)(pair, placement)
    return PartMatch(
        placement.cost, points, probabilities, pair.part, whole, placement.registration, part is source
    ), notes


def is_part(surface: Surface, other: Surface, parameters: PartialParameters) -> bool:
    """Whether a surface may be a part of another one.

    It has large openings, and less area in the units of the files. If these units differ, the other one is closed.
    """
    share, length, opening = surface.area / other.area, boundary_length(surface), parameters.opening
    if parameters.smallest_share <= share <= parameters.largest_share:
        return length * np.sqrt(share) > opening
    same_area = parameters.largest_share < share < 1 / parameters.largest_share
    return not same_area and length > opening >= boundary_length(other)


def best_size(pair: PartPair, share: float, seed: int, pool: ThreadPoolExecutor) -> tuple[float, float]:
    """The size of the part at which it fits best on the whole.

    Parameters
    ----------
    pair
        The two, at the sizes in the files.
    share
        The part's area, at that size, per that of the whole.
    seed, pool
        Of the triplets, and the threads that evaluate them.

    Returns
    -------
    size
        Multiple of the size in the file.
    fit
        How well the part fits at the best of the sizes tried, in [0, 1]; see :func:`.locate.fit`.
    """
    constants = pair.parameters
    step, shares = constants.size_step, (constants.largest_share, constants.smallest_share)
    # Steps up or down to a part as large as its whole, and to the smallest.
    most, least = (np.log(limit / share) / (2 * np.log(step)) for limit in shares)
    known = least <= 0 <= most
    fits = dict.fromkeys([0.0] if known else np.arange(most, least, -1.0).tolist(), -1.0)
    while True:
        for number, value in fits.items():
            if value < 0:
                found = fit(pair.scaled(step**number), np.random.default_rng(seed), pool)
                fits[number] = found * (1 - known * constants.size_penalty * abs(number))
        best = max(fits, key=fits.__getitem__)
        beside = [number for number in (best - 1, best + 1) if least <= number <= most]
        if all(number in fits for number in beside):
            break
        fits |= dict.fromkeys((number for number in beside if number not in fits), -1.0)
    vertex = best
    if len(beside) == 2:
        # The top of the parabola through three sizes.
        below, middle, above = fits[best - 1], fits[best], fits[best + 1]
        vertex += (below - above) / (2 * (below - 2 * middle + above) or 1.0)
    return float(step**vertex), fits[best]
