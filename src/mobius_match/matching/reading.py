"""Section 8 and beyond: matches read off votes, off an alignment, or off the place of a part; and their dense maps."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..alignments.alignment import Alignment
from ..alignments.coarse_map import coarse_map
from ..errors import NothingFoundError
from ..geometry.points import SurfacePoints, closest_points
from ..landmarks.constraints import LandmarkConstraints
from ..registration.confidence import distances_to_images, match_probabilities
from ..results.surface_map import SurfaceMap
from ..settings import LEAST_PROBABILITY, LEAST_VOTES, MatchSettings
from ..surface.sampling import thin_out
from ..surface.surface import Surface
from ..voting.assignment import linear_assignment, max_row_column, normalized, recover
from ..voting.votes import Votes
from .parameters import Parameters
from .partial.part import PartMatch


def voted_matches(source: Surface, target: Surface, votes: Votes, settings: MatchSettings) -> dict[str, Any]:
    """Section 8 to the letter: pairs of samples, confidence as a share of the votes."""
    pairs, confidence, recovered = process(votes.matrix, source, target, settings)
    here, there = source.samples[pairs[:, 0]], target.samples[pairs[:, 1]]
    return {
        "pairs": np.stack([source.mesh.vertex_ids[here], target.mesh.vertex_ids[there]], axis=1),
        "confidence": confidence,
        "kind": np.where(recovered, "recovered", "voted"),
    }


def aligned_matches(
    source: Surface,
    target: Surface,
    votes: Votes,
    alignment: Alignment,
    settings: MatchSettings,
    parameters: Parameters,
    factor: float = 1.0,
) -> dict[str, Any]:
    """Places of the source's proxy under one alignment; confidence is the probability that they are right.

    A sample that section 8 pairs with a sample near its place is voted, and so are the points of the proxy that are
    nearest to it; other places are recovered: they follow from all others. Confidence is the probability of a place,
    were the alignment right, times the factor and the probability of the alignment.
    """
    registration = alignment.registered(source, target, parameters.alignment)
    distances = distances_to_images(source, target, registration)
    confidence = parameters.alignment.registration.confidence
    probability = factor * match_probabilities(source, target, registration, distances, confidence)
    scale = target.scale
    points = closest_points(
        target.mesh.vertices / scale, target.mesh.faces, registration.positions / scale, registration.image
    )
    voted = np.zeros(len(source.samples), bool)
    pairs, _ = assign(votes.matrix, settings)
    radius = settings.recovery_radius or MatchSettings.recovery_radius
    voted[pairs[:, 0]] = distances[pairs[:, 0], pairs[:, 1]] <= radius * target.diameter
    voted = voted[source.proxy_distances.argmin(axis=0)]
    return _reported(
        source,
        target,
        source.proxy,
        points,
        probability,
        voted,
        settings,
        of_alignment=alignment.probability,
        distances=source.proxy_geodesics,
    )


def part_matches(source: Surface, target: Surface, part: PartMatch, settings: MatchSettings) -> dict[str, Any]:
    """Places of the source's samples where one of the two surfaces is a part of the other."""
    voted = np.ones(len(source.samples), bool)
    return _reported(source, target, source.samples, part.points, part.match_probabilities, voted, settings)


