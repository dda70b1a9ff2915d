"""Locate a part on a whole: triplets evaluated by shortest paths, and registrations along the best of them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ..._core.display import one_line
from ...alignments.clusters import cluster_triplets
from ...registration.sparse import Registration, register
from ...voting.proposals import guided_triplets
from .agreement import agreement, batches, images_by_triplets, match_by_distances
from .pair import PartPair


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a part lies on a whole.

    Parameters
    ----------
    registration
        The part registered to the whole.
    cost
        The cost of this.
    rivals
        For each other placement, best first: by how much its cost is higher, and how far from here it sends the
        vertices of the part's proxy, (P1,) in space per sqrt(area).
    """

    registration: Registration
    cost: float
    rivals: list[tuple[float, np.ndarray]]

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def margin(self) -> float:
        """By how much the cost of the best rival is higher; infinite if there is none."""
        return min((margin for margin, _ in self.rivals), default=np.inf)


def fits(pairs: list[PartPair], seed: int, pool: ThreadPoolExecutor) -> list[float]:
    """How well a part fits anywhere on the whole, at each of several sizes: 0 to 1."""
    count = pairs[0].parameters.sizing_triplets
    triplets = pool.map(lambda pair: draw_triplets(pair, np.random.default_rng(seed), count), pairs)
    found = []
    for pair, drawn in zip(pairs, triplets, strict=True):
        *_, totals = _best_triplets(pair, *drawn, count, pool)
        found.append(float(totals.mean()) if len(totals) == round(pair.parameters.best_share * count) else 0.0)
    return found


def locate(pair: PartPair, generator: np.random.Generator, pool: ThreadPoolExecutor) -> Placement | None:
    """The best placement of the part, whether it belongs to the whole or not; None if no triplet fits."""
    images = coarse_maps(pair, generator, pool)
    if not images:
        return None
    coarse = list(pool.map(lambda image: _register(pair, image, rounds=1), images))
    found = list(pool.map(lambda one: refined(pair, one), [one for _, one in _rivals(pair, coarse)]))
    rivals = _rivals(pair, found)
    if len(rivals) > 1:  # from a worse start it takes longer
        rivals = _rivals(pair, found + list(pool.map(lambda one: refined(pair, one), [one for _, one in rivals])))
    (cost, best), *others = rivals
    return Placement(best, cost, [(other - cost, _distances(pair, best, one)) for other, one in others])


def _rivals(pair: PartPair, found: list[Registration]) -> list[tuple[float, Registration]]:
    """Registrations with their cost, best first, without those that are close to a better one or much worse."""
    constants = pair.parameters
    costs, kept = [pair.cost(one) for one in found], list[tuple[float, Registration]]()
    for i in np.argsort(costs, kind="stable"):
        close = any(_distances(pair, found[i], other).mean() < constants.distinct for _, other in kept)
        if costs[i] <= constants.rival_ratio * min(costs) and not close:
            kept.append((costs[i], found[i]))
    return kept[: constants.registered]


def _distances(pair: PartPair, first: Registration, second: Registration) -> np.ndarray:
    """Distances (P1,) in space between the images of the part's points under two registrations."""
    vertices = pair.whole.mesh.vertices / pair.whole.scale
    return np.asarray(np.linalg.norm(vertices[first.image] - vertices[second.image], axis=1))


def _register(pair: PartPair, image: np.ndarray, rounds: int) -> Registration:
    """Register the part to the whole, from a map of its proxy to the whole's (P1,)."""
    return register(
        pair.part,
        pair.whole,
        pair.whole.proxy[image],
        pair.registration,
        schedule=replace(pair.registration.part, rounds=rounds),
        whole=False,
        constraints=pair.constraints,
    )


def refined(pair: PartPair, registration: Registration) -> Registration:
    """Register again, twice, from the landmarks that the registration before matched best."""
    for rounds in (1, pair.registration.part.rounds):
        image = _map_by_landmarks(pair, *best_landmarks(pair, registration))
        registration = _register(pair, image, rounds)
    return registration


