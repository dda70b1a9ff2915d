"""Candidate alignments of two surfaces: from clusters of the best triplets, of maps of discs, and from extremities.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong alignment (front taken for back,
head for feet) can gain more votes than the right one. So the best triplets are clustered by where they send the
samples, each cluster's matches are extended to a map of the whole surface (:mod:`.coarse_map`), and the maps are
compared by what the votes do not see (:mod:`.cost`).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from .._core.threads import map_threads
from ..landmarks.constraints import LandmarkConstraints
from ..settings import MatchSettings
from ..surface.surface import Surface
from ..voting.kernel import mutual_pairs
from ..voting.mobius import homogeneous
from ..voting.votes import Votes, cast_votes
from .alignment import Alignment, by_cost
from .clusters import agreed_matches, cluster_triplets, most_consistent_half
from .coarse_map import coarse_map, quick_image
from .cost import cost_terms, total_cost
from .discs import disc_matches
from .extremities import extremity_triplets
from .parameters import AlignmentParameters


def candidate_alignments(
    source: Surface,
    target: Surface,
    votes: Votes,
    parameters: AlignmentParameters,
    *,
    constraints: LandmarkConstraints | None = None,
    jobs: int | None = 1,
    with_extremities: bool = True,
) -> list[Alignment]:
    """The alignments that the best triplets stand for, the cheapest first.

    Parameters
    ----------
    source, target
        The surfaces.
    votes
        Votes of guided triplets on them. Without triplets there is no alignment.
    parameters
        The constants.
    constraints
        Landmarks: maps begin with them too, and cost the more the farther they send them elsewhere.
    jobs
        Threads; None for every processor. The result does not depend on it.
    with_extremities
        Whether extremities may be matched; those of a surface with itself would give the identity.
    """
    selection, clusters = parameters.selection, parameters.clusters
    pairs = mutual_pairs(
        homogeneous(source.positions), homogeneous(target.positions), votes.best_source, votes.best_target
    )
    distances = target.normalized_distances
    groups = cluster_triplets(
        pairs, distances, votes.triplet_weights, clusters.radius, clusters.least_weight, clusters.most
    )

    def aligned(matches: np.ndarray, share: float, backward: bool = False) -> Alignment:
        """The alignment by matches of samples, from a map of the source or, backward, of the target."""
        if backward:
            plan = coarse_map(
                target, source, matches[:, ::-1], parameters.coarse_map, constraints and constraints.inverse
            )
            image = plan.argmax(axis=0)
        else:
            image = coarse_map(source, target, matches, parameters.coarse_map, constraints).argmax(axis=1)
        terms = cost_terms(source, target, image, parameters.cost)
        if constraints is not None:
            displacement = constraints.displacement(source, target, target.proxy[image])
            tolerance = constraints.parameters.displacement_tolerance
            terms["landmarks"] = float(np.maximum(displacement - tolerance, 0.0).mean())
        cost = total_cost(terms, parameters.cost.weights)
        return Alignment(target.proxy[image], terms, cost, share, constraints=constraints)

    def agreed(triplets: np.ndarray) -> np.ndarray:
        weights = votes.triplet_weights[triplets]
        return agreed_matches(pairs[triplets], weights, len(target.samples), clusters.most_matches)

    def quick_cost(matches: np.ndarray) -> float:
        image = quick_image(source, target, matches, parameters.coarse_map, constraints)
        step = parameters.coarse_map.quick_thinning
        return total_cost(cost_terms(source, target, image, parameters.cost, step), parameters.cost.weights)

    shares = [len(group) / len(pairs) for group in groups]
    matches = [agreed(group) for group in groups]
    # A long boundary may be that of a disc, or of a hole in a sphere as far as the triplets go: the cost decides.
    of_discs = disc_matches(source, target, parameters.discs, clusters) if with_extremities else []
    matches += of_discs
    shares += [0.0] * len(of_discs)
    found = map_threads(lambda i, _: aligned(matches[i], shares[i]), len(matches), jobs, None)
    least = min((one.cost for one in found), default=0.0)
    if least > selection.different_above:
        # A refinement that began well may have gone wrong. Other beginnings do not go wrong in the same way.
        order = sorted(range(len(found)), key=lambda i: found[i].cost)[: selection.most_contenders]
        near = [i for i in order if i < len(groups) and found[i].cost <= least + selection.contest_margin]
        tasks = [
            (i, part, backward)
            for i in near
            for part, backward in product((groups[i], most_consistent_half(pairs, distances, groups[i])), (True, False))
            if backward or part is not groups[i]
        ]
        variants = map_threads(lambda k, _: aligned(agreed(tasks[k][1]), 0.0, tasks[k][2]), len(tasks), jobs, None)
        for (i, _, _), variant in zip(tasks, variants, strict=True):
            found[i] = min(found[i], replace(variant, share=shares[i]), key=by_cost)
    if with_extremities and least > selection.different_above:
        # All of the triplets that were drawn may be wrong.
        extremities = extremity_triplets(
            source, target, parameters.extremities, parameters.cost.softening, parameters.voting
        )
        lists = [agreed_matches(*one, len(target.samples), clusters.most_matches) for one in extremities]
        lists = [matches for matches in lists if len(matches) > 2]
        costs = map_threads(lambda i, _: quick_cost(lists[i]), len(lists), jobs, None)
        best = np.argsort(costs, kind="stable")[: parameters.extremities.tried]
        found += map_threads(lambda k, _: aligned(lists[best[k]], 0.0), len(best), jobs, None)
        return distinct_alignments(target, found, clusters.radius / 2)
    if of_discs:
        return distinct_alignments(target, found, clusters.radius / 2)
    return sorted(found, key=by_cost)


def distinct_alignments(target: Surface, alignments: list[Alignment], radius: float) -> list[Alignment]:
    """Alignments, the cheapest first, without those whose images lie within a radius of a cheaper one's, on average.

    The radius is per sqrt(area) of the target.
    """
    places, kept = target.mesh.vertices / target.scale, list[Alignment]()
    for one in sorted(alignments, key=by_cost):
        distances = [np.linalg.norm(places[one.image] - places[other.image], axis=1).mean() for other in kept]
        nearest = int(np.argmin(distances)) if kept else 0
        if kept and distances[nearest] < radius:
            kept[nearest] = replace(kept[nearest], share=max(kept[nearest].share, one.share))
        else:
            kept.append(one)
    return kept


def alignments_with_landmarks(
    source: Surface,
    target: Surface,
    votes: Votes,
    settings: MatchSettings,
    parameters: AlignmentParameters,
    constraints: LandmarkConstraints | None,
) -> tuple[Votes, list[Alignment]]:
    """The candidate alignments, and the votes they come from, where landmarks may be known.

    If no candidate agrees with the landmarks, votes are cast once more, for samples at similar distances from them. If
    one does, the landmarks do not change the votes: between shapes of different proportions those distances mislead.
    """
    candidates = candidate_alignments(source, target, votes, parameters, constraints=constraints, jobs=settings.jobs)
    if constraints is None or (candidates and not candidates[0].cost_terms["landmarks"]):
        return votes, candidates
    disagreement = constraints.disagreement(source, target, source.samples, target.samples)
    settings = replace(settings, votes=votes.n_triplets)
    votes = cast_votes(source, target, settings, disagreement=disagreement, parameters=parameters.voting)
    candidates += candidate_alignments(source, target, votes, parameters, constraints=constraints, jobs=settings.jobs)
    return votes, distinct_alignments(target, candidates, parameters.clusters.radius / 2)
