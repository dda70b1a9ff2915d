"""What a page shows of every result: both surfaces, and where their matches are."""

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
from ..surface.simplified import simplified
from . import packing

if TYPE_CHECKING:
    from ..mesh import Mesh
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative
    from ..surface.surface import Surface

MOST = 30_000
"""Vertices above which a simplified surface is drawn instead."""
FEWER = 15_000
"""Vertices that it then has, if it was not matched on a simplified one."""

FEW = 100
"""Matches above which their spheres are smaller the more there are, so that as much of the surface stays in sight."""


@dataclass(frozen=True, eq=False)
class Side:
    """One surface as it stands on the page.

    Parameters
    ----------
    mesh
        The repaired mesh.
    shape
        It at area 1 with y upward, with the vertices of the chosen matches.
    vertices
        (n, 3) its vertices on the page: around the origin, in a common scale.
    kept, faces
        (k,) numbers of the vertices that are drawn, and faces (m, 3) between them.
    """

    mesh: Mesh
    shape: Shape
    vertices: np.ndarray
    kept: np.ndarray
    faces: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def whole(self) -> bool:
        """Whether all of the mesh is drawn."""
        return len(self.kept) == len(self.mesh.vertices)


def sides_of(result: Correspondence) -> tuple[list[Side], float]:
    """Both sides, and how large the sphere of a certain match is on the page."""
    surfaces, infos = (result.source, result.target), (result.source_info, result.target_info)
    meshes = [mesh_of(surface, info) for surface, info in zip(surfaces, infos, strict=True)]
    shapes = [shape_of(mesh, numbers) for mesh, numbers in zip(meshes, result.pairs.T, strict=True)]
    centred = [shape.vertices - (shape.vertices.min(axis=0) + shape.vertices.max(axis=0)) / 2 for shape in shapes]
    # Both at one scale (equal areas look equal), unless that would make one of them tiny.
    fits = [1 / np.linalg.norm(vertices, axis=1).max() for vertices in centred]
    scales = [max(min(fits), fit / 1.5) for fit in fits]
    sides = [
        Side(mesh, shape, vertices * scale, *_drawn(mesh, surface))
        for mesh, shape, vertices, scale, surface in zip(meshes, shapes, centred, scales, surfaces, strict=True)
    ]
    return sides, 0.8 * RADIUS * min(scales) * float(np.sqrt(FEW / max(len(result), FEW)))


def _drawn(mesh: Mesh, surface: Surface | None) -> tuple[np.ndarray, np.ndarray]:
    if len(mesh.vertices) <= MOST:
        return np.arange(len(mesh.vertices)), mesh.faces
    if surface is not None and surface.detail is not None:
        return surface.detail.kept, surface.mesh.faces
    simple, detail = simplified(mesh, FEWER, 1.0)
    return (np.arange(len(mesh.vertices)) if detail is None else detail.kept), simple.faces


def name_of(info: dict[str, Any]) -> str:
    """What a surface is called on the page."""
    return Path(str(info.get("path") or "array")).name


def content(result: Correspondence, sides: list[Side], radius: float) -> dict[str, Any]:
    """What is drawn, as JSON-able values."""
    explanations = [_explanation(result, "Chosen", "", sides)]
    for k, one in enumerate(result.alternatives, start=1):
        note = f"Lost by {one.margin:.2f} (below 0.3 is close); {one.share:.0%} of the best triplets spoke for it."
        explanations.append(_explanation(one, f"Other {k}", note, sides))
    infos = (result.source_info, result.target_info)
    return {
        "sides": [_side(side, name_of(info)) for side, info in zip(sides, infos, strict=True)],
        "explanations": explanations,
        "colourings": [],
        "azimuth": best_azimuth([side.shape for side in sides]),
        "elevation": float(ELEVATION),
        "radius": radius,
    }


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
    }


def _explanation(matches: Correspondence | Alternative, name: str, note: str, sides: list[Side]) -> dict[str, Any]:
    """Where the matches are on both sides, and their colours, those of :func:`mobius_match.figures.draw_matches`."""
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
