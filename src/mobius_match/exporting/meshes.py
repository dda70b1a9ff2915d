"""Both meshes with vertex colours, equal where they correspond."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..geometry.geodesics import nearest_centres
from ..landmarks.csv_npz import SIDES
from ..mesh.measure import unit_box
from ..mesh.user_mesh import repaired_numbers, user_mesh
from ..mesh.writing import mesh_files
from ..transfer.colours import GREY, SURFACE_GREY
from .content import DIRECTION, Content
from .result_meshes import vertices_numbered
from .scene import colours_of


def write_mesh(content: Content, side: int, ending: str) -> bytes:
    """One of the two meshes, with the vertices and triangles of its file.

    With a dense map the source's vertices are coloured by their position, and the colours are transferred to the
    target. Without one, each vertex has the colour of the match that is nearest on the surface. Vertices without a
    counterpart are grey.

    Parameters
    ----------
    content
        The match.
    side
        0 for the source, 1 for the target.
    ending
        ``".ply"`` or ``".glb"``.
    """
    repaired = content.meshes[side]
    mesh = user_mesh(repaired)
    colours = _match_colours(content, side) if content.dense is None else _map_colours(content, side)
    number = repaired_numbers(repaired, mesh)
    colors = np.full((len(number), 4), GREY)
    colors[number >= 0, :3] = np.round(255 * colours[number[number >= 0]])
    comment = f"mobius-match; {DIRECTION}: equal colours correspond; this is the {SIDES[side]}, vertices as in its file"
    (data,) = mesh_files(Path(f"mesh{ending}"), mesh.vertices, mesh.faces, colors=colors, comment=comment).values()
    return data


def _match_colours(content: Content, side: int) -> np.ndarray:
    """Colours (n, 3), 0 to 1, of the nearest match, as :func:`mobius_match.draw_matches` draws it."""
    colours = colours_of(content.landmarks[0].points)
    mesh, numbers = content.meshes[side], content.matches.pairs[:, side]
    return colours[nearest_centres(mesh.vertices, mesh.faces, vertices_numbered(mesh, numbers))]


def _map_colours(content: Content, side: int) -> np.ndarray:
    """Colours (n, 3), 0 to 1, of corresponding points of the source; grey without a counterpart."""
    dense = content.map
    colours, mapped = colours_of(unit_box(dense.source.vertices)).astype(np.float64), dense.source_mapped
    if side:
        colours, mapped = dense.source_points.values(colours), dense.target_mapped
    colours[~mapped] = SURFACE_GREY
    return colours
