"""Errors against a known correspondence: of each match, and as colours of the surfaces."""

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
"""Error, per diameter, at the end of the colour scale."""
SCALE = {"labels": ["0 %", f"{50 * WORST:g} %", f"{100 * WORST:g} % or more"], "colours": packing.RISING}
CHECKED = 2000
"""Points of the known correspondence, evenly spaced in its list, at which the error of a map is measured."""
LARGE = 30_000
"""Vertices above which distances are computed by the heat method."""
REACH = 0.05
"""Distance to the nearest of these points, per sqrt(area), up to which a vertex takes its colour."""


class Errors:
    """Geodesic distances on the target to the true points, per diameter; exact unless the target is large.

    Parameters
    ----------
    truth
        Known correspondence, as vertex numbers of the files.
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
        """Error of each match per diameter of the target; None where it is unknown."""
        if not len(matches.pairs):
            return {"errors": []}
        errors = self._scorer.score(matches.pairs, matches.confidence)["direct"]
        return {"errors": [None if error != error else round(error, 6) for error in errors.tolist()]}

    def of_map(self, dense: SurfaceMap) -> dict[str, Any]:
        """Colours of both surfaces by the error of the map at the nearest point of the known correspondence."""
        truth = self._scorer.truth
        known = np.flatnonzero(dense.source_mapped[truth.source])
        checked = known[np.unique(np.linspace(0, len(known) - 1, CHECKED).astype(int))] if len(known) else known
        of_source = np.full(len(dense.source_mapped), np.nan)
        if len(checked):
            ids = [side.mesh.vertex_ids for side in self.sides]
            points = Truth(ids[0][truth.source[checked]], ids[1][truth.target[checked]])
            errors = self._scores(points).score_map(dense.vertex_map)["direct"]
            vertices = self.sides[0].shape.vertices
            distances, nearest = cKDTree(vertices[truth.source[checked]]).query(vertices)
            of_source = np.where((distances < REACH) & dense.source_mapped, errors[nearest], np.nan)
        of_target = dense.source_points.values(of_source)
        of_target[~dense.target_mapped] = np.nan
        return {
            "name": "Error",
            "note": "Geodesic distance on the target from the image of a point to its true position, in % of the "
            "target's diameter. Dark is wrong, grey is unknown.",
            "scale": SCALE,
            "values": [
                packing.shades(values[side.kept] / WORST)
                for values, side in zip((of_source, of_target), self.sides, strict=True)
            ],
        }
