"""Candidate alignments of two surfaces: from clusters of the best triplets, of maps of discs, and from extremities.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong alignment (front taken for back,
head for feet) can gain more votes than the right one. So the best triplets are clustered by where they send the
samples, each cluster's matches are extended to a map of the whole surface (:mod:`.coarse_map`), and the maps are
compared by what the votes do not see (:mod:`.cost`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np

from .._core.display import one_line
from .._core.threads import map_threads
from ..landmarks.constraints import LandmarkConstraints
from ..settings import MatchSettings
from ..surface.surface import Surface
from ..voting.kernel import mutual_pairs
from ..voting.mobius import homogeneous
from ..voting.votes import Votes, cast_votes
from .alignment import Alignment, by_cost
from .clusters import agreed_matches, cluster_triplets, most_consistent_half
from .coarse_map import coarse_map, quick_image, transport_plan
from .cost import cost_terms, total_cost
from .discs import disc_matches
from .extremities import extremity_triplets
from .parameters import AlignmentParameters
from .poses import rigid_images

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Candidates:
    """Makes alignments of two surfaces, each with its cost.

    Parameters
    ----------
    source, target
        The surfaces.
    parameters
        The constants.
    constraints
        Landmarks: maps begin with them too, and cost the more the farther they send them elsewhere.
    jobs
        Threads; None for every processor. The result does not depend on it.
    """

    source: Surface
    target: Surface
    parameters: AlignmentParameters
    constraints: LandmarkConstraints | None = None
    jobs: int | None = 1

    def __repr__(self) -> str:
        return one_line(self)

    def voted(self, votes: Votes, discs: bool = True) -> list[Alignment]:
        """The alignments that the best triplets of guided votes stand for, the cheapest first.

        Without triplets there is none. Of two discs, unless it is switched off, also the best of all maps of discs: a
        long boundary may be that of a disc, or of a hole in a sphere as far as the triplets go, and the cost decides.
        """
        parameters, clusters = self.parameters, self.parameters.clusters
        pairs = mutual_pairs(
            homogeneous(self.source.positions),
            homogeneous(self.target.positions),
            votes.best_source,
            votes.best_target,
        )
        weights, distances = votes.triplet_weights, self.target.normalized_distances
        groups = cluster_triplets(pairs, distances, weights, clusters.radius, clusters.least_weight, clusters.most)
        matches = [self._agreed(pairs[group], weights[group]) for group in groups]
        of_discs = disc_matches(self.source, self.target, parameters.discs, clusters) if discs else []
        shares = [len(group) / len(pairs) for group in groups] + [0.0] * len(of_discs)
        matches += of_discs
        found = self._map(lambda i: self.aligned(matches[i], shares[i]), len(matches))
        least = min((one.cost for one in found), default=0.0)
        if least > parameters.selection.different_above:
            # A refinement that began well may have gone wrong. Other beginnings do not go wrong in the same way.
            order = sorted(range(len(found)), key=lambda i: found[i].cost)[: parameters.selection.most_contenders]
            near = [
                i for i in order if i < len(groups) and found[i].cost <= least + parameters.selection.contest_margin
            ]
            tasks = [
                (i, part, backward)
                for i in near
                for part, backward in product(
                    (groups[i], most_consistent_half(pairs, distances, groups[i])), (True, False)
                )
                if backward or part is not groups[i]
            ]
            variants = self._map(
                lambda k: self.aligned(self._agreed(pairs[tasks[k][1]], weights[tasks[k][1]]), 0.0, tasks[k][2]),
                len(tasks),
            )
            for (i, _, _), variant in zip(tasks, variants, strict=True):
                found[i] = min(found[i], replace(variant, share=shares[i]), key=by_cost)
        return distinct_alignments(self.target, found, clusters.radius / 2)

    def further(self, known: list[Alignment]) -> list[Alignment]:
        """Alignments that follow from no draw of triplets and differ from the known ones, the cheapest first.

        All of the triplets that were drawn may be wrong. Extremities are matched in every likely way, and the source is
        laid over the target by rigid motions.
        """
        parameters = self.parameters
        extremities = extremity_triplets(
            self.source, self.target, parameters.extremities, parameters.cost.softening, parameters.voting
        )
        lists = [self._agreed(*one) for one in extremities]
        lists = [matches for matches in lists if len(matches) > 2]
        costs = self._map(lambda i: self._quick_cost(lists[i]), len(lists))
        best = np.argsort(costs, kind="stable")[: parameters.extremities.tried]
        found = self._map(lambda k: self.aligned(lists[best[k]], 0.0), len(best))
        images = rigid_images(self.source, self.target, parameters.poses)
        found += self._map(lambda k: self._refined(images[k]), len(images))
        return distinct_alignments(self.target, found, parameters.clusters.radius / 2, known)

    def aligned(self, matches: np.ndarray, share: float, backward: bool = False) -> Alignment:
        """The alignment by matches of samples (q, 2), from a map of the source or, backward, of the target."""
        parameters, constraints = self.parameters.coarse_map, self.constraints
        if backward:
            inverse = constraints and constraints.inverse
            plan = coarse_map(self.target, self.source, matches[:, ::-1], parameters, inverse)
            return self._with_cost(plan.argmax(axis=0), share)
        return self._with_cost(
            coarse_map(self.source, self.target, matches, parameters, constraints).argmax(axis=1), share
        )

    def _refined(self, image: np.ndarray) -> Alignment:
        """The alignment along a map (P1,) of the proxies, refined as one by matches is."""
        plan = transport_plan(self.source, self.target, self.target.proxy[image], self.parameters.coarse_map)
        return self._with_cost(plan.argmax(axis=1), 0.0)

    def _with_cost(self, image: np.ndarray, share: float) -> Alignment:
        """The alignment along a map (P1,) of the proxies, with its cost."""
        source, target, constraints, parameters = self.source, self.target, self.constraints, self.parameters
        terms = cost_terms(source, target, image, parameters.cost)
        if constraints is not None:
            displacement = constraints.displacement(source, target, target.proxy[image])
            tolerance = constraints.parameters.displacement_tolerance
            terms["landmarks"] = float(np.maximum(displacement - tolerance, 0.0).mean())
        cost = total_cost(terms, parameters.cost.weights)
        return Alignment(target.proxy[image], terms, cost, share, constraints=constraints)

    def _quick_cost(self, matches: np.ndarray) -> float:
        """About the cost of the alignment by matches of samples (q, 2)."""
        parameters = self.parameters
        image = quick_image(self.source, self.target, matches, parameters.coarse_map, self.constraints)
        terms = cost_terms(self.source, self.target, image, parameters.cost, parameters.coarse_map.quick_thinning)
        return total_cost(terms, parameters.cost.weights)

    def _agreed(self, pairs: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The matches of samples (q, 2) that triplets agree on."""
        return agreed_matches(pairs, weights, len(self.target.samples), self.parameters.clusters.most_matches)

    def _map(self, task: Callable[[int], Result], number: int) -> list[Result]:
        """The results of a task for each number from 0 on, by threads."""
        return map_threads(lambda i, _: task(i), number, self.jobs, None)


