"""A surface that may be a part of the other one, located on it.

Beyond the paper, whose surfaces are whole. A part has another conformal structure, other eigenfunctions and another
area than the whole that it belongs to. Lengths, curvature and, away from the cut, distances and directions of shortest
paths are the same. So both are measured in the same units, at the size at which the part fits best. Triplets of samples
are evaluated by shortest paths instead of Möbius maps, the part is registered to the whole along the best of them, and
the matches are read off the registration of least cost.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ..._core.display import one_line
from ...geometry.geodesics import geodesic_solver
from ...geometry.points import SurfacePoints
from ...landmarks.constraints import LandmarkConstraints
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration
from ...surface.surface import Surface
from ...voting.parameters import VotingParameters
from .coverage import may_be_part
from .locate import Placement, fits, locate, refined
from .matches import points_on_part, points_on_whole
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
    cost
        What :func:`.decision.choose_coverage` compares; infinite before it has.
    """

    points: SurfacePoints
    match_probabilities: np.ndarray
    part: Surface
    whole: Surface
    registration: Registration
    part_is_source: bool
    cost: float = np.inf

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
            size, best_fit = best_size(pair, seed, pool)
            pair = pair.scaled(size)
            placement = locate(pair, np.random.default_rng(seed), pool) if best_fit else None
            if placement is not None:
                found.append(at_better_size(Located(pair, size, placement, part_is_source)))
    return found


def distances_between(surface: Surface, vertices: np.ndarray) -> np.ndarray:
    """Geodesic distances (k, k) per sqrt(area) between vertices of a surface."""
    solve = geodesic_solver(surface.mesh.vertices / surface.scale, surface.mesh.faces, surface.geodesics)
    distances = np.stack([solve(int(vertex))[vertices] for vertex in vertices])
    return np.asarray((distances + distances.T) / 2)


def at_better_size(located: Located) -> Located:
    """The part at the size at which distances nearby agree with those on the whole, registered again there.

    The fit of triplets prefers sizes that are too small by up to a tenth, and paths between distant points of a part
    may make a detour around what is missing. If the cost is not lower, nothing changes.
    """
    pair, registration = located.pair, located.placement.registration
    here, there = pair.part.normalized_distances, distances_between(pair.whole, registration.image[pair.samples1])
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
        How well the part fits at the best of the sizes tried, in [0, 1]; see :func:`.locate.fits`.
    """
    constants = pair.parameters
    equal, step = np.sqrt(pair.whole.area / pair.part.area), constants.size_step
    smallest = round(np.log(constants.smallest_share) / (2 * np.log(step)))
    found: dict[int, float] = {}
    numbers = list(range(0, smallest - 1, -2))
    while numbers:
        pairs = list(pool.map(lambda number: pair.scaled(equal * step**number), numbers))
        found.update(zip(numbers, fits(pairs, seed, pool), strict=True))
        # No part is larger than its whole, but one step more tells where the top is.
        best = max((number for number in found if number <= 0), key=found.__getitem__)
        numbers = [number for number in (best - 1, best + 1) if number not in found]
    # The top of the parabola through three sizes.
    below, middle, above = found[best - 1], found[best], found[best + 1]
    vertex = best + (below - above) / (2 * (below - 2 * middle + above) or 1.0)
    return float(equal * step ** min(vertex, 0.0)), found[best]
