"""What the page shows of a dense map: transferred colours and textures, its distortion, and the morph."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from ..errors import MeshError, MobiusError
from ..evaluation.quality import quality
from ..exporting.result_meshes import vertices_numbered
from ..exporting.scene import colours_of
from ..mesh.appearance import Appearance, read_appearance
from ..results.surface_map import SurfaceMap
from ..transfer.morph import interpolate, oriented, positions_on_target
from ..transfer.transfer import Transfer
from . import packing
from .shapes import Side

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative

FRAMES = 9
"""Shapes of the morph, including both ends; the page interpolates linearly between them."""
TEXTURE = 1024
"""Pixels at most along the longer side of a texture."""
MAX_CHANGE = 0.1
"""Mean change of distances, per sqrt(area), at the end of the colour scale."""


def add_map(
    content: dict[str, Any], sides: list[Side], dense: SurfaceMap, alignments: Sequence[Correspondence | Alternative]
) -> None:
    """Add what the map shows to the content of a page.

    Raises
    ------
    MeshError
        If the map is between other meshes.
    """
    if any(
        (mesh.sha256, len(mesh.vertices)) != (side.mesh.sha256, len(side.mesh.vertices))
        for mesh, side in zip((dense.source, dense.target), sides, strict=True)
    ):
        raise MeshError("`dense` is a map between other meshes than those of the result; compute it from this result")
    colours = _colours(sides, dense, colours_of(sides[0].shape.vertices))
    note = "Points of the same colour correspond by the dense map; grey points have no counterpart."
    content["colourings"] += [
        {"name": "Position", "colours": colours, "note": note},
        {"name": "Checkerboard", "checker": True, "like": 0, "note": note},
        *_appearance(content, sides, dense),
        *_distortions(sides, dense),
    ]
    for side, origins in zip(content["sides"], _origins(sides, dense), strict=True):
        side["origins"] = origins
    if dense.source_mapped.any():
        _add_morph(content, sides, dense, alignments)


def _colours(sides: list[Side], dense: SurfaceMap, colours: np.ndarray) -> list[str]:
    """Packed colours of the source's vertices (n1, 3), and of the target's by the map."""
    return [packing.colours(of_side) for of_side in _on_both(sides, dense, colours)]


def _on_both(sides: list[Side], dense: SurfaceMap, values: np.ndarray) -> list[np.ndarray]:
    """Values of the source's vertices, and of the target's by the map, at the drawn vertices of both."""
    on_target = dense.source_points.values(values)
    on_target[~dense.target_mapped] = np.nan
    return [of_side[side.kept] for of_side, side in zip((values, on_target), sides, strict=True)]


def _distortions(sides: list[Side], dense: SurfaceMap) -> list[dict[str, Any]]:
    distortion = quality(dense)
    return [
        {
            "name": name,
            "note": note,
            "scale": {"labels": labels, "colours": scale},
            "values": [packing.shades(values) for values in _on_both(sides, dense, fractions)],
        }
        for name, fractions, labels, scale, note in (
            (
                "Area distortion",
                (distortion.area + 1) / 2,
                ["half", "equal", "double"],
                packing.DIVERGING,
                "Area on the target divided by area on the source, with both surfaces scaled to the same total area.",
            ),
            (
                "Angle distortion",
                distortion.angle / 2,
                ["1 : 1", "1 : 2", "1 : 4"],
                packing.RISING,
                "Anisotropy: ratio of the axes of the ellipse that a small circle is mapped to.",
            ),
            (
                "Distance distortion",
                distortion.geodesic / MAX_CHANGE,
                ["0", f"{MAX_CHANGE / 2:g}", f"{MAX_CHANGE:g} or more"],
                packing.RISING,
                "Mean change of the geodesic distances to reference points, in units of sqrt(area).",
            ),
        )
    ]


def _origins(sides: list[Side], dense: SurfaceMap) -> list[str]:
    """The position of each drawn vertex on the source, in a box of side 1; none where nothing corresponds."""
    box = dense.source.vertices - dense.source.vertices.min(axis=0)
    origins = _on_both(sides, dense, box / box.max())
    origins[0][~dense.source_mapped[sides[0].kept]] = np.nan
    return [
        packing.packed(
            np.where(np.isnan(side), packing.STEPS + 1, np.round(np.nan_to_num(side) * packing.STEPS)), "<u2"
        )
        for side in origins
    ]


def _appearance(content: dict[str, Any], sides: list[Side], dense: SurfaceMap) -> list[dict[str, Any]]:
    """The texture or the colours in the source's file, if it still exists and has any."""
    path = sides[0].mesh.path
    if path is None or not path.exists():
        return []
    try:
        own = read_appearance(path)
    except MobiusError:  # the shapes are known, so the page can be shown without them
        return []
    note = "From the source's file, transferred to the target by the dense map; grey points have no counterpart."
    if own.image is not None and own.uv is not None and all(side.whole for side in sides):
        for side, uv in zip(content["sides"], Transfer(dense).uv_of_repaired(own.uv), strict=True):
            known = ~np.isnan(uv).any(axis=(1, 2))
            side["uv"] = packing.quantised(np.where(known[:, None, None], uv, 0.0)) | {
                "known": packing.packed(known, "u1")
            }
        content["texture"] = _smaller(own.image)
        return [{"name": "Texture", "texture": True, "note": note}]
    if own.colors is None or _has_one_colour(own):
        return []
    colours = own.colors[sides[0].mesh.vertex_ids, :3] / 255
    return [{"name": "Colours of the file", "colours": _colours(sides, dense, colours), "note": note}]


