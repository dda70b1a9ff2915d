"""A surface that is a part of the other one, located on it; and whether it had better be taken for one.

Beyond the paper, whose surfaces are whole. A part has another conformal structure, other eigenfunctions and another
area than the whole that it belongs to. Lengths, curvature and, away from the cut, distances and directions of shortest
paths are the same. So both are measured in the same units, at the size at which the part fits best. Triplets of samples
are evaluated by shortest paths instead of Möbius maps, the part is registered to the whole along the best of them, and
the matches are read off the registration of least cost.

A surface with a long rim may be a part, or a whole with a hole. Both are tried, and compared by one cost.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ..._core.display import one_line
from ...alignments.alignment import Alignment
from ...geometry.geodesics import geodesic_solver
from ...geometry.points import SurfacePoints
from ...landmarks.constraints import LandmarkConstraints
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration
from ...surface.surface import Surface
from ...voting.parameters import VotingParameters
from .coverage import Coverage, may_be_part
from .locate import Placement, fit, locate, refined
from .matches import points_on_part, points_on_whole
from .openings import openings
from .pair import PartPair
from .parameters import PartialParameters


@dataclass(frozen=True, eq=False)
class PartMatch:
    """Where a part lies on the whole.

    Parameters
    ----------
    points, match_probabilities
        Points (N1,) of the target for the source's samples, and the probability (N1,) that each is right; 0 for a
        sample of what is missing.
    part, whole, registration, part_is_source
        The two surfaces in the same units, the part registered to the whole, and which of them is which.
    """

    points: SurfacePoints
    match_probabilities: np.ndarray
    part: Surface
    whole: Surface
    registration: Registration
    part_is_source: bool

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Located:
    """One surface located on the other one as a part of it.

    Parameters
    ----------
    pair
        The two, with the part at the size at which it fits best.
    size
        This size, as a multiple of that in the file.
    placement
        Where the part lies.
    part_is_source
        Whether the part is the source.
    """

    pair: PartPair
    size: float
    placement: Placement
    part_is_source: bool

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def share(self) -> float:
        """Area of the part per area of the whole, at that size."""
        return float(self.pair.part.area * self.size**2 / self.pair.whole.area)

    def match(self) -> PartMatch:
        """The matches of the samples."""
        points, probabilities = (points_on_whole if self.part_is_source else points_on_part)(self.pair, self.placement)
        registration = self.placement.registration
        return PartMatch(points, probabilities, self.pair.part, self.pair.whole, registration, self.part_is_source)


def locate_parts(
    source: Surface,
    target: Surface,
    parameters: PartialParameters,
    registration: RegistrationParameters,
    seed: int,
    jobs: int | None = None,
    constraints: LandmarkConstraints | None = None,
    voting: VotingParameters = VotingParameters(),
) -> list[Located]:
    """Locate each of two surfaces that may be a part on the other one.

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
    list of Located
        At most two; none where neither surface may be a part, or fits nowhere at all.
    """
    found = []
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        for part_is_source, part, whole, given in (
            (True, source, target, constraints),
            (False, target, source, constraints and constraints.inverse),
        ):
            if not may_be_part(part, parameters):
                continue
            pair = PartPair(part, whole, parameters, registration, given, voting)
            size, fits = best_size(pair, seed, pool)
            pair = pair.scaled(size)
            placement = locate(pair, np.random.default_rng(seed), pool) if fits else None
            if placement is not None:
                found.append(at_better_size(Located(pair, size, placement, part_is_source)))
    return found


def choose_coverage(
    source: Surface,
    target: Surface,
    parts: list[Located],
    alignments: list[Alignment],
    cost: float,
    parameters: PartialParameters,
) -> tuple[Coverage, PartMatch | None, list[str]]:
    """Decide between a match of wholes and a match of a part.

    Parameters
    ----------
    source, target
        The surfaces.
    parts
        The result of :func:`locate_parts`.
    alignments
        Of the two as wholes, the chosen one first, which is registered; or none.
    cost
        Cost of the best alignment before registration; infinite if there is none.
    parameters
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
    notes = []
    if parts:
        costs = [part_error(one) * one.placement.cost for one in parts]
        best = int(np.argmin(costs))
        registration = alignments[0].registration if alignments else None
        as_whole = np.inf if registration is None else whole_error(source, target, registration, parameters) * cost
        compared = f"cost {as_whole:.3g} as wholes, {costs[best]:.3g} as a part"
        if as_whole > parameters.part_advantage * costs[best]:
            return Coverage.PART, parts[best].match(), part_notes(parts[best], compared)
        notes.append(f"{' and '.join(open_ones)}: matched as a whole in spite of the openings ({compared})")
    if len(open_ones) == 2 and parameters.incomplete_cost < cost < np.inf:
        notes.append(
            f"{source.mesh.name} and {target.mesh.name} both have large openings and differ as wholes: where each "
            f"lacks a part of the other, matches are wrong; all confidences were reduced"
        )
        return Coverage.BOTH_INCOMPLETE, None, notes
    return Coverage.WHOLE, None, notes


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
    ratios = np.log((here + softening) / (_distances_between(target, image) + softening))
    return float(np.abs(ratios[np.triu_indices(len(image), 1)]).mean())


