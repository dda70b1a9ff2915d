"""The symmetry of one mesh: pairs of vertices with confidence, and the file that holds them."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.display import ROWS, file_name, html_table
from .._core.files import write_atomically
from .actions import check_json
from .matches import data_frame

if TYPE_CHECKING:
    from ..surface.surface import Surface

FORMAT = "mobius-match/symmetry"
VERSION = 1


@dataclass(frozen=True, eq=False)
class Symmetry:
    """An orientation-reversing symmetry of one mesh: which vertex is the mirror image of which.

    Parameters
    ----------
    pairs
        (Q, 2) int64: two vertices that the symmetry exchanges, numbers from 0 of the user's own mesh, each pair once,
        the most confident first.
    confidence
        (Q,) float64 in [0, 1], not increasing: the part of the votes for the samples at both points that agrees with
        where the map of the whole surface sends them, less where the map changes distances. Pairs below 0.4 are left
        out. It ranks the pairs; it is no probability.
    stationary
        (S,) int64, ascending: vertices that the symmetry maps to themselves. Those whose geodesic distances to the two
        points of a pair differ by no more than the mesh's mean edge, or 1 % of sqrt(area) if that is longer, in the
        mean over the 30 best pairs. On a closed surface they lie along a loop, or there are none.
    score
        How symmetric the surface is, in [0, 1]: 1 - a / b, where a is the mean difference between the wave kernel
        signatures of a point and of its image, and b that of two points taken at random. 1 is a perfect symmetry,
        0 is no better than chance.
    source_info
        Path, SHA-256, numbers of vertices and faces, area and geodesic diameter of the mesh.
    settings, timings, software
        The settings that took effect, the seconds of each stage, and the versions.
    warnings
        Notes on the mesh and on doubts about the result, one line each.
    source
        The prepared surface.
    """

    pairs: np.ndarray
    confidence: np.ndarray
    stationary: np.ndarray
    score: float
    source_info: dict[str, Any]
    settings: dict[str, Any]
    timings: dict[str, float]
    software: dict[str, str]
    warnings: tuple[str, ...]
    source: Surface

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        return f"<Symmetry of {file_name(self.source_info)}: {len(self)} pairs, score {self.score:.2f}>"

    def _repr_html_(self) -> str:
        rows = zip(range(1, ROWS + 1), self.pairs.tolist(), self.confidence.tolist(), strict=False)
        return html_table(
            f"Symmetry of {file_name(self.source_info)}: {len(self)} pairs, score {self.score:.2f}",
            ("", "vertex", "mirrored", "confidence"),
            ((number, i, j, confidence) for number, (i, j), confidence in rows),
            more=len(self) - ROWS,
            notes=self.warnings,
        )

    def to_dataframe(self) -> Any:
        """The pairs as a pandas data frame, one row each, the most confident first.

        Returns
        -------
        pandas.DataFrame
            Columns ``source`` and ``target``, two vertices (from 0) that the symmetry exchanges, and ``confidence``.

        Raises
        ------
        MissingPackageError
            If pandas is not installed.
        """
        return data_frame({"source": self.pairs[:, 0], "target": self.pairs[:, 1], "confidence": self.confidence})

    def to_dict(self) -> dict[str, Any]:
        """The result as JSON-able values, in the layout of the result file.

        Returns
        -------
        dict
            The content of the result file.
        """
        return {
            "format": FORMAT,
            "version": VERSION,
            "source": self.source_info,
            "pairs": [
                {"source": int(i), "target": int(j), "confidence": float(c)}
                for (i, j), c in zip(self.pairs, self.confidence, strict=True)
            ],
            "stationary": self.stationary.tolist(),
            "score": self.score,
            "settings": self.settings,
            "timings": self.timings,
            "software": self.software,
            "warnings": list(self.warnings),
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result as JSON; an existing file is replaced at once or not at all.

        Parameters
        ----------
        path
            A name that ends in ``.json``.

        Raises
        ------
        SettingsError
            If the name ends otherwise.
        """
        path = Path(path)
        check_json(path)
        write_atomically(path, (json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n").encode())
