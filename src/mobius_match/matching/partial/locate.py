"""Where a part lies on a whole: triplets judged by paths, and the part bent onto the whole at the best places."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..._core.display import one_line
from ...alignments.clusters import cluster_triplets
from ...geometry.curvature import curvatures, rank_correlation
from ...geometry.directions import directions
from ...geometry.normals import vertex_normals
from ...landmarks.constraints import LandmarkConstraints
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration, register
from ...registration.strain import mean_stretch
from ...surface.surface import Surface
from ...voting.proposals import guided_triplets
from .agreement import Paths, agreement, differences, match_by_distances

REGISTRATION = RegistrationParameters()

RADII = (0.03, 0.06, 0.1)
"""Widths that curvatures are smoothed to; like all lengths here, per sqrt(area) of the whole."""

SPREAD, TOLERANCE, ALIKE = 0.3, 0.15, 0.35
"""Least distance of a triplet's points, relative difference of lengths, part of all pairs allowed."""

APPEARANCE = 0.1
"""Distance that a difference in curvature of one standard deviation counts as much as."""

TURNING, SCALE = 0.1, 0.15
"""Distance that a difference of 1 in the sine between two paths counts as much as, and see :func:`agreement`."""

TRIPLETS, COARSE = 20_000, ((4000, (25, 200)), (600, (100, 400)))
"""How many are judged, and how many are kept in each round, by points of the part and of the whole."""

SIZING, TOP = (2000, (50, 300)), 20
"""How many triplets tell how well a size fits, by how many points, and by how many of the best."""

RADIUS, GROUPS, PROMISING = 0.1, 80, 0.6
"""Mean distance of two triplets' places within a group, how many groups, and the least worth of the best triplet of
each, as a part of that of the best of all."""

SKETCHED, REFINED, CLOSE, APART = 12, 4, 1.5, 0.05
"""How many groups are bent in haste; how many of these are refined, up to which multiple of the least badness, and how
far they must lie from each other on average."""

CONTESTED = 1.2
"""Up to which multiple of the least badness places are refined once more."""

LANDMARKS, CAP, SOFT = 80, 0.15, 0.1
"""How many; what a distance to one that is wrong counts at most: it may lead through what is missing; see
:func:`match_by_distances`."""

AS_FAR, SAME_WAY = 3.0, 0.3
"""What distances and directions count where a map follows from landmarks."""

WEIGHTS = {
    "distances": 1.0,
    "turned": 2.0,
    "residual": 20.0,
    "turn": 2.0,
    "stretch": 3.0,
    "gauss curvature": 0.5,
    "mean curvature": 0.5,
}
"""What each kind of evidence against a place counts."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a part lies on a whole.

    Parameters
    ----------
    registration
        The part bent onto it.
    badness
        The weighted sum of the evidence against it.
    rivals
        By how much other places are worse, the closest first, and how far from this one they send the vertices of the
        part's proxy, (P1,) in space per sqrt(area).
    """

    registration: Registration
    cost: float
    rivals: list[tuple[float, np.ndarray]]

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def margin(self) -> float:
        """By how much the closest rival is worse; infinite if there is none."""
        return min((worse for worse, _ in self.rivals), default=np.inf)


