"""The whole method: two meshes in, correspondences out."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from .._core.threads import Progress, map_threads
from .._core.versions import software
from ..alignments.alignment import Alignment
from ..alignments.candidates import alignments_with_landmarks
from ..alignments.coarse_map import coarse_map
from ..alignments.groups import TRUSTED
from ..alignments.selection import ambiguity_warnings, rerank_by_registration
from ..errors import NothingFoundError, SettingsError
from ..geometry.points import SurfacePoints, closest_points
from ..landmarks.constraints import LandmarkConstraints, landmark_constraints, with_given_pairs
from ..registration.confidence import distances_to_images, match_probabilities
from ..results.correspondence import Alternative, Correspondence
from ..settings import MatchSettings, make_settings
from ..surface.prepare import begin_preparation, complete_preparation
from ..surface.sampling import thin_out
from ..surface.surface import Surface
from ..voting.assignment import linear_assignment, max_row_column, normalized, recover
from ..voting.votes import Votes, cast_votes
from .partial.part import DISTRUST, LACKING, PartMatch, both_incomplete, match_part
from .partial.place import OPEN, boundary_length

if TYPE_CHECKING:
    from ..results.surface_map import SurfaceMap

VOTES_THRESHOLD = 0.1
"""Confidence S, as a share of the votes, below which a pair needs the others to bear it out (section 8)."""

CHANCE_THRESHOLD = 0.5
"""Confidence, as a chance of being right, below which a match under an explanation is left out."""

ALIKE = 1.0
"""Badness of an explanation below which two open surfaces are the same as wholes, and neither a part of the other."""


def match(
    source: Any,
    target: Any,
    *,
    preset: str | None = None,
    landmarks: Any = None,
    cache: bool = False,
    progress: Progress | None = None,
    **settings: Any,
) -> Correspondence:
    """Find which vertex of one surface is which vertex of another.

    Parameters
    ----------
    source, target
        Each a path of a mesh file, ``(vertices, faces)``, any object with both, or a prepared :class:`Surface` or the
        file (.npz) of one, which keep the preparation that they were made with.
    preset
        ``"paper"`` for the settings of the publication.
    landmarks
        Pairs that are known: (k, 2) vertex numbers counting from 0, a file of pairs, or the source's and the target's
        files of landmarks; see :func:`mobius_match.landmarks.constraints.landmark_constraints`. They are in the result
        with confidence 1, and guide all other matches.
    cache
        Take the surfaces of mesh files from the cache if they were prepared before, else keep them there. The result
        does not depend on it.
    progress
        Called as ``progress(stage, done, total)`` from the calling thread.
    **settings
        The fields of :class:`MatchSettings`; they override the preset's.

    Returns
    -------
    Correspondence
        The pairs, the most confident first.

    Raises
    ------
    MeshError
        If a mesh cannot be read or used.
    SettingsError
        If a setting is unknown or out of range.
    NothingFoundError
        If no triplet of points gained a vote, or no match is likely enough to be right.

    Examples
    --------
    >>> import mobius_match as mm
    >>> from mobius_match import examples
    >>> result = mm.match(*examples.paths("person"), seed=0)
    >>> result.pairs.shape[1]
    2
    """
    chosen = make_settings(preset, **settings)
    guided = chosen.proposal == "guided"
    if landmarks is not None and not guided:
        raise SettingsError("landmarks guide triplets, and uniform ones (the paper's) are not guided; leave one out")
    start = time.perf_counter()
    # Both are read and checked before the work on either begins.
    preparation = chosen.preparation()
    things = source, target
    begun = map_threads(lambda i, _: begin_preparation(things[i], preparation, cache), 2, chosen.jobs, progress)
    timings = {"reading": time.perf_counter() - start}
    begin = time.perf_counter()
    surfaces = map_threads(
        lambda i, tell: complete_preparation(things[i], begun[i], preparation, cache, tell), 2, chosen.jobs, progress
    )
    for side, half, surface in zip(("source", "target"), begun, surfaces, strict=True):
        if half is not surface:
            timings |= {f"{side} {name}": seconds for name, seconds in surface.timings.items()}
    timings["preparation"] = time.perf_counter() - begin
    first, second = surfaces
    begin = time.perf_counter()
    constraints, notes = (None, []) if landmarks is None else landmark_constraints(landmarks, first, second)
    votes = cast_votes(first, second, chosen, progress)
    timings["voting"] = time.perf_counter() - begin
    begin = time.perf_counter()
    # One BLAS thread: sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        # The paper's own voting knows whole surfaces only.
        places, of_parts = match_part(first, second, chosen.seed, chosen.jobs, constraints) if guided else (None, [])
        found: list[Alignment] = []
        if places is None or boundary_length(places.whole) > OPEN:
            votes, found = alignments_with_landmarks(first, second, votes, chosen, constraints)
            if places and found and found[0].cost < ALIKE:
                places, of_parts = None, []
            if not places and found and both_incomplete(first, second, found[0].cost):
                of_parts.append(LACKING)
            found = [] if places else rerank_by_registration(first, second, found, chosen.jobs)
        timings["alignments"] = time.perf_counter() - begin
        begin = time.perf_counter()
        if places:
            here, voted = first.samples, np.ones(len(first.samples), bool)
            matches = _reported(first, second, here, places.points, places.match_probabilities, voted, chosen)
        elif found:
            matches = _explained(first, second, votes, found[0], chosen, DISTRUST if LACKING in of_parts else 1.0)
        else:
            matches = _voted(first, second, votes, chosen)
        matches = with_given_pairs(matches, constraints, second)
    if not len(matches["pairs"]):
        raise NothingFoundError(
            f"{first.mesh.name} and {second.mesh.name}: no match is likely enough to be right; lower --threshold, or "
            "the shapes have too little in common" + "".join(f" ({note})" for note in of_parts)
        )
    timings["matches"] = time.perf_counter() - begin
    timings["total"] = time.perf_counter() - start
    return Correspondence(
        **matches,
        source_info=first.info,
        target_info=second.info,
        settings={
            **chosen.to_dict(),
            "preset": preset,
            "votes": votes.n_triplets,
            **({} if constraints is None else {"landmarks": constraints.pairs.tolist()}),
        },
        timings=timings,
        software=dict(software()),
        diagnostics={
            "source closure": first.closure,
            "target closure": second.closure,
            "triplets": votes.n_triplets,
            "voting triplets": votes.n_voting,
        },
        warnings=(*first.notes, *second.notes, *votes.warnings, *of_parts, *notes, *ambiguity_warnings(found)),
        others=partial(_alternatives, first, second, votes, found, chosen),
        spread=partial(_spread, first, second, votes, places or found, chosen, constraints),
        source=first,
        target=second,
        votes=votes,
    )


def _voted(source: Surface, target: Surface, votes: Votes, settings: MatchSettings) -> dict[str, Any]:
    """Section 8 to the letter: pairs of samples, confidence as a share of the votes."""
    pairs, confidence, recovered = process(votes.matrix, source, target, settings)
    here, there = source.samples[pairs[:, 0]], target.samples[pairs[:, 1]]
    return {
        "pairs": np.stack([source.mesh.vertex_ids[here], target.mesh.vertex_ids[there]], axis=1),
        "confidence": confidence,
        "kind": np.where(recovered, "recovered", "voted"),
    }


def _explained(
    source: Surface,
    target: Surface,
    votes: Votes,
    alignment: Alignment,
    settings: MatchSettings,
    trust: float = 1.0,
) -> dict[str, Any]:
    """Places of the source's proxy under one explanation, confidence as the chance that they are right.

    All chances are multiplied by ``trust``.

    A sample that section 8 pairs with a sample near its place is voted, and so are the points that are nearest to it;
    another place is recovered from all others.
    """
    registration = alignment.registered(source, target)
    distances = distances_to_images(source, target, registration)
    probability = trust * match_probabilities(source, target, registration, distances)
    scale = np.sqrt(target.area)
    points = closest_points(
        target.mesh.vertices / scale, target.mesh.faces, registration.positions / scale, registration.image
    )
    voted = np.zeros(len(source.samples), bool)
    pairs, _ = _assign(votes.matrix, settings)
    radius = settings.recovery_radius or MatchSettings.recovery_radius
    voted[pairs[:, 0]] = distances[pairs[:, 0], pairs[:, 1]] <= radius * target.diameter
    voted = voted[source.proxy_distances.argmin(axis=0)]
    return _reported(source, target, source.proxy, points, probability, voted, settings, source.proxy_geodesics)


def _reported(
    source: Surface,
    target: Surface,
    here: np.ndarray,
    points: SurfacePoints,
    probability: np.ndarray,
    voted: np.ndarray,
    settings: MatchSettings,
    ways: np.ndarray | None = None,
) -> dict[str, Any]:
    """The likely ones among the places of source vertices (q,), the most confident first, no target vertex twice.

    With the ways (q, q) between these per sqrt(area): of those that are not samples none that is closer than the
    spacing to a sample, or to a more confident one.
    """
    threshold = CHANCE_THRESHOLD if settings.threshold is None else settings.threshold
    kept = np.flatnonzero((probability >= threshold) & (voted | (settings.recovery_radius > 0)))
    kept = kept[np.argsort(-probability[kept], kind="stable")]
    if ways is not None:
        kept = thin_out(ways, settings.spacing, np.isin(here[kept], source.samples), kept)
    points, mesh = points[kept], target.whole_mesh
    if target.detail is not None:
        points = target.detail.lifted(target.mesh, points)
    # Two neighbours may end at one vertex; the more confident one keeps it.
    _, first = np.unique(points.nearest, return_index=True)
    first = np.sort(first)
    kept, there = kept[first], points[first]
    return {
        "pairs": np.stack([source.mesh.vertex_ids[here[kept]], mesh.vertex_ids[there.nearest]], axis=1),
        "confidence": probability[kept],
        "kind": np.where(voted, "voted", "recovered")[kept],
        "target_points": SurfacePoints(mesh.face_ids[there.faces], mesh.vertex_ids[there.corners], there.barycentric),
    }


def _spread(
    source: Surface,
    target: Surface,
    votes: Votes,
    found: list[Alignment] | PartMatch,
    settings: MatchSettings,
    constraints: LandmarkConstraints | None,
) -> SurfaceMap:
    """The dense map under the chosen explanation; without one, under the matches of the samples."""
    from ..alignments.dense import dense_map_of_alignment
    from ..registration.dense import dense_map

    with threadpool_limits(limits=1, user_api="blas"):
        if isinstance(found, PartMatch):
            of_part = dense_map(found.part, found.whole, found.registration, whole=False)
            found_map = of_part if found.part_is_source else of_part.inverse
            return found_map if constraints is None else found_map.with_pairs(*constraints.whole_vertices)
        if not found:
            pairs, _ = _assign(votes.matrix, settings)
            image = target.proxy[coarse_map(source, target, pairs[:TRUSTED], constraints).argmax(axis=1)]
            found = [Alignment(image, {}, 0.0, 1.0, constraints=constraints)]
        along = dense_map_of_alignment(source, target, found[0])
        return along if constraints is None else along.with_pairs(*constraints.whole_vertices)


def _alternatives(
    source: Surface, target: Surface, votes: Votes, found: list[Alignment], settings: MatchSettings
) -> tuple[Alternative, ...]:
    """The matches under the explanations that lost."""
    with threadpool_limits(limits=1, user_api="blas"):
        return tuple(
            Alternative(
                **with_given_pairs(_explained(source, target, votes, one, settings), one.constraints, target),
                margin=one.cost - found[0].cost,
                share=one.share,
            )
            for one in found[1:]
        )


def process(
    matrix: np.ndarray, source: Surface, target: Surface, settings: MatchSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Section 8: the matrix C to pairs of samples (Q, 2), their confidence (Q,) and which were recovered (Q,) bool.

    Raises
    ------
    NothingFoundError
        If C has no entry above zero.
    """
    pairs, confidence = _assign(matrix, settings)
    if not len(pairs):
        raise NothingFoundError(
            f"{source.mesh.name} and {target.mesh.name}: none of {settings.number_of_votes()} triplets of points "
            "gained a vote; lower --min-fraction or raise --votes, or the shapes have too little in common"
        )
    threshold = VOTES_THRESHOLD if settings.threshold is None else settings.threshold
    trusted = confidence >= threshold
    delta = settings.recovery_radius
    recovered = recover(
        pairs, trusted, source.distances, target.distances, delta * source.diameter, delta * target.diameter
    )
    keep = trusted | recovered
    return pairs[keep], confidence[keep], recovered[keep]


def _assign(matrix: np.ndarray, settings: MatchSettings) -> tuple[np.ndarray, np.ndarray]:
    choose = max_row_column if settings.assignment == "greedy" else linear_assignment
    return choose(normalized(matrix))