def best_landmarks(pair: PartPair, registration: Registration) -> tuple[np.ndarray, np.ndarray]:
    """The landmarks that a registration matches best: samples of the part and of the whole."""
    image, samples, constants = pair.whole.nearest_proxy[registration.image], pair.samples1, pair.parameters
    landmarks2, _, snapped = pair.compared(image)
    angles = 1 - pair.angle_agreement(image) + registration.normal_deviation
    errors = pair.weighted_errors(image, axis=1) + snapped
    errors = errors + registration.residual[samples] + constants.direction_weight * angles[samples]
    chosen = np.argsort(errors, kind="stable")[: constants.landmarks]
    return chosen, landmarks2[chosen]


def _map_by_landmarks(pair: PartPair, landmarks1: np.ndarray, landmarks2: np.ndarray) -> np.ndarray:
    """The map (P1,) int64 of the part's proxy to the whole's that matches the distances from landmarks best."""
    constants = pair.parameters
    return match_by_distances(
        pair.paths1.of(landmarks1),
        pair.paths2.of(landmarks2),
        pair.curvature_costs,
        constants.error_cap,
        constants.landmark_distance,
        constants.direction_weight,
    )


def draw_triplets(pair: PartPair, generator: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """At most so many triplets (I, 3) of samples of the part and of the whole."""
    costs = pair.curvature_cost(pair.samples1, pair.samples2)
    triplets1, triplets2 = guided_triplets(
        generator,
        count,
        pair.part.normalized_distances,
        pair.whole.normalized_distances,
        costs <= np.quantile(costs, pair.parameters.allowed_share),
        pair.voting.least_spread,
        pair.voting.length_tolerance,
    )
    return triplets1, triplets2


def _best_triplets(
    pair: PartPair, triplets1: np.ndarray, triplets2: np.ndarray, count: int, pool: ThreadPoolExecutor
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The best of triplets (I, 3) of samples of part and whole, and their agreement (B,), best first.

    B is a share of the number that was to be drawn.
    """
    constants = pair.parameters
    points1, points2 = (
        np.arange(0, len(surface.proxy), max(1, len(surface.proxy) // number))
        for surface, number in zip((pair.part, pair.whole), constants.points, strict=True)
    )
    totals = agreement(
        pair.paths1.to(points1),
        pair.paths2.to(points2),
        pair.curvature_cost(points1, points2),
        triplets1,
        triplets2,
        constants.direction_weight,
        constants.error_scale,
        pool,
    )
    best = np.argsort(-totals, kind="stable")[: round(constants.best_share * count)]
    return triplets1[best], triplets2[best], totals[best]


def coarse_maps(pair: PartPair, generator: np.random.Generator, pool: ThreadPoolExecutor) -> list[np.ndarray]:
    """Maps of the part's proxy to the whole's (P1,) that the best triplets agree on, best first."""
    constants = pair.parameters
    drawn = draw_triplets(pair, generator, constants.triplets)
    triplets1, triplets2, totals = _best_triplets(pair, *drawn, constants.triplets, pool)
    if not len(totals):
        return []
    at_samples = pair.at_samples()
    paths1, paths2 = at_samples.paths1, pair.paths2.to(pair.samples2)
    costs = at_samples.curvature_costs[:, pair.samples2]

    images = np.empty((len(totals), len(costs)), np.int64)

    def match(some: slice) -> None:
        triplets = triplets1[some], triplets2[some]
        images_by_triplets(paths1, paths2, costs, *triplets, constants.direction_weight, images[some])

    list(pool.map(match, batches(len(totals))))
    groups = cluster_triplets(images, pair.whole.normalized_distances, totals, constants.distinct, 0.0, len(images))
    landmarks = [_agreed_landmarks(pair, images[group], totals[group]) for group in groups]
    map_costs = list(pool.map(lambda both: at_samples.map_cost(_map_by_landmarks(at_samples, *both)), landmarks))
    best = [landmarks[i] for i in np.argsort(map_costs, kind="stable")[: constants.registered_coarsely]]
    return list(pool.map(lambda both: _map_by_landmarks(pair, *both), best))


def _agreed_landmarks(pair: PartPair, images: np.ndarray, totals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The landmarks that most triplets of a group (B, N1) match, weighted by their agreement (B,)."""
    votes = np.zeros((images.shape[1], len(pair.samples2)))
    for image, total in zip(images, totals, strict=True):
        votes[np.arange(len(image)), image] += total
    chosen = np.argsort(-votes.max(axis=1), kind="stable")[: pair.parameters.landmarks]
    return chosen, votes.argmax(axis=1)[chosen]