class PartPair:
    """A part and the whole in common units, with what is measured on both.

    The area of the part is that of its whole, in the part's own units: all lengths are per sqrt(area).
    In all that follows a landmark is a sample of the part together with the sample of the whole next to its image.
    """

    def __init__(self, part: Surface, whole: Surface, constraints: LandmarkConstraints | None = None) -> None:
        self.part, self.whole, self.constraints = replace(part, area=whole.area), whole, constraints
        self.paths1, self.paths2 = _paths(self.part), _paths(whole)
        self.samples1, self.samples2 = (np.searchsorted(surface.proxy, surface.samples) for surface in (part, whole))
        self.curvatures2 = _curvatures(whole)
        self._spread = np.maximum(self.curvatures2[whole.proxy].std(axis=0), 1e-9)
        self.curvatures2 /= self._spread
        self.curvatures1 = _curvatures(self.part)[part.proxy] / self._spread

    def scaled(self, size: float) -> PartPair:
        """With the part at that multiple of the size that its file says."""
        pair = copy(self)
        pair.__dict__.pop("costs", None)
        pair.part = replace(self.part, area=self.whole.area / size**2)
        pair.paths1 = _paths(pair.part)
        pair.curvatures1 = _curvatures(pair.part)[pair.part.proxy] / self._spread
        return pair

    def appearance_cost(self, mine: np.ndarray, theirs: np.ndarray) -> np.ndarray:
        """What it costs (q1, q2) float32 that points of the two proxies look different."""
        each = zip(self.curvatures1[mine].T, self.curvatures2[self.whole.proxy[theirs]].T, strict=True)
        apart = sum(np.abs(one[:, None] - two) for one, two in each) / self.curvatures1.shape[1]
        costs = (APPEARANCE * np.minimum(apart, 3.0)).astype(np.float32)
        if self.constraints is not None:
            here, there = self.part.proxy[mine], self.whole.proxy[theirs]
            astray = self.constraints.disagreement(self.part, self.whole, here, there)
            costs += np.minimum(astray, CAP).astype(np.float32)
        return costs

    @cached_property
    def costs(self) -> np.ndarray:
        """:meth:`appearance_cost` for all points."""
        return self.appearance_cost(*(np.arange(len(surface.proxy)) for surface in (self.part, self.whole)))

    def fit(self, generator: np.random.Generator, pool: ThreadPoolExecutor) -> float:
        """How well the part fits anywhere on the whole, at its size: 0 to 1."""
        count, points = SIZING
        *_, totals = self._best(*self._triplets(generator, count), count, points, pool)
        return float(totals[:TOP].mean()) if len(totals) >= TOP else 0.0

    def locate(self, generator: np.random.Generator, pool: ThreadPoolExecutor) -> Placement | None:
        """Where the part lies on the whole, or would if it were a part of it; None if there is no place at all."""
        starts = self.starts(generator, pool)
        if not starts:
            return None
        sketches = list(pool.map(lambda image: self.bent(image, rounds=1), starts))
        found = list(pool.map(self.refined, [one for _, one in self._rivals(sketches)[:REFINED]]))
        rivals = self._rivals(found)
        rerank_by_registration = [one for cost, one in rivals if cost <= CONTESTED * rivals[0][0]]
        if len(rerank_by_registration) > 1:  # what began farther off has farther to go
            rivals = self._rivals(found + list(pool.map(self.refined, rerank_by_registration)))
        (least, best), *others = rivals
        return Placement(best, least, [(cost - least, self._apart(best, one)) for cost, one in others])

    def _rivals(self, found: list[Registration]) -> list[tuple[float, Registration]]:
        """The badness of each, and it, best first, without those that lie close to a better one or are much worse."""
        judged, kept = [self.cost(one) for one in found], list[tuple[float, Registration]]()
        for i in np.argsort(judged, kind="stable"):
            close = any(self._apart(found[i], other).mean() < APART for _, other in kept)
            if judged[i] <= CLOSE * min(judged) and not close:
                kept.append((judged[i], found[i]))
        return kept

    def _apart(self, first: Registration, second: Registration) -> np.ndarray:
        """How far from each other two registrations send the points of the part, (P1,) in space."""
        places = self.whole.mesh.vertices / np.sqrt(self.whole.area)
        return np.asarray(np.linalg.norm(places[first.image] - places[second.image], axis=1))

    def refined(self, found: Registration) -> Registration:
        """Bent again, twice, to where the landmarks that it places best say."""
        for rounds in (1, REGISTRATION.part.rounds):
            found = self.bent(self.image_by_landmarks(*self.landmarks(found)), rounds)
        return found

    def _triplets(self, generator: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        costs = self.appearance_cost(self.samples1, self.samples2)
        settings = costs <= np.quantile(costs, ALIKE), SPREAD, TOLERANCE
        lengths = self.part.normalized_distances, self.whole.normalized_distances
        if not len(guided_triplets(generator, 50, *lengths, *settings)[0]):  # rather than to try so often in vain
            count = 0
        return guided_triplets(generator, count, *lengths, *settings)

    def _best(
        self, first: np.ndarray, second: np.ndarray, count: int, points: tuple[int, int], pool: ThreadPoolExecutor
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The best triplets, and their totals, by that many points of the part and of the whole."""
        mine, theirs = (
            np.arange(0, len(surface.proxy), max(1, len(surface.proxy) // few))
            for surface, few in zip((self.part, self.whole), points, strict=True)
        )
        paths = self.paths1.to(mine), self.paths2.to(theirs)
        totals = agreement(*paths, self.appearance_cost(mine, theirs), first, second, TURNING, SCALE, pool)
        best = np.argsort(-totals, kind="stable")[:count]
        return first[best], second[best], totals[best]

    def starts(self, generator: np.random.Generator, pool: ThreadPoolExecutor) -> list[np.ndarray]:
        """Maps of the part's proxy to the whole's (P1,) that the best triplets stand for, best first."""
        first, second = self._triplets(generator, TRIPLETS)
        if not len(first):
            return []
        for count, points in COARSE:
            first, second, totals = self._best(first, second, count, points, pool)
        thin = self._of_samples
        paths, costs = (thin.paths1, self.paths2.to(self.samples2)), thin.costs[:, self.samples2]

        def matched(ends: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
            return differences(paths[0].of(ends[0]), paths[1].of(ends[1]), costs, TURNING).argmin(axis=1)

        pairs = np.stack(list(pool.map(matched, zip(first, second, strict=True))))
        groups = cluster_triplets(pairs, self.whole.normalized_distances, totals, RADIUS, PROMISING, GROUPS)
        good = [
            self._agreed(pairs[group], totals[group]) for group in groups if totals[group[0]] >= PROMISING * totals[0]
        ]
        worth = list(pool.map(lambda marks: thin.map_cost(thin.image_by_landmarks(*marks)), good))
        best = [good[i] for i in np.argsort(worth, kind="stable")[:SKETCHED]]
        return list(pool.map(lambda marks: self.image_by_landmarks(*marks), best))

    @property
    def _of_samples(self) -> PartPair:
        """As if the part's samples were all of its points: enough to see what is not worth more."""
        pair = copy(self)
        pair.paths1, pair.curvatures1 = self.paths1.to(self.samples1), self.curvatures1[self.samples1]
        pair.costs = self.appearance_cost(self.samples1, np.arange(len(self.whole.proxy)))
        pair.samples1 = np.arange(len(self.samples1))
        return pair

    def map_cost(self, image: np.ndarray) -> float:
        """How much paths and curvatures differ under a map of the part's proxy to the whole's (P1,)."""
        apart = self.compared(image)[1].mean() + SAME_WAY * (1 - self.turned(image)[0].mean())
        return float(apart + 3 * self.costs[np.arange(len(image)), image].mean())

    def _agreed(self, pairs: np.ndarray, totals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The landmarks that a group of triplets agrees on."""
        votes = np.zeros((pairs.shape[1], len(self.samples2)))
        for row, total in zip(pairs, totals, strict=True):
            votes[np.arange(len(row)), row] += total
        chosen = np.argsort(-votes.max(axis=1), kind="stable")[:LANDMARKS]
        return chosen, votes.argmax(axis=1)[chosen]

    def image_by_landmarks(self, mine: np.ndarray, theirs: np.ndarray) -> np.ndarray:
        """Each vertex of the part's proxy to the one of the whole's that is as far from the landmarks: (P1,) int64."""
        return match_by_distances(self.paths1.of(mine), self.paths2.of(theirs), self.costs, CAP, SOFT, AS_FAR, SAME_WAY)

    def bent(self, image: np.ndarray, rounds: int = REGISTRATION.part.rounds) -> Registration:
        """The part bent onto the whole along a map of its proxy (P1,) to the whole's."""
        image = self.whole.proxy[image]
        return register(
            self.part,
            self.whole,
            image,
            REGISTRATION,
            schedule=replace(REGISTRATION.part, rounds=rounds),
            whole=False,
            constraints=self.constraints,
        )

    def landmarks(self, found: Registration) -> tuple[np.ndarray, np.ndarray]:
        """The landmarks that a registration places best: samples of the part and of the whole."""
        image, here = self.whole.nearest_proxy[found.image], self.samples1
        theirs, apart, snapped = self.compared(image)
        weight = 1 / (self.paths1.lengths + SOFT)
        astray = (weight * np.minimum(apart, CAP)).sum(axis=1) / weight.sum(axis=1)
        turned = self.turned(image)[0][here]
        doubt = astray + snapped + 3 * found.residual[here] + 0.1 * found.normal_deviation[here] + 0.1 * (1 - turned)
        mine = np.argsort(doubt, kind="stable")[:LANDMARKS]
        return mine, theirs[mine]

    def compared(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The whole's sample (N1,) of each landmark, the errors of distances (N1, P1), how far the sample is off."""
        images = self.paths2.lengths[:, image]
        theirs = images[:, self.samples1].argmin(axis=0)
        return theirs, np.abs(self.paths1.lengths - images[theirs]), images[theirs, self.samples1]

    def turned(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How well paths from landmarks agree at the part's points and their images, (P1,) from 0 to 1.

        If the frames are turned against each other, and if one of them is mirrored, too.
        """
        theirs = self.compared(image)[0]
        here = self.paths1.x + 1j * self.paths1.y
        there = (self.paths2.x + 1j * self.paths2.y)[np.ix_(theirs, image)]
        most = np.maximum((np.abs(here) * np.abs(there)).sum(axis=0), 1e-9)
        ways = (here * there.conj(), here * there)
        return tuple(np.abs(way.sum(axis=0)) / most for way in ways)

    def cost(self, found: Registration) -> float:
        """The weighted sum of the evidence against a registration."""
        return sum(WEIGHTS[kind] * value for kind, value in self.cost_terms(found).items())

    def cost_terms(self, found: Registration) -> dict[str, float]:
        """What speaks against a registration; 0 is perfect in each kind."""
        gauss, mean = (
            1 - rank_correlation(of_part, of_whole)
            for of_part, of_whole in zip(self.curvatures1.T[2:4], self.curvatures2[found.image].T[2:4], strict=True)
        )
        image = self.whole.nearest_proxy[found.image]
        return {
            "distances": float(self.compared(image)[1].mean()),
            "turned": float(1 - self.turned(image)[0].mean()),
            "residual": float(found.residual.mean()),
            "turn": float(found.normal_deviation.mean()),
            "stretch": mean_stretch(self.part, self.whole, found),
            "gauss curvature": gauss,
            "mean curvature": mean,
        }


def _paths(surface: Surface) -> Paths:
    """From the samples to the points of the proxy."""
    points, faces = surface.mesh.vertices, surface.mesh.faces
    normals = vertex_normals(points, faces)[surface.proxy]
    ways = directions(points[surface.proxy], normals, surface.proxy_edges, surface.proxy_distances)
    return Paths((surface.proxy_distances / np.sqrt(surface.area)).astype(np.float32), *ways)


def _curvatures(surface: Surface) -> np.ndarray:
    vertices = (surface.mesh.vertices - surface.mesh.vertices.mean(axis=0)) / np.sqrt(surface.area)
    return curvatures(vertices, surface.mesh.faces, RADII)
