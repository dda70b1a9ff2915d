"""Left against right: the mirror image of the source is matched, or both, of which the better one is taken.

The mirror image needs no preparation of its own (:mod:`mobius_match.surface.reflected`), and nothing between
preparation and result knows that it is one. The result is then told in the coordinates of the user's own source.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from .._core.timing import Stopwatch
from ..alignments.alignment import Alignment
from ..alignments.cost import registered_map_cost
from ..alignments.evidence import evidence, log_odds
from ..alignments.parameters import SelectionParameters
from ..errors import MobiusError
from ..landmarks.pairs import given_pairs
from ..results.correspondence import Correspondence
from ..results.reflected import with_mirrored_source
from ..settings import MatchSettings
from ..surface.reflected import reflected
from ..surface.surface import Surface
from ..voting.votes import Votes
from .parameters import Parameters
from .partial.coverage import may_be_part
from .partial.decision import whole_error
from .partial.part import PartMatch
from .pieces.search import surfaces_of
from .reading import alignment_of_votes


def match_reflected(
    run: Callable[..., Correspondence],
    source: Surface,
    target: Surface,
    landmarks: Any,
    parameters: Parameters,
    recorded: Mapping[str, Any],
    clock: Stopwatch,
) -> Correspondence:
    """Match the mirror image of the source, or the source and its mirror image.

    Parameters
    ----------
    run
        Matches two surfaces as they are, with known pairs as ``landmarks``.
    source, target
        The surfaces.
    landmarks
        As in :func:`.match.match`. Positions in files are those on the source itself.
    parameters
        The constants.
    recorded
        Settings of the result. With ``reflect`` "yes" the mirror image is matched, with "auto" both; it is taken if it
        fits clearly better.
    clock
        Durations up to here.

    Returns
    -------
    Correspondence
        The result, in the coordinates of the source itself.

    Raises
    ------
    MobiusError
        As :func:`.match.match`; with "auto" only if neither can be matched.
    """
    notes, diagnostics = list[str](), dict[str, float]()
    if landmarks is not None:
        landmarks, notes = given_pairs(landmarks, (source.whole_mesh, target.whole_mesh))
    image = reflected(source)
    both = (image,) if recorded["reflect"] == "yes" else (source, image)
    results, errors = dict[Surface, Correspondence](), list[MobiusError]()
    for one in both:
        try:
            results[one] = run(one, target, landmarks=landmarks)
        except MobiusError as error:
            errors.append(error)
    if not results:
        raise errors[0]
    mirrored, line = image in results, f"{source.mesh.name}: its mirror image was matched"
    if len(both) > 1:
        probability = float(mirrored)
        if not errors:
            probability, mirrored = reflection_probability(
                results[source], results[image], parameters.alignment.selection
            )
        diagnostics, line = {"reflected probability": probability}, f"{line} (probability {probability:.2f})"
    result = results[image if mirrored else source]
    if mirrored:
        result = _of_source(result, source, image)
    return replace(
        result,
        settings={**result.settings, **recorded},
        diagnostics=result.diagnostics | diagnostics,
        timings=result.timings | clock.with_total(),
        warnings=(*result.warnings, *notes, *([line] if mirrored else [])),
    )


def _of_source(result: Correspondence, source: Surface, image: Surface) -> Correspondence:
    """The result of a mirror image in the coordinates of the source itself."""
    matched = surfaces_of(result)[0]  # of several readings and pieces it need not be the one that was given
    return replace(
        result,
        source=source if matched is image else reflected(matched),
        reflected=True,
        _make_dense=lambda: with_mirrored_source(result.dense()),
    )


def reflection_probability(
    as_it_is: Correspondence, mirrored: Correspondence, parameters: SelectionParameters
) -> tuple[float, bool]:
    """The probability that it is the mirror image of the source that corresponds to the target, and if that is clear.

    By the costs of the two results, of the first kind that both have; 0.5 if there is none. The score of a registration
    has its noise, so that its mirror image has to be beyond doubt; other costs have to differ more than readings of
    handles that fit equally well.
    """
    one, other = ({} if result._costs is None else result._costs() for result in (as_it_is, mirrored))
    name = next((name for name in one if name in other), None)
    difference = 0.0 if name is None else one[name] - other[name]
    probability = odds(difference)
    clear = probability >= parameters.sure_above if name == "registration" else difference > parameters.close_cost
    return probability, clear


def odds(difference: float) -> float:
    """The logistic function of a difference in cost."""
    return float(1 + np.tanh(difference / 2)) / 2


def costs(
    source: Surface,
    target: Surface,
    votes: Votes,
    alignments: list[Alignment],
    part: PartMatch | None,
    settings: MatchSettings,
    parameters: Parameters,
) -> dict[str, float]:
    """What a match of two pieces costs, by kind, so that it can be compared with that of the mirror image.

    Parameters
    ----------
    source, target
        The surfaces.
    votes
        The votes.
    alignments
        The alignments of two wholes, the chosen one first; none for a part, or with uniform proposals.
    part
        Where a part lies.
    settings, parameters
        The settings and the constants.
    """
    if part is not None:
        return {"coverage": _log(part.cost)}
    constants = parameters.alignment
    with threadpool_limits(limits=1, user_api="blas"):  # sums must not depend on the number of processors
        if not alignments:
            alignments = [alignment_of_votes(source, target, votes, settings, parameters)]
        registration = alignments[0].registered(source, target, constants)
        terms = evidence(source, target, registration)
        found = {"registration": -float(log_odds([terms], constants.choice)[0])}
        if may_be_part(source, parameters.partial) or may_be_part(target, parameters.partial):
            error = whole_error(source, target, registration, parameters.partial)
            found["coverage"] = _log(error * registered_map_cost(source, target, registration, constants.cost))
    return found


def _log(cost: float) -> float:
    return float(np.log(cost + np.finfo(float).tiny))
