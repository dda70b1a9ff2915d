"""The whole method: two meshes in, correspondences out."""

from __future__ import annotations

import platform
import time
from importlib.metadata import version
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from .correspondence import Alternative, Correspondence
from .errors import NothingFoundError
from .hypotheses import Explanation, agreement, explanations, finer_targets
from .matrix_processing import linear_assignment, max_row_column, normalized, recover
from .settings import MatchSettings, make_settings
from .surface import Progress, Surface, matchable, prepare_mesh
from .voting import Votes, cast_votes

DEFAULT_THRESHOLD = 0.1
"""Confidence S below which a pair needs the others to bear it out."""

AGREEMENT_RADIUS = 0.1
"""Distance per sqrt(area) from where the chosen explanation sends a sample, at which a vote counts 1 / e."""

CLOSE = 0.15
"""Difference of two explanations' badness below which the choice between them is called close."""


def match(
    source: Any,
    target: Any,
    *,
    preset: str | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Correspondence:
    """Find which vertex of one surface is which vertex of another.

    Parameters
    ----------
    source, target
        Each a path of a mesh file, ``(vertices, faces)``, any object with both, or a prepared :class:`Surface`,
        which keeps the preparation that it was made with.
    preset
        ``"paper"`` for the settings of the publication.
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
        If no triplet of points gained a vote.

    Examples
    --------
    >>> import mobius_match as mm
    >>> from mobius_match import examples
    >>> result = mm.match(*examples.paths("person"), seed=0)
    >>> result.pairs.shape[1]
    2
    """
    chosen = make_settings(preset, **settings)
    start = time.perf_counter()
    # Both are read and checked before the work on either begins.
    things = [thing if isinstance(thing, Surface) else matchable(thing) for thing in (source, target)]
    timings = {"reading": time.perf_counter() - start}
    surfaces = []
    for side, thing in zip(("source", "target"), things, strict=True):
        if isinstance(thing, Surface):
            surfaces.append(thing)
        else:
            surfaces.append(prepare_mesh(thing, chosen.preparation(), progress))
            timings |= {f"{side} {name}": seconds for name, seconds in surfaces[-1].timings.items()}
    first, second = surfaces
    begin = time.perf_counter()
    votes = cast_votes(first, second, chosen, progress)
    timings["voting"] = time.perf_counter() - begin
    begin = time.perf_counter()
    # One BLAS thread: sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        found = explanations(first, second, votes)
        timings["explanations"] = time.perf_counter() - begin
        begin = time.perf_counter()
        matches = [_pairs(first, second, votes, explanation, chosen) for explanation in found or (None,)]
    timings["matrix processing"] = time.perf_counter() - begin
    pairs, confidence, kind = matches[0]
    timings["total"] = time.perf_counter() - start
    return Correspondence(
        pairs=pairs,
        confidence=confidence,
        kind=kind,
        source_info=_describe(first),
        target_info=_describe(second),
        settings={**chosen.to_dict(), "preset": preset, "votes": votes.n_triplets},
        timings=timings,
        software={name: version(name) for name in ("mobius-match", "numpy", "scipy", "numba", "libigl", "potpourri3d")}
        | {"python": platform.python_version()},
        diagnostics={
            "source closure": first.closure,
            "target closure": second.closure,
            "triplets": votes.n_triplets,
            "voting triplets": votes.n_voting,
        },
        warnings=(*_notes(first), *_notes(second), *votes.warnings, *_doubts(found)),
        alternatives=tuple(
            Alternative(*lists, explanation.badness - found[0].badness, explanation.share)
            for explanation, lists in zip(found[1:], matches[1:], strict=True)
        ),
        source=first,
        target=second,
        votes=votes,
    )


def _pairs(
    source: Surface, target: Surface, votes: Votes, explanation: Explanation | None, settings: MatchSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Section 8 under one explanation: pairs in the user's numbers (Q, 2), confidence (Q,) and kind (Q,).

    Votes count by how well they agree with the explanation, and each match moves from the target's sample to the
    vertex that the explanation sends its source to. Without explanation it is section 8 alone.
    """
    matrix = votes.matrix
    if explanation is not None:
        matrix = matrix * agreement(source, target, explanation, AGREEMENT_RADIUS)
    pairs, confidence, recovered = process(matrix, source, target, settings)
    here, there = source.samples[pairs[:, 0]], target.samples[pairs[:, 1]]
    if explanation is not None:
        # Maxima of curvature (tips of ears and toes) mark the same points on both surfaces already; the map of few
        # eigenfunctions would blur them.
        features = (pairs[:, 0] < source.n_maxima) & (pairs[:, 1] < target.n_maxima)
        there = np.where(features, there, finer_targets(source, target, explanation, here))
        # Two neighbours may end at one vertex; the more confident one keeps it.
        _, first = np.unique(there, return_index=True)
        first.sort()
        here, there, confidence, recovered = here[first], there[first], confidence[first], recovered[first]
    users = np.stack([source.mesh.vertex_ids[here], target.mesh.vertex_ids[there]], axis=1)
    return users, confidence, np.where(recovered, "recovered", "voted")


def process(
    matrix: np.ndarray, source: Surface, target: Surface, settings: MatchSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Section 8: the matrix C to pairs of samples (Q, 2), their confidence (Q,) and which were recovered (Q,) bool.

    Raises
    ------
    NothingFoundError
        If C has no entry above zero.
    """
    choose = max_row_column if settings.assignment == "greedy" else linear_assignment
    pairs, confidence = choose(normalized(matrix))
    if not len(pairs):
        raise NothingFoundError(
            f"{source.mesh.name} and {target.mesh.name}: none of {settings.number_of_votes()} triplets of points "
            "gained a vote; lower --min-fraction or raise --votes, or the shapes have too little in common"
        )
    threshold = DEFAULT_THRESHOLD if settings.threshold is None else settings.threshold
    trusted = confidence >= threshold
    delta = settings.recovery_radius
    recovered = recover(
        pairs, trusted, source.distances, target.distances, delta * source.diameter, delta * target.diameter
    )
    keep = trusted | recovered
    return pairs[keep], confidence[keep], recovered[keep]


def _doubts(found: list[Explanation]) -> list[str]:
    if len(found) < 2 or found[1].badness - found[0].badness > CLOSE:
        return []
    margin = found[1].badness - found[0].badness
    return [
        f"another explanation of the two shapes is nearly as good (it lost by {margin:.2f}; below {CLOSE} is close): "
        "look at the matches, and at the alternatives"
    ]


def _notes(surface: Surface) -> list[str]:
    return [f"{surface.mesh.name}: {note}" for note in (*surface.mesh.notes, *surface.warnings)]


def _describe(surface: Surface) -> dict[str, Any]:
    mesh = surface.mesh
    return {
        "path": None if mesh.path is None else str(mesh.path),
        "sha256": mesh.sha256,
        "vertices": mesh.n_file_vertices,
        "faces": mesh.n_file_faces,
        "area": surface.area,
        "diameter": surface.diameter,
    }