def distinct_alignments(
    target: Surface, alignments: list[Alignment], radius: float, known: Sequence[Alignment] = ()
) -> list[Alignment]:
    """Alignments, the cheapest first, without those whose images lie within a radius of a cheaper one's, on average.

    Nor those within it of a known one's. The radius is per sqrt(area) of the target.
    """
    places, kept = target.mesh.vertices / target.scale, list(known)
    for one in sorted(alignments, key=by_cost):
        distances = [np.linalg.norm(places[one.image] - places[other.image], axis=1).mean() for other in kept]
        nearest = int(np.argmin(distances)) if kept else 0
        if kept and distances[nearest] < radius:
            kept[nearest] = replace(kept[nearest], share=max(kept[nearest].share, one.share))
        else:
            kept.append(one)
    return kept[len(known) :]


def alignments_with_landmarks(
    candidates: Candidates, votes: Votes, settings: MatchSettings
) -> tuple[Votes, list[Alignment]]:
    """The candidate alignments, and the votes they come from, where landmarks may be known.

    If no candidate agrees with the landmarks, votes are cast once more, for samples at similar distances from them. If
    one does, the landmarks do not change the votes: between shapes of different proportions those distances mislead.
    """
    found, constraints, parameters = candidates.voted(votes), candidates.constraints, candidates.parameters
    if constraints is None or (found and not found[0].cost_terms["landmarks"]):
        return votes, found
    source, target = candidates.source, candidates.target
    disagreement = constraints.disagreement(source, target, source.samples, target.samples)
    settings = replace(settings, votes=votes.n_triplets)
    votes = cast_votes(source, target, settings, disagreement=disagreement, parameters=parameters.voting)
    return votes, distinct_alignments(target, found + candidates.voted(votes), parameters.clusters.radius / 2)
