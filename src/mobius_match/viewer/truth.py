"""Errors against known correspondence, as numbers of the matches and as colours of the surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from ..evaluation import Case, Truth
from ..evaluation.scoring import Scorer, cached_diameter
from . import packing
from .shapes import Side

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative
    from ..results.surface_map import SurfaceMap

WORST = 0.2
"""Error per diameter at which the colours end."""
SCALE = {"labels": ["0 %", f"{50 * WORST:g} %", f"{100 * WORST:g} % or more"], "colours": packing.RISING}
CHECKED = 2000
"""Points of known correspondence, spread evenly over their list, at which the error of a map is measured."""
LARGE = 30_000
"""Vertices above which distances are found by the heat method."""
REACH = 0.05
"""How far from the nearest of these points, per root of the area, a vertex may lie to take its colour."""


class Errors:
    """Geodesic distances on the target to the true points, per diameter; exact unless the target is large.

    Parameters
    ----------
    truth
        Known correspondence, in numbers of the user's files.
    sides
        Both sides of the page.
    """

    def __init__(self, truth: Truth, sides: list[Side]) -> None:
        self.sides = sides
        self.truth = truth
        self._scorer = self._scores(truth)

    def _scores(self, truth: Truth) -> Scorer:
        source, target = (side.mesh for side in self.sides)
        case = Case("the known correspondence", "", Path(source.name), Path(target.name), truth)
        method = "exact" if len(target.vertices) <= LARGE else "heat"
        return Scorer(case, source, target, method, cached_diameter(target, method))

    def of_matches(self, matches: Correspondence | Alternative) -> dict[str, Any]:
        """Error of each match per diameter of the target, None where it is not known."""
        if not len(matches.pairs):
            return {"errors": []}
        found = self._scorer.score(matches.pairs, matches.confidence)["direct"]
        return {"errors": [None if error != error else round(error, 6) for error in found.tolist()]}

    def of_map(self, dense: SurfaceMap) -> dict[str, Any]:
        """Colours of both surfaces by the error of the map at the nearest point of known correspondence."""
        truth = self._scorer.truth
        known = np.flatnonzero(dense.source_mapped[truth.source])
        some = known[np.unique(np.linspace(0, len(known) - 1, CHECKED).astype(int))] if len(known) else known
        of_source = np.full(len(dense.source_mapped), np.nan)
        if len(some):
            ids = [side.mesh.vertex_ids for side in self.sides]
            points = Truth(ids[0][truth.source[some]], ids[1][truth.target[some]])
            errors = self._scores(points).score_map(dense.vertex_map)["direct"]
            vertices = self.sides[0].shape.vertices
            apart, nearest = cKDTree(vertices[truth.source[some]]).query(vertices)
            of_source = np.where((apart < REACH) & dense.source_mapped, errors[nearest], np.nan)
        of_target = dense.source_points.values(of_source)
        of_target[~dense.target_mapped] = np.nan
        return {
            "name": "Error",
            "note": "Geodesic distance on the target from the image of a point to its true place, as a part of the "
            "target's diameter; grey is not known. Dark is wrong.",
            "scale": SCALE,
            "values": [
                packing.shades(values[side.kept] / WORST)
                for values, side in zip((of_source, of_target), self.sides, strict=True)
            ],
        }
