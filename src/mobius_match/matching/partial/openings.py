"""The openings of a surface: how long each rim is, and how much area is missing there at least."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.topology import boundary_loops
from ...surface.surface import Surface


@dataclass(frozen=True)
class Openings:
    """The closed curves of a surface's boundary, free of units.

    Parameters
    ----------
    longest
        :attr:`.Surface.rim_length`.
    missing
        Area of all caps per area of the surface; see :func:`openings`.
    """

    longest: float
    missing: float


def openings(surface: Surface) -> Openings:
    """Measure the openings of a surface. Where a handle was cut open, nothing is missing.

    The cap of a rim is what it encloses in the plane where that is most: its area is the length of the vector
    (1/2) sum x_k cross x_(k+1) over the vertices of the rim. That is the area of the least surface through a flat rim,
    at most L^2 / (4 pi) for a rim of length L, and hardly depends on how jagged the rim is.
    """
    missing = 0.0
    for loop in boundary_loops(surface.mesh.faces):
        points = surface.mesh.vertices[loop]
        points = (points - points.mean(axis=0)) / surface.scale
        following = np.roll(points, -1, axis=0)
        on_cut = np.isin(surface.mesh.vertex_ids[loop], surface.loops)
        if not (on_cut & np.roll(on_cut, -1)).all():
            missing += float(np.linalg.norm(np.cross(points, following).sum(axis=0)) / 2)
    return Openings(surface.rim_length, missing)
