"""The whole method: two meshes in, correspondences out, in the stages of the paper's overview (section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Unpack

from threadpoolctl import threadpool_limits

from .._core.threads import Progress, map_threads
from .._core.timing import Stopwatch
from .._core.versions import software
from ..alignments.alignment import Alignment
from ..alignments.selection import choice_warnings
from ..errors import NothingFoundError, SettingsError
from ..landmarks.constraints import LandmarkConstraints, landmark_constraints, with_given_pairs
from ..results.correspondence import Correspondence
from ..results.matches import Alternative
from ..results.surface_map import SurfaceMap
from ..settings import MatchOptions, MatchSettings, Preset, make_settings
from ..surface.prepare import begin_preparation, complete_preparation
from ..surface.prepared import check_effective, settings_used
from ..surface.surface import Surface
from ..voting.votes import cast_votes
from .handles import best_reading
from .outcome import Outcome, align
from .parameters import Parameters
from .partial.coverage import Coverage
from .pieces.main_pair import choose_main_pair
from .pieces.search import PieceSearch, without_preparation
from .pieces.whole import with_all_pieces
from .reading import aligned_matches, dense_map_of_part, dense_map_of_whole, part_matches, voted_matches
from .reflection import costs, match_reflected


def match(
    source: Any,
    target: Any,
    *,
    preset: Preset | None = None,
    landmarks: Any = None,
    cache: bool = False,
    progress: Progress | None = None,
    parameters: Parameters = Parameters(),
    **settings: Unpack[MatchOptions],
) -> Correspondence:
    """Find matching points between two surfaces.

    Parameters
    ----------
    source, target
        Each a path of a mesh file, ``(vertices, faces)`` as arrays of shapes (n, 3) and (m, 3), any object that has
        both, or a prepared :class:`Surface` or the file (.npz) of one. Prepared surfaces are used as they are.
    preset
        ``"paper"`` for the settings of the publication.
    landmarks
        Known pairs: (k, 2) vertex numbers counting from 0, a file of pairs, or the source's and the target's files of
        landmarks; see :func:`mobius_match.landmarks.constraints.landmark_constraints`. They are in the result with
        confidence 1, and guide all other matches.
    cache
        If a mesh file was prepared before, read its surface from the cache; else store it there. The result does not
        depend on it.
    progress
        Called as ``progress(stage, done, total)`` from the calling thread.
    parameters
        The constants of the method, for those who study it; the defaults are the method.
    **settings
        The fields of :class:`MatchSettings`; they override the preset's.

    Returns
    -------
    Correspondence
        The pairs, the most confident first. Its settings are those that took effect: of a prepared surface, the ones
        that it was prepared with.

    Raises
    ------
    MeshError
        If a mesh cannot be read or used.
    SettingsError
        If a setting is unknown or out of range, or was given and a prepared surface has another value of it.
    NothingFoundError
        If no triplet of points gained a vote, or no match is likely enough to be right.

    References
    ----------
    Y. Lipman and T. Funkhouser, "Möbius Voting for Surface Correspondence", ACM Transactions on Graphics 28 (3), 2009.

    Examples
    --------
    >>> import mobius_match as mm
    >>> from mobius_match import examples
    >>> result = mm.match(*examples.paths("person"), seed=0)
    >>> result.pairs.shape[1]
    2
    """
    chosen = make_settings(preset, **settings)
    if landmarks is not None and chosen.proposal != "guided":
        raise SettingsError("`landmarks` need guided proposals, and `proposal` is 'uniform'; leave one of the two out")
    clock = Stopwatch()
    first, second = _prepared((source, target), chosen, settings, preset, cache, progress, parameters, clock)
    chosen, target_preparation, of_preparation = settings_used(chosen, first.settings, second.settings)
    again = partial(match, parameters=parameters, **without_preparation(chosen))
    if chosen.reflect != "no":
        recorded = {"reflect": chosen.reflect, "preset": preset}
        all_pieces = {"pieces": "all"} if chosen.pieces == "all" else {}
        run = partial(again, progress=progress, **{"reflect": "no"} | all_pieces)
        return match_reflected(run, first, second, landmarks, parameters, recorded, clock)
    search = PieceSearch(again, chosen, parameters.surface, parameters.alignment, parameters.pieces)
    if landmarks is None and (of_main := choose_main_pair(first, second, search)) is not None:
        return with_all_pieces(*of_main, search)

    def explain(one: Surface, two: Surface) -> tuple[list[Alignment], _Explained]:
        constraints, of_landmarks = None, list[str]()
        if landmarks is not None:
            constraints, of_landmarks = landmark_constraints(landmarks, one, two, parameters.alignment.landmarks)
        votes = cast_votes(one, two, chosen, progress, parameters=parameters.alignment.voting)
        clock.lap("voting")
        # One BLAS thread: sums must not depend on the number of processors.
        with threadpool_limits(limits=1, user_api="blas"):
            outcome = align(one, two, votes, chosen, parameters, constraints)
        clock.lap("alignments")
        return outcome.alignments, (outcome, constraints, of_landmarks)

    first, second, explained, of_handles = best_reading(first, second, explain, parameters)
    outcome, constraints, of_landmarks = explained
    with threadpool_limits(limits=1, user_api="blas"):
        matches = read_matches(first, second, outcome, chosen, parameters)
        matches = with_given_pairs(matches, constraints, second)
    if not len(matches["pairs"]):
        raise NothingFoundError(
            f"{first.mesh.name} and {second.mesh.name}: no match is likely enough to be right; lower `threshold`, or "
            "the shapes have too little in common" + "".join(f" ({note})" for note in outcome.notes)
        )
    clock.lap("matches")
    given = {} if constraints is None else {"landmarks": constraints.pairs.tolist()}
    result = Correspondence(
        **matches,
        source_info=first.info,
        target_info=second.info,
        settings={
            **chosen.to_dict(),
            **target_preparation,
            "preset": preset,
            "votes": outcome.votes.n_triplets,
            **given,
        },
        timings=clock.with_total(),
        software=dict(software()),
        diagnostics={
            "source closure": first.closure,
            "target closure": second.closure,
            "triplets": outcome.votes.n_triplets,
            "voting triplets": outcome.votes.n_voting,
        },
        warnings=(
            *first.notes,
            *second.notes,
            *of_preparation,
            *outcome.votes.warnings,
            *outcome.notes,
            *of_landmarks,
            *of_handles,
            *choice_warnings(outcome.alignments, parameters.alignment),
        ),
        _costs=partial(costs, first, second, outcome.votes, outcome.alignments, outcome.part, chosen, parameters),
        _make_alternatives=partial(_alternatives, first, second, outcome, chosen, parameters),
        _make_dense=partial(_dense_map, first, second, outcome, chosen, parameters, constraints),
        probability=outcome.probability,
        symmetry={"order": outcome.order} if outcome.order > 1 else None,
        source=first,
        target=second,
        votes=outcome.votes,
    )
    return with_all_pieces(result, [], search)


_Explained = tuple[Outcome, LandmarkConstraints | None, list[str]]


def _prepared(
    meshes: tuple[Any, Any],
    settings: MatchSettings,
    given: Mapping[str, Any],
    preset: Preset | None,
    cache: bool,
    progress: Progress | None,
    parameters: Parameters,
    clock: Stopwatch,
) -> tuple[Surface, Surface]:
    """Sections 4 and 5: both surfaces. Both meshes are read and checked before the work on either begins."""
    preparation, jobs = settings.preparation(), settings.jobs
    begun = map_threads(
        lambda i, _: begin_preparation(meshes[i], preparation, cache, parameters.surface), 2, jobs, progress
    )
    for argument, one in zip(("source", "target"), begun, strict=True):
        check_effective(one, argument, given, preset)
    clock.lap("reading")
    first, second = map_threads(
        lambda i, report: complete_preparation(meshes[i], begun[i], preparation, cache, report, parameters.surface),
        2,
        jobs,
        progress,
    )
    for side, one, surface in zip(("source", "target"), begun, (first, second), strict=True):
        if one is not surface:
            clock.add({f"{side} {name}": seconds for name, seconds in surface.timings.items()})
    clock.lap("preparation")
    return first, second


def read_matches(
    source: Surface, target: Surface, outcome: Outcome, settings: MatchSettings, parameters: Parameters
) -> dict[str, Any]:
    """Section 8, and what goes beyond it: the matches, the most confident first, as fields of the result."""
    if outcome.part is not None:
        return part_matches(source, target, outcome.part, settings)
    if not outcome.alignments:
        return voted_matches(source, target, outcome.votes, settings)
    factor = parameters.partial.incomplete_factor if outcome.coverage is Coverage.BOTH_INCOMPLETE else 1.0
    return aligned_matches(source, target, outcome.votes, outcome.alignments[0], settings, parameters, factor)


def _dense_map(
    source: Surface,
    target: Surface,
    outcome: Outcome,
    settings: MatchSettings,
    parameters: Parameters,
    constraints: LandmarkConstraints | None,
) -> SurfaceMap:
    """The dense map of the chosen alignment, through the landmarks."""
    with threadpool_limits(limits=1, user_api="blas"):
        if outcome.part is not None:
            dense = dense_map_of_part(outcome.part, parameters)
        else:
            dense = dense_map_of_whole(
                source, target, outcome.votes, outcome.alignments, settings, parameters, constraints
            )
    return dense if constraints is None else dense.with_pairs(*constraints.whole_vertices)


def _alternatives(
    source: Surface, target: Surface, outcome: Outcome, settings: MatchSettings, parameters: Parameters
) -> tuple[Alternative, ...]:
    """The matches of the alignments that were not chosen."""
    with threadpool_limits(limits=1, user_api="blas"):
        return tuple(
            Alternative(
                **with_given_pairs(
                    aligned_matches(source, target, outcome.votes, one, settings, parameters), one.constraints, target
                ),
                probability=one.probability,
                margin=one.cost - outcome.alignments[0].cost,
                share=one.share,
            )
            for one in outcome.alignments[1:]
        )
