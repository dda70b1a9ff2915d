"""The result of a match: pairs of vertices with confidence, and the file they are kept in."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.files import write_atomically
from ..errors import FormatError, SettingsError
from ..geometry.points import SurfacePoints
from .actions import action

if TYPE_CHECKING:
    from ..surface.surface import Surface
    from ..voting.votes import Votes
    from .surface_map import SurfaceMap

FORMAT = "mobius-match/correspondence"
VERSION = 1

POINT_FIELDS = ("face", "vertices", "barycentric")
"""What a target point is given by in the file, in the order of :class:`SurfacePoints`."""


@dataclass(frozen=True, eq=False)
class Alternative:
    """The matches under another explanation of the same two surfaces.

    Parameters
    ----------
    pairs, confidence, kind, target_points, given
        As in :class:`Correspondence`.
    margin
        By how much it lost against the chosen explanation, without units; small is close.
    share
        The part of the best triplets that spoke for it.
    """

    pairs: np.ndarray
    confidence: np.ndarray
    kind: np.ndarray
    margin: float
    share: float
    target_points: SurfacePoints | None = None
    given: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Corresponding vertices of two meshes, the most confident first.

    Parameters
    ----------
    pairs
        (Q, 2) int64: vertex of the source and vertex of the target, numbers from 0 of the user's own meshes.
    confidence
        (Q,) float64 in [0, 1], not increasing: the chance that the match lies within 5 % of the target's diameter of
        its true place; with uniform proposals the paper's share of the votes.
    kind
        (Q,) str: ``"voted"``, or ``"recovered"`` for a pair that its own votes do not give, or hardly, and the others
        bear out (section 8).
    target_points
        Where exactly the Q matches lie: faces and corners in the user's own numbers, and barycentric coordinates.
        ``pairs`` names the corner that weighs most. None where matches are samples of the target (uniform proposals).
    given
        (Q,) bool: which matches are landmarks that the user gave, with confidence 1; None where none were given.
    source_info, target_info
        Path, SHA-256, numbers of vertices and faces, area and geodesic diameter of the two meshes.
    settings, timings, software
        What the match was made with, and the seconds that its stages took.
    diagnostics
        How the conjugate functions close (section 5), as fractions of the flattenings' extents, and how many triplets
        were evaluated and voted.
    warnings
        What a user should know about the meshes and the match, one line each.
    source, target
        The prepared surfaces; None for a result that was loaded from a file.
    votes
        The fuzzy correspondence matrix; None for a result that was loaded from a file.
    others
        Makes the :attr:`alternatives`; None for a result that was loaded from a file without them.
    spread
        Makes the map that :meth:`dense` gives; None for a result that was loaded from a file.
    """

    pairs: np.ndarray
    confidence: np.ndarray
    kind: np.ndarray
    source_info: dict[str, Any]
    target_info: dict[str, Any]
    settings: dict[str, Any]
    target_points: SurfacePoints | None = None
    given: np.ndarray | None = None
    timings: dict[str, float] = field(default_factory=dict)
    software: dict[str, str] = field(default_factory=dict)
    diagnostics: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    source: Surface | None = None
    target: Surface | None = None
    votes: Votes | None = None
    others: Callable[[], tuple[Alternative, ...]] | None = None
    spread: Callable[[], SurfaceMap] | None = None

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        names = [Path(info["path"] or "array").name for info in (self.source_info, self.target_info)]
        return f"<Correspondence {names[0]} -> {names[1]}: {len(self)} pairs>"

    @cached_property
    def alternatives(self) -> tuple[Alternative, ...]:
        """The matches under other explanations, the closest loser first; worked out when first asked for."""
        return () if self.others is None else self.others()

    def dense(self) -> SurfaceMap:
        """Every vertex of each surface to a point of the other, worked out when first asked for.

        Raises
        ------
        SettingsError
            For a result that was loaded from a file, which holds no surfaces: match again.
        """
        return self._dense

    @cached_property
    def _dense(self) -> SurfaceMap:
        if self.spread is None:
            raise SettingsError(
                "a result that was loaded from a file holds no surfaces to make a dense map of; match them again "
                "(mobius_match.rematch)"
            )
        return self.spread()

    def show(self, dense: SurfaceMap | None = None) -> Any:
        """The matches on both shapes to turn and to look through, in a notebook; see :func:`mobius_match.viewer.page`.

        Parameters
        ----------
        dense
            The dense map, to see it too.
        """
        return action("show")(self, dense=dense)

    def to_dict(self, *, alternatives: bool = False) -> dict[str, Any]:
        """The result as JSON-able values, in the layout of the result file; with the alternatives if asked for."""
        content = {
            "format": FORMAT,
            "version": VERSION,
            "source": self.source_info,
            "target": self.target_info,
            "correspondences": _rows(self),
            "settings": self.settings,
            "timings": self.timings,
            "software": self.software,
            "diagnostics": self.diagnostics,
            "warnings": list(self.warnings),
        }
        if alternatives:
            content["alternatives"] = [
                {"margin": one.margin, "share": one.share, "correspondences": _rows(one)} for one in self.alternatives
            ]
        return content

    def to_json(self) -> str:
        """The text of the result file."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result as JSON; an existing file is replaced at once or not at all."""
        write_atomically(Path(path), self.to_json().encode())

    def export(self, path: str | os.PathLike[str], **options: Any) -> list[Path]:
        """Write the matches for other programs; see :func:`mobius_match.exporting.export` for the options."""
        return action("export")(self, path, **options)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Correspondence:
        """Read a result file.

        Raises
        ------
        FormatError
            If the file cannot be read or is no result file of this version.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise FormatError(f"{path}: not a readable result file ({error}); make one with mobius match -o") from error
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise FormatError(f"{path}: not a result of mobius match; its 'format' should be '{FORMAT}'")
        if content.get("version") != VERSION:
            raise FormatError(
                f"{path}: has version {content.get('version')!r} and this program reads {VERSION}; "
                "make it again, or use the program that made it"
            )
        try:
            rows = content["correspondences"]
            return cls(
                **_matches(rows),
                source_info=dict(content["source"]),
                target_info=dict(content["target"]),
                settings=dict(content["settings"]),
                timings=dict(content["timings"]),
                software=dict(content["software"]),
                diagnostics=dict(content.get("diagnostics", {})),
                warnings=tuple(content.get("warnings", ())),
                others=partial(tuple, [_alternative(one) for one in content.get("alternatives", ())]),
            )
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise FormatError(f"{path}: the result file is damaged ({error!r}); make it again") from error


def _rows(matches: Correspondence | Alternative) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = [
        {"source": i, "target": j, "confidence": confidence, "kind": kind}
        for (i, j), confidence, kind in zip(
            matches.pairs.tolist(), matches.confidence.tolist(), matches.kind.tolist(), strict=True
        )
    ]
    points = matches.target_points
    if points is not None:
        values = zip(points.faces.tolist(), points.corners.tolist(), points.barycentric.tolist(), strict=True)
        for row, value in zip(rows, values, strict=True):
            row["target_point"] = dict(zip(POINT_FIELDS, value, strict=True))
    for place in [] if matches.given is None else np.flatnonzero(matches.given):
        rows[place]["given"] = True
    return rows


def _matches(rows: list[dict[str, Any]]) -> dict[str, Any]:
    given = np.array([bool(row.get("given")) for row in rows], bool)
    return {
        "pairs": np.array([(row["source"], row["target"]) for row in rows], np.int64).reshape(-1, 2),
        "confidence": np.array([row["confidence"] for row in rows], np.float64),
        "kind": np.array([row["kind"] for row in rows], dtype="<U9"),
        "target_points": _points(rows),
        "given": given if given.any() else None,
    }


def _alternative(content: dict[str, Any]) -> Alternative:
    margin, share = float(content["margin"]), float(content["share"])
    return Alternative(**_matches(content["correspondences"]), margin=margin, share=share)


def _points(rows: list[dict[str, Any]]) -> SurfacePoints | None:
    if not rows or "target_point" not in rows[0]:
        return None
    faces, corners, barycentric = ([row["target_point"][name] for row in rows] for name in POINT_FIELDS)
    return SurfacePoints(
        np.array(faces, np.int64).reshape(len(rows)),
        np.array(corners, np.int64).reshape(len(rows), 3),
        np.array(barycentric, np.float64).reshape(len(rows), 3),
    )
