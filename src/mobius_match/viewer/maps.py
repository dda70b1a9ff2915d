"""What a dense map shows: colours and textures carried along it, how it distorts, and one shape becoming the other."""

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
from ..transfer.morph import interpolate, positions_on_target
from ..transfer.transfer import Transfer
from . import packing
from .shapes import Side

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative

FRAMES = 9
"""Shapes of the morph, both ends among them; the page takes straight lines between them."""
TEXTURE = 1024
"""Pixels along the longer side of a texture at most."""
SPREAD = 0.1
"""Mean change of distances, per root of the area, at which the colours end."""


def add_map(
    content: dict[str, Any], sides: list[Side], dense: SurfaceMap, explanations: Sequence[Correspondence | Alternative]
) -> None:
    """Add to the content of a page what the map shows.

    Raises
    ------
    MeshError
        If the map is of other meshes.
    """
    if any(
        (mine.sha256, len(mine.vertices)) != (side.mesh.sha256, len(side.mesh.vertices))
        for mine, side in zip((dense.source, dense.target), sides, strict=True)
    ):
        raise MeshError("`dense` is a map between other meshes than those of the result; compute it from this result")
    carried = _both(sides, dense, colours_of(sides[0].shape.vertices))
    note = "Equal colours correspond by the dense map; grey has no counterpart."
    content["colourings"] += [
        {"name": "Colours by place", "colours": carried, "note": note},
        {"name": "Squares", "checker": True, "like": 0, "note": note},
        *_appearance(content, sides, dense),
        *_distortions(sides, dense),
    ]
    for side, origins in zip(content["sides"], _origins(sides, dense), strict=True):
        side["origins"] = origins
    if dense.source_mapped.any():
        _add_morph(content, sides, dense, explanations)


def _both(sides: list[Side], dense: SurfaceMap, values: np.ndarray) -> list[str]:
    """Colours (n1, 3) of the source's vertices, and of the target's by the map."""
    return [packing.colours(found) for found in _carried(sides, dense, values)]


def _carried(sides: list[Side], dense: SurfaceMap, values: np.ndarray) -> list[np.ndarray]:
    there = dense.source_points.values(values)
    there[~dense.target_mapped] = np.nan
    return [found[side.kept] for found, side in zip((values, there), sides, strict=True)]


def _distortions(sides: list[Side], dense: SurfaceMap) -> list[dict[str, Any]]:
    found = quality(dense)
    return [
        {
            "name": name,
            "note": note,
            "scale": {"labels": labels, "colours": scale},
            "values": [packing.shades(values) for values in _carried(sides, dense, along)],
        }
        for name, along, labels, scale, note in (
            (
                "Change of area",
                (found.area + 1) / 2,
                ["half", "equal", "double"],
                packing.DIVERGING,
                "Area on the target over area on the source, if both had the same area as a whole.",
            ),
            (
                "Change of angles",
                found.angle / 2,
                ["circles", "1 : 2", "1 : 4"],
                packing.RISING,
                "Shape of the image of a small circle: its shorter to its longer axis.",
            ),
            (
                "Change of distances",
                found.geodesic / SPREAD,
                ["0", f"{SPREAD / 2:g}", f"{SPREAD:g} or more"],
                packing.RISING,
                "Mean change of geodesic distances to landmarks, as a part of the root of the area.",
            ),
        )
    ]


def _origins(sides: list[Side], dense: SurfaceMap) -> list[str]:
    """Where each drawn vertex comes from on the source, in a box of side 1; none where nothing corresponds."""
    box = dense.source.vertices - dense.source.vertices.min(axis=0)
    origins = _carried(sides, dense, box / box.max())
    origins[0][~dense.source_mapped[sides[0].kept]] = np.nan
    return [
        packing.packed(np.where(np.isnan(one), packing.STEPS + 1, np.round(np.nan_to_num(one) * packing.STEPS)), "<u2")
        for one in origins
    ]


def _appearance(content: dict[str, Any], sides: list[Side], dense: SurfaceMap) -> list[dict[str, Any]]:
    """The source's own texture or colours, where its file is still there and has some."""
    path = sides[0].mesh.path
    if path is None or not path.exists():
        return []
    try:
        own = read_appearance(path)
    except MobiusError:  # shapes have been read; colours that cannot be are no reason to show nothing
        return []
    note = "Of the source's own file, carried to the target by the dense map; grey has no counterpart."
    if own.image is not None and own.uv is not None and all(side.whole for side in sides):
        for side, uv in zip(content["sides"], Transfer(dense).uv_of_repaired(own.uv), strict=True):
            known = ~np.isnan(uv).any(axis=(1, 2))
            side["uv"] = packing.quantised(np.where(known[:, None, None], uv, 0.0)) | {
                "known": packing.packed(known, "u1")
            }
        content["texture"] = _smaller(own.image)
        return [{"name": "Texture", "texture": True, "note": note}]
    if own.colors is None or _plain(own):
        return []
    colours = own.colors[sides[0].mesh.vertex_ids, :3] / 255
    return [{"name": "Own colours", "colours": _both(sides, dense, colours), "note": note}]


def _plain(own: Appearance) -> bool:
    return own.colors is not None and bool((own.colors == own.colors[0]).all())


def _smaller(image: bytes) -> str:
    """A picture as a data: address, of few pixels."""
    from PIL import Image

    picture = Image.open(io.BytesIO(image)).convert("RGB")
    picture.thumbnail((TEXTURE, TEXTURE))
    buffer = io.BytesIO()
    picture.save(buffer, "JPEG", quality=88)
    return "data:image/jpeg;base64," + packing.packed(np.frombuffer(buffer.getvalue(), np.uint8), "u1")


def _add_morph(
    content: dict[str, Any], sides: list[Side], dense: SurfaceMap, explanations: Sequence[Correspondence | Alternative]
) -> None:
    """Shapes between the source and the target where they stand on the page, and the places of the matches on them."""
    source, target = sides
    placed = replace(
        dense,
        source=replace(dense.source, vertices=source.vertices),
        target=replace(dense.target, vertices=target.vertices),
    )
    start, end = source.vertices[source.kept], positions_on_target(placed)[source.kept]
    shapes = interpolate(start, end, source.faces, np.linspace(0, 1, FRAMES))[1:]
    content["morph"] = packing.quantised(shapes) | {"frames": FRAMES}
    tree = cKDTree(start)
    for shown, one in zip(content["explanations"], explanations, strict=True):
        places = source.vertices[vertices_numbered(source.mesh, one.pairs[:, 0])]
        near = tree.query(places)[1] if len(places) else np.empty(0, int)
        shown["moved"] = packing.packed(shapes[:, near] + (places - start[near]), "<f4")
