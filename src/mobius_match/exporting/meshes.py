"""Both meshes in colours that correspond."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..geometry.geodesics import nearest_centres
from ..landmarks.rows import SIDES
from ..mesh.measure import unit_box
from ..mesh.user_mesh import repaired_numbers, user_mesh
from ..mesh.writing import mesh_files
from ..transfer.colours import GREY
from .content import DIRECTION, Content
from .figures import colours_of, numbered


def write_mesh(content: Content, side: int, ending: str) -> bytes:
    """One of the two meshes, with the vertices and triangles of its file.

    With a dense map the source's vertices have colours by their place, and these are carried to the target. Without,
    every vertex has the colour of the match that is nearest on the surface. Grey is what has no counterpart.
    """
    repaired = content.meshes[side]
    mesh = user_mesh(repaired)
    colours = _patches(content, side) if content.dense is None else _carried(content, side)
    colours = np.where(np.isnan(colours), GREY[:3] / 255, colours)
    number = repaired_numbers(repaired, mesh)
    shown = np.full((len(number), 4), GREY)
    shown[number >= 0, :3] = np.round(255 * colours[number[number >= 0]])
    said = f"mobius-match; {DIRECTION}: equal colours correspond; this is the {SIDES[side]}, vertices as in its file"
    (found,) = mesh_files(Path(f"mesh{ending}"), mesh.vertices, mesh.faces, colors=shown, comment=said).values()
    return found


def _patches(content: Content, side: int) -> np.ndarray:
    """Colours (n, 3) from 0 to 1: of the nearest match, those of :func:`mobius_match.figures.draw_matches`."""
    of_matches = colours_of(content.marks[0].points)
    mesh, numbers = content.meshes[side], content.matches.pairs[:, side]
    return of_matches[nearest_centres(mesh.vertices, mesh.faces, numbered(mesh, numbers))]


def _carried(content: Content, side: int) -> np.ndarray:
    """Colours (n, 3) from 0 to 1 by the dense map, NaN for what has no counterpart."""
    dense = content.map
    given = colours_of(unit_box(dense.source.vertices)).astype(np.float64)
    colours, found = (dense.source_points.values(given), dense.target_mapped) if side else (given, dense.source_mapped)
    colours[~found] = np.nan
    return colours