def _reported(
    source: Surface,
    target: Surface,
    here: np.ndarray,
    points: SurfacePoints,
    probability: np.ndarray,
    voted: np.ndarray,
    settings: MatchSettings,
    of_alignment: float = 1.0,
    distances: np.ndarray | None = None,
) -> dict[str, Any]:
    """The likely ones among the places of source vertices (q,), the most confident first, no target vertex twice.

    Confidence is the probability times that of the alignment. By default the first alone decides on what is reported,
    so that a doubtful alignment can be looked at.
    With distances (q, q) between the vertices per sqrt(area), those that are not samples keep the spacing from all
    samples and from each other; the more confident one stays.
    """
    confidence = of_alignment * probability
    likely = probability >= LEAST_PROBABILITY if settings.threshold is None else confidence >= settings.threshold
    kept = np.flatnonzero(likely & (voted | (settings.recovery_radius > 0)))
    kept = kept[np.argsort(-probability[kept], kind="stable")]
    # Vertices of a cut, or of an envelope, can have one number in the user's mesh.
    kept = kept[np.sort(np.unique(source.mesh.vertex_ids[here[kept]], return_index=True)[1])]
    if distances is not None:
        kept = thin_out(distances, settings.spacing, np.isin(here[kept], source.samples), kept)
    points, mesh = points[kept], target.whole_mesh
    if target.detail is not None:
        points = target.detail.lifted(target.mesh, points)
    # Two neighbors may end at one vertex; the more confident one keeps it.
    _, first = np.unique(mesh.vertex_ids[points.nearest], return_index=True)
    first = np.sort(first)
    kept, there = kept[first], points[first]
    return {
        "pairs": np.stack([source.mesh.vertex_ids[here[kept]], mesh.vertex_ids[there.nearest]], axis=1),
        "confidence": confidence[kept],
        "kind": np.where(voted, "voted", "recovered")[kept],
        "target_points": SurfacePoints(mesh.face_ids[there.faces], mesh.vertex_ids[there.corners], there.barycentric),
    }


def dense_map_of_part(part: PartMatch, parameters: Parameters) -> SurfaceMap:
    """The dense map from source to target where one of them is a part of the other."""
    from ..registration.dense import dense_map

    registration = parameters.alignment.registration
    dense = dense_map(part.part, part.whole, part.registration, registration, whole=False)
    return dense if part.part_is_source else dense.inverse


def dense_map_of_whole(
    source: Surface,
    target: Surface,
    votes: Votes,
    alignments: list[Alignment],
    settings: MatchSettings,
    parameters: Parameters,
    constraints: LandmarkConstraints | None,
) -> SurfaceMap:
    """The dense map along the first alignment; without one, along the matches of the samples."""
    from ..alignments.dense import dense_map_of_alignment

    if alignments:
        return dense_map_of_alignment(source, target, alignments[0], parameters.alignment)
    alignment = alignment_of_votes(source, target, votes, settings, parameters, constraints)
    return dense_map_of_alignment(source, target, alignment, parameters.alignment)


def alignment_of_votes(
    source: Surface,
    target: Surface,
    votes: Votes,
    settings: MatchSettings,
    parameters: Parameters,
    constraints: LandmarkConstraints | None = None,
) -> Alignment:
    """The alignment along the matches of the samples."""
    constants = parameters.alignment
    pairs, _ = assign(votes.matrix, settings)
    pairs = pairs[: constants.clusters.most_matches]
    image = target.proxy[coarse_map(source, target, pairs, constants.coarse_map, constraints).argmax(axis=1)]
    return Alignment(image, {}, 0.0, 1.0, constraints=constraints)


def process(
    matrix: np.ndarray, source: Surface, target: Surface, settings: MatchSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Section 8: the matrix C to pairs of samples (Q, 2), their confidence (Q,) and which were recovered (Q,) bool.

    Raises
    ------
    NothingFoundError
        If C has no entry above zero.
    """
    pairs, confidence = assign(matrix, settings)
    if not len(pairs):
        raise NothingFoundError(
            f"{source.mesh.name} and {target.mesh.name}: none of {settings.number_of_votes()} triplets of points "
            "gained a vote; lower `min_fraction` or raise `votes`, or the shapes have too little in common"
        )
    threshold = LEAST_VOTES if settings.threshold is None else settings.threshold
    trusted = confidence >= threshold
    delta = settings.recovery_radius
    recovered = recover(
        pairs, trusted, source.distances, target.distances, delta * source.diameter, delta * target.diameter
    )
    keep = trusted | recovered
    return pairs[keep], confidence[keep], recovered[keep]


def assign(matrix: np.ndarray, settings: MatchSettings) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of samples (Q, 2) from the matrix C, and their shares of the most votes (Q,)."""
    choose = max_row_column if settings.assignment == "greedy" else linear_assignment
    return choose(normalized(matrix))
