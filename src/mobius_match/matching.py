"""The whole method: two meshes in, correspondences out."""

from __future__ import annotations

import platform
import time
from importlib.metadata import version
from typing import Any

import numpy as np

from .correspondence import Correspondence
from .errors import NothingFoundError
from .matrix_processing import linear_assignment, max_row_column, normalized, recover
from .settings import MatchSettings, make_settings
from .surface import Progress, Surface, matchable, prepare_mesh
from .voting import Votes, cast_votes

DEFAULT_THRESHOLD = 0.1
"""Confidence S below which a pair needs the others to bear it out."""


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
    pairs, confidence, recovered = process(votes, first, second, chosen)
    timings["matrix processing"] = time.perf_counter() - begin
    timings["total"] = time.perf_counter() - start
    return Correspondence(
        pairs=np.stack([_users_numbers(first, pairs[:, 0]), _users_numbers(second, pairs[:, 1])], axis=1),
        confidence=confidence,
        kind=np.where(recovered, "recovered", "voted"),
        source_info=_describe(first),
        target_info=_describe(second),
        settings={**chosen.to_dict(), "preset": preset, "votes": votes.n_triplets},
        timings=timings,
        software={name: version(name) for name in ("mobius-match", "numpy", "scipy", "numba", "libigl", "potpourri3d")}
        | {"python": platform.python_version()},
        warnings=(*_notes(first), *_notes(second), *votes.warnings),
        source=first,
        target=second,
        votes=votes,
    )


def process(
    votes: Votes, source: Surface, target: Surface, settings: MatchSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Section 8: the matrix C to pairs of samples (Q, 2), their confidence (Q,) and which were recovered (Q,) bool.

    Raises
    ------
    NothingFoundError
        If C has no entry above zero.
    """
    choose = max_row_column if settings.assignment == "greedy" else linear_assignment
    pairs, confidence = choose(normalized(votes.matrix))
    if not len(pairs):
        raise NothingFoundError(
            f"{source.mesh.name} and {target.mesh.name}: none of {votes.n_triplets} triplets of points gained a "
            "vote; lower --min-fraction or raise --votes, or the shapes have too little in common"
        )
    threshold = DEFAULT_THRESHOLD if settings.threshold is None else settings.threshold
    trusted = confidence >= threshold
    delta = settings.recovery_radius
    recovered = recover(
        pairs, trusted, source.distances, target.distances, delta * source.diameter, delta * target.diameter
    )
    keep = trusted | recovered
    return pairs[keep], confidence[keep], recovered[keep]


def _notes(surface: Surface) -> list[str]:
    return [f"{surface.mesh.name}: {note}" for note in (*surface.mesh.notes, *surface.warnings)]


def _users_numbers(surface: Surface, samples: np.ndarray) -> np.ndarray:
    return surface.mesh.vertex_ids[surface.samples[samples]]


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
