"""Cells of VTK and meshio: surfaces are taken, points and lines keep their numbers, solids are refused."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from ...errors import FormatError
from .raw import DAMAGED, RawMesh, from_polygons

SURFACES, LOWER = ("triangle", "quad", "polygon"), ("vertex", "line")


def from_cells(points: ArrayLike, blocks: Iterable[tuple[str, ArrayLike]], remedy: str = DAMAGED) -> RawMesh:
    """A surface from blocks of cells.

    Parameters
    ----------
    points
        (n, 3) coordinates.
    blocks
        meshio's name of the type of some cells, and their vertex numbers (c, k).
    remedy
        What to do about vertex numbers out of range, for the message.

    Raises
    ------
    FormatError
        If a cell is neither a point, a line nor a polygon.
    """
    place, lower, sizes, corners = 0, 0, [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for kind, data in blocks:
        cells = np.asarray(data, dtype=np.int64)
        if kind not in (*SURFACES, *LOWER):
            raise FormatError(
                f"{len(cells)} cell(s) of type {kind} are neither triangles, quadrilaterals nor "
                f"polygons (the first is cell {place}). Extract the surface first."
            )
        place += len(cells)
        if kind in LOWER:
            # Faces keep the number of their cell: a cell without a surface becomes a face without corners.
            lower += len(cells)
            cells = cells[:, :0]
        sizes.append(np.full(len(cells), cells.shape[1]))
        corners.append(cells.ravel())
    notes = [f"{lower} point or line cell(s) keep their numbers, but have no face."] if lower else []
    return from_polygons(points, np.concatenate(sizes), np.concatenate(corners), notes, remedy=remedy)