def _distances_between(surface: Surface, vertices: np.ndarray) -> np.ndarray:
    """Geodesic distances (k, k) per sqrt(area) between vertices of a surface."""
    solve = geodesic_solver(surface.mesh.vertices / surface.scale, surface.mesh.faces, surface.settings.geodesics)
    distances = np.stack([solve(int(vertex))[vertices] for vertex in vertices])
    return np.asarray((distances + distances.T) / 2)


def at_better_size(located: Located) -> Located:
    """The part at the size at which distances nearby agree with those on the whole, registered again there.

    The fit of triplets prefers sizes that are too small by up to a tenth, and paths between distant points of a part
    may make a detour around what is missing. If the cost is not lower, nothing changes.
    """
    pair, registration = located.pair, located.placement.registration
    here, there = pair.part.normalized_distances, _distances_between(pair.whole, registration.image[pair.samples1])
    near = (here > 0) & (here < pair.voting.least_spread)
    if not near.any():
        return located
    # No part is larger than its whole.
    size = located.size * min(float(np.median(there[near] / here[near])), 1 / np.sqrt(located.share))
    if not size > 0:
        return located
    pair = pair.scaled(size)
    registration = refined(pair, registration)
    cost = pair.cost(registration)
    if cost >= located.placement.cost:
        return located
    return replace(
        located, pair=pair, size=size, placement=replace(located.placement, registration=registration, cost=cost)
    )


def best_size(pair: PartPair, seed: int, pool: ThreadPoolExecutor) -> tuple[float, float]:
    """The size of the part at which it fits best on the whole; its size in the file does not matter.

    Parameters
    ----------
    pair
        The two.
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
    equal, step = np.sqrt(pair.whole.area / pair.part.area), constants.size_step
    smallest = round(np.log(constants.smallest_share) / (2 * np.log(step)))
    fits: dict[int, float] = {}
    numbers = list(range(0, smallest - 1, -2))
    while numbers:
        for number in numbers:
            fits[number] = fit(pair.scaled(equal * step**number), np.random.default_rng(seed), pool)
        # No part is larger than its whole, but one step more tells where the top is.
        best = max((number for number in fits if number <= 0), key=fits.__getitem__)
        numbers = [number for number in (best - 1, best + 1) if number not in fits]
    # The top of the parabola through three sizes.
    below, middle, above = fits[best - 1], fits[best], fits[best + 1]
    vertex = best + (below - above) / (2 * (below - 2 * middle + above) or 1.0)
    return float(equal * step ** min(vertex, 0.0)), fits[best]