def _has_one_colour(own: Appearance) -> bool:
    return own.colors is not None and bool((own.colors == own.colors[0]).all())


def _smaller(image: bytes) -> str:
    """A picture, reduced in size, as a data: address."""
    from PIL import Image

    picture = Image.open(io.BytesIO(image)).convert("RGB")
    picture.thumbnail((TEXTURE, TEXTURE))
    buffer = io.BytesIO()
    picture.save(buffer, "JPEG", quality=88)
    return "data:image/jpeg;base64," + packing.packed(np.frombuffer(buffer.getvalue(), np.uint8), "u1")


def _add_morph(
    content: dict[str, Any], sides: list[Side], dense: SurfaceMap, alignments: Sequence[Correspondence | Alternative]
) -> None:
    """Add shapes between the source and the target, as placed on the page, and the positions of the matches on them."""
    source, target = sides
    placed = replace(
        dense,
        source=replace(dense.source, vertices=source.vertices),
        target=replace(dense.target, vertices=target.vertices),
        source_carried=_placed(dense.source_carried, dense.target.vertices, target.vertices),
        target_carried=None,
    )
    placed = oriented(placed)  # the page mirrors the source in the same way
    vertices = placed.source.vertices
    start, end = vertices[source.kept], positions_on_target(placed)[source.kept]
    shapes = interpolate(start, end, source.faces, np.linspace(0, 1, FRAMES))[1:]
    content["morph"] = packing.quantised(shapes) | {"frames": FRAMES}
    tree = cKDTree(start)
    for packed, alignment in zip(content["alignments"], alignments, strict=True):
        positions = vertices[vertices_numbered(source.mesh, alignment.pairs[:, 0])]
        nearest = tree.query(positions)[1] if len(positions) else np.empty(0, int)
        packed["moved"] = packing.packed(shapes[:, nearest] + (positions - start[nearest]), "<f4")


def _placed(positions: np.ndarray | None, vertices: np.ndarray, placed: np.ndarray) -> np.ndarray | None:
    """Positions (q, 3) beside vertices (n, 3), moved as these were to their places on the page."""
    if positions is None:
        return None
    scale = np.abs(vertices).max() or 1.0
    before, moved = (np.column_stack([points / scale, np.ones(len(points))]) for points in (vertices, positions))
    return np.asarray(moved @ np.linalg.lstsq(before, placed, rcond=None)[0])
