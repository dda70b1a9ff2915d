"""The result of a match: pairs of vertices with confidence, and the file that holds them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.display import ROWS, file_name, html_table
from .._core.files import write_atomically
from ..errors import SettingsError
from ..geometry.points import SurfacePoints
from .actions import action, is_result_file
from .matches import Alternative, data_frame, to_columns, to_rows
from .result_file import FORMAT, VERSION, fields_of_file, row_of_alternative

if TYPE_CHECKING:
    from ..surface.surface import Surface
    from ..voting.votes import Votes
    from .surface_map import SurfaceMap


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Corresponding vertices of two meshes, the most confident first.

    Parameters
    ----------
    pairs
        (Q, 2) int64: vertex of the source and vertex of the target, numbers from 0 of the user's own meshes.
    confidence
        (Q,) float64 in [0, 1], not increasing: the chance that the match lies within 5 % of the target's diameter of
        its true place. It is the chance if the alignment is right, times ``probability``. With uniform proposals the
        paper's share of the votes.
    kind
        (Q,) str: ``"voted"``, or ``"recovered"`` for a pair that has few votes or none, and that follows from the other
        pairs (section 8).
    target_points
        (Q,) exact positions of the matches: faces and corners in the user's own numbers, and barycentric coordinates.
        ``pairs`` has the corner with the largest weight. None where matches are samples of the target (uniform
        proposals).
    given
        (Q,) bool: which matches are landmarks that the user gave, with confidence 1; None where none were given.
    reflected
        Whether it is the mirror image of the source that was matched. All coordinates are those of the user's meshes.
    source_info, target_info
        Path, SHA-256, numbers of vertices and faces, area and geodesic diameter of the two meshes.
    settings
        All settings that took effect, by name. Those of the preparation are the source's; if the target was prepared
        with others, they stand under ``target_preparation``.
    timings, software
        The seconds of each stage, and the versions.
    diagnostics
        How the conjugate functions close (section 5), as fractions of the flattenings' extents, and how many triplets
        were evaluated and voted.
    warnings
        Notes on the meshes and on doubts about the match, one line each.
    probability
        The chance, in [0, 1], that the alignment is right, up to the symmetry if there is one; of a part, the highest
        confidence. None with uniform proposals, and for a file that has none.
    symmetry
        ``{"order": n}`` if n alignments look the same because the shapes are symmetric; else None.
    source, target
        The prepared surfaces; None for a result that was loaded from a file.
    votes
        The fuzzy correspondence matrix; None for a result that was loaded from a file.
    """

    pairs: np.ndarray
    confidence: np.ndarray
    kind: np.ndarray
    source_info: dict[str, Any]
    target_info: dict[str, Any]
    settings: dict[str, Any]
    target_points: SurfacePoints | None = None
    given: np.ndarray | None = None
    reflected: bool = False
    timings: dict[str, float] = field(default_factory=dict)
    software: dict[str, str] = field(default_factory=dict)
    diagnostics: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    probability: float | None = None
    symmetry: dict[str, Any] | None = None
    source: Surface | None = None
    target: Surface | None = None
    votes: Votes | None = None
    _costs: Callable[[], dict[str, float]] | None = field(default=None, repr=False)
    _make_alternatives: Callable[[], tuple[Alternative, ...]] | None = field(default=None, repr=False)
    _make_dense: Callable[[], SurfaceMap] | None = field(default=None, repr=False)

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        return f"<Correspondence {self._title}: {len(self)} pairs>"

    def _repr_html_(self) -> str:
        rows = zip(self.pairs.tolist(), self.confidence.tolist(), self.kind.tolist(), strict=True)
        return html_table(
            f"{self._title}: {len(self)} pairs, the most confident first",
            ("", "source vertex", "target vertex", "confidence", "kind"),
            ((n, i, j, confidence, kind) for n, ((i, j), confidence, kind) in enumerate(islice(rows, ROWS), start=1)),
            more=len(self) - ROWS,
            notes=self.warnings,
        )

    @property
    def _title(self) -> str:
        return f"{file_name(self.source_info)} -> {file_name(self.target_info)}"

    @cached_property
    def alternatives(self) -> tuple[Alternative, ...]:
        """The matches under other alignments, the one with the lowest cost first; computed when first used.

        Empty for a result that was loaded from a file without them.
        """
        return () if self._make_alternatives is None else self._make_alternatives()

    def dense(self) -> SurfaceMap:
        """The dense map: every vertex of each surface to a point of the other; computed when first used.

        Returns
        -------
        SurfaceMap
            The map, the same object at each call.

        Raises
        ------
        SettingsError
            For a result that was loaded from a file, which holds no surfaces: match again.
        """
        return self._dense

    @cached_property
    def _dense(self) -> SurfaceMap:
        if self._make_dense is None:
            raise SettingsError(
                "a result that was loaded from a file holds no surfaces to make a dense map of; match them again "
                "(mobius_match.rematch)"
            )
        return self._make_dense()

    def show(self, dense: SurfaceMap | None = None) -> Any:
        """Show the matches on both shapes on an interactive page: in the notebook, or else in the browser.

        Parameters
        ----------
        dense
            The dense map (``result.dense()``), for the page to show it too.

        Returns
        -------
        mobius_match.viewer.View
            The page. A notebook shows it; ``View.save`` writes it to a file.

        See Also
        --------
        mobius_match.page : What the page shows.
        """
        return action("show")(self, dense=dense)

    def to_dict(self, *, alternatives: bool = False) -> dict[str, Any]:
        """The result as JSON-able values, in the layout of the result file.

        Parameters
        ----------
        alternatives
            Whether to include the alternatives.

        Returns
        -------
        dict
            The content of the result file.
        """
        content = {
            "format": FORMAT,
            "version": VERSION,
            "source": self.source_info,
            "target": self.target_info,
            "probability": self.probability,
            **({} if self.symmetry is None else {"symmetry": self.symmetry}),
            **({"reflected": True} if self.reflected else {}),
            "correspondences": to_rows(self),
            "settings": self.settings,
            "timings": self.timings,
            "software": self.software,
            "diagnostics": self.diagnostics,
            "warnings": list(self.warnings),
        }
        if alternatives:
            content["alternatives"] = [row_of_alternative(one) for one in self.alternatives]
        return content

    def to_json(self) -> str:
        """The text of the result file.

        Returns
        -------
        str
            JSON, without the alternatives.
        """
        return json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"

    def to_dataframe(self) -> Any:
        """The matches as a pandas data frame, one row each, the most confident first.

        Returns
        -------
        pandas.DataFrame
            Columns ``source`` and ``target`` (vertices, from 0), ``confidence``, ``kind`` and ``given``; where matches
            are finer than vertices also ``target_face``, its corners ``target_vertex_0`` to ``target_vertex_2``, and
            their weights ``barycentric_0`` to ``barycentric_2``.

        Raises
        ------
        MissingPackageError
            If pandas is not installed.
        """
        return data_frame(to_columns(self))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result to a file, in the format that the name's ending says.

        An existing file is replaced at once or not at all.

        Parameters
        ----------
        path
            ``.json`` for the result file, which :meth:`load` reads. Other endings are those of :meth:`export`, which
            also has options and may write a file for each shape.

        Raises
        ------
        SettingsError
            If the ending is that of no format.
        """
        path = Path(path)
        if is_result_file(path):
            write_atomically(path, self.to_json().encode())
        else:
            self.export(path)

    def export(self, path: str | os.PathLike[str], **options: Any) -> list[Path]:
        """Write the matches for other programs.

        Parameters
        ----------
        path
            Where to write; the ending says the format.
        **options
            As in :func:`mobius_match.export`.

        Returns
        -------
        list of Path
            The files that were written.
        """
        return action("export")(self, path, **options)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Correspondence:
        """Read a result file.

        Parameters
        ----------
        path
            A file of :meth:`save` that ends in ``.json``, or of ``mobius match -o``.

        Returns
        -------
        Correspondence
            The result, without surfaces, votes and dense map; :func:`mobius_match.rematch` gives these.

        Raises
        ------
        FormatError
            If the file cannot be read or is no result file of this version.
        """
        return cls(**fields_of_file(Path(path)))
