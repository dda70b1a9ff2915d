"""Both surfaces and the positions of their matches, which every page shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.display import one_line
from ..exporting.figures import RADIUS
from ..exporting.rendering import Shape
from ..exporting.result_meshes import mesh_of, vertices_numbered
from ..exporting.scene import ELEVATION, best_azimuth, colours_of, shape_of
from ..mesh.handles import handle_loops
from ..mesh.pieces import main_piece
from ..surface.simplified import simplified
from . import packing

if TYPE_CHECKING:
    from ..mesh import Mesh
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative
    from ..results.surface_map import SurfaceMap
    from ..surface.surface import Surface

MAX_VERTICES = 30_000
"""Vertices above which a simplified surface is drawn."""
SIMPLIFIED_VERTICES = 15_000
"""Vertices of that surface, unless the match used a simplified surface too, which is then drawn."""

FEW = 100
"""Matches above which their spheres get smaller, so that the same area of the surface stays visible."""


@dataclass(frozen=True, eq=False)
class Side:
    """One surface on the page.

    Parameters
    ----------
    mesh
        The repaired mesh.
    shape
        The mesh scaled to area 1, with y upward, and the vertices of the matches.
    vertices
        (n, 3) positions of the vertices on the page: centred at the origin, in the scale of the page.
    kept, faces
        (k,) numbers of the drawn vertices, and faces (m, 3) between them.
    loops
        Vertices (l,) of each loop around a handle.
    """

    mesh: Mesh
    shape: Shape
    vertices: np.ndarray
    kept: np.ndarray
    faces: np.ndarray
    loops: list[np.ndarray]

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def whole(self) -> bool:
        """Whether all of the mesh is drawn."""
        return len(self.kept) == len(self.mesh.vertices)


def sides_of(result: Correspondence, dense: SurfaceMap | None) -> tuple[list[Side], float]:
    """Both sides, and the radius of the sphere of a match with confidence 1."""
    surfaces, infos = (result.source, result.target), (result.source_info, result.target_info)
    meshes = [mesh_of(surface, info) for surface, info in zip(surfaces, infos, strict=True)]
    loops = [_loops(mesh, surface) for mesh, surface in zip(meshes, surfaces, strict=True)]
    if dense is not None and None in surfaces:  # only the map of a loaded result knows which handles were cut open
        maps = dense.source, dense.target
        meshes = [other if other.sha256 == mesh.sha256 else mesh for mesh, other in zip(meshes, maps, strict=True)]
    shapes = [shape_of(mesh, numbers) for mesh, numbers in zip(meshes, result.pairs.T, strict=True)]
    centred = [shape.vertices - (shape.vertices.min(axis=0) + shape.vertices.max(axis=0)) / 2 for shape in shapes]
    # Both at the same scale (equal areas look equal), unless that would make one of them tiny.
    fits = [1 / np.linalg.norm(vertices, axis=1).max() for vertices in centred]
    scales = [max(min(fits), fit / 1.5) for fit in fits]
    sides = [
        Side(mesh, shape, vertices * scale, *_drawn(mesh, surface), [vertices_numbered(mesh, loop) for loop in of_side])
        for mesh, shape, vertices, scale, surface, of_side in zip(
            meshes, shapes, centred, scales, surfaces, loops, strict=True
        )
    ]
    return sides, 0.8 * RADIUS * min(scales) * float(np.sqrt(FEW / max(len(result), FEW)))


def _drawn(mesh: Mesh, surface: Surface | None) -> tuple[np.ndarray, np.ndarray]:
    if len(mesh.vertices) <= MAX_VERTICES:
        return np.arange(len(mesh.vertices)), mesh.faces
    if surface is not None and surface.detail is not None:
        return surface.detail.kept, surface.mesh.faces
    simple, detail = simplified(mesh, SIMPLIFIED_VERTICES, 1.0)
    return (np.arange(len(mesh.vertices)) if detail is None else detail.kept), simple.faces


def _loops(mesh: Mesh, surface: Surface | None) -> list[np.ndarray]:
    """The user's numbers of the vertices along each loop around a handle."""
    if surface is None:  # a result that was loaded
        main = main_piece(mesh)
        return [main.vertex_ids[loop] for loop in handle_loops(main)]
    return np.split(surface.loops, np.cumsum(surface.loop_sizes)[:-1]) if len(surface.loops) else []


def name_of(info: dict[str, Any]) -> str:
    """The name of a surface on the page."""
    return Path(str(info.get("path") or "array")).name


def content(result: Correspondence, sides: list[Side], radius: float) -> dict[str, Any]:
    """The shapes and the matches of all alignments, as JSON-able values."""
    alignments = [_alignment(result, "Best", _chance(result.probability), sides)]
    for k, alternative in enumerate(result.alternatives, start=1):
        note = f"{_chance(alternative.probability)}{alternative.share:.0%} of the best triplets support it."
        alignments.append(_alignment(alternative, f"Alternative {k}", note, sides))
    infos = (result.source_info, result.target_info)
    return {
        "sides": [_side(side, name_of(info)) for side, info in zip(sides, infos, strict=True)],
        "alignments": alignments,
        "colourings": [],
        "azimuth": best_azimuth([side.shape for side in sides]),
        "elevation": float(ELEVATION),
        "radius": radius,
    }


def _chance(probability: float | None) -> str:
    """What the page says about the probability of an alignment."""
    if probability is None or np.isnan(probability):
        return ""
    return f"It is the right alignment with a probability of {probability:.2f}. "


def _side(side: Side, name: str) -> dict[str, Any]:
    wide = len(side.kept) > 65535
    return {
        "name": name,
        "vertices": side.mesh.n_file_vertices,
        "unit": float(np.ptp(side.vertices, axis=0).max() / np.ptp(side.mesh.vertices, axis=0).max()),
        "simplified": not side.whole,
        "positions": packing.quantised(side.vertices[side.kept]),
        "wide": wide,
        "triangles": packing.packed(side.faces, "<u4" if wide else "<u2"),
        **({"loops": packing.packed(_segments(side), "<f4")} if side.loops else {}),
    }


def _segments(side: Side) -> np.ndarray:
    """Both ends (s, 2, 3) of all edges of loops."""
    edges = np.concatenate([np.stack([loop, np.roll(loop, -1)], axis=1) for loop in side.loops])
    return side.vertices[edges]


def _alignment(matches: Correspondence | Alternative, name: str, note: str, sides: list[Side]) -> dict[str, Any]:
    """Positions of the matches on both sides, and their colours, as in :func:`mobius_match.draw_matches`."""
    ends = [
        side.vertices[vertices_numbered(side.mesh, numbers)]
        for side, numbers in zip(sides, matches.pairs.T, strict=True)
    ]
    exact = matches.target_points
    if exact is not None:
        corners = vertices_numbered(sides[1].mesh, exact.corners.ravel()).reshape(-1, 3)
        ends[1] = np.einsum("qk,qki->qi", exact.barycentric, sides[1].vertices[corners])
    return {
        "name": name,
        "note": note,
        "points": [packing.packed(end, "<f4") for end in ends],
        "colours": packing.colours(colours_of(ends[0])),
    }
