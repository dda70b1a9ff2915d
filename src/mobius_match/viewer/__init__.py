"""A page with both shapes and their matches, to turn and to look through: one file that needs no network.

The script, ``viewer.js``, is built from ``viewer/`` at the root of the repository; here is what it shows.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..detail import simplified
from ..errors import FormatError, MeshError
from ..figures import ELEVATION, RADIUS, best_azimuth, colours_of, mesh_of, numbered, shape_of

if TYPE_CHECKING:
    from ..correspondence import Alternative, Correspondence
    from ..dense import SurfaceMap
    from ..mesh import Mesh
    from ..surface import Surface

MOST = 30_000
"""Vertices above which a simplified surface is drawn instead."""
FEWER = 15_000
"""Vertices that it then has, if it was not matched on a simplified one."""
NOTHING = np.array([0.45, 0.45, 0.47])
"""Colour of what has no counterpart, or no value."""
STEPS = 65534
"""Steps of a coordinate; one number more, 65535, stands for none."""

DIVERGING = np.array(
    [[0x1F, 0x5A, 0xA6], [0x92, 0xC5, 0xDE], [0xF7, 0xF7, 0xF7], [0xF4, 0xB1, 0x66], [0xA6, 0x49, 0x05]]
)
RISING = np.array([[0xFB, 0xF3, 0xD5], [0xF2, 0xC1, 0x66], [0xD9, 0x7F, 0x3C], [0x93, 0x3D, 0x4E], [0x2E, 0x14, 0x4F]])
"""Colours of scales, 0 to 255, that those who take red for green can read too."""


@dataclass(frozen=True)
class View:
    """A page that a notebook shows."""

    html: str

    def _repr_html_(self) -> str:
        # A frame of its own: the page neither sees the notebook nor changes it.
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts allow-downloads" '
            'title="Matches on both shapes" style="width: 100%; height: 640px; border: 0"></iframe>'
        )


def page(result: Correspondence, *, dense: SurfaceMap | None = None) -> str:
    """A page (HTML) that shows both shapes side by side with their matches, in any browser and without network.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`; for one that was loaded from a file, the meshes are read again. Its
        alternatives can be switched to.
    dense
        Its dense map (``result.dense()``): the page can then carry colours from the source to the target by it, and
        show how it distorts.

    Raises
    ------
    MeshError
        If the meshes of a loaded result cannot be read, have changed since the match, or are not those of the map.
    FormatError
        If numbers of a loaded result are not finite.
    """
    try:
        text = json.dumps(result.to_dict(alternatives=bool(result.alternatives)), indent=1, allow_nan=False)
    except ValueError as error:
        raise FormatError("the result holds numbers that are not finite; match again, then view") from error
    names = [_name(info) for info in (result.source_info, result.target_info)]
    script = files(__package__).joinpath("viewer.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data: blob:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<link rel="icon" href="data:,">
<title>{html.escape(" - ".join(names))}</title>
</head>
<body>
<noscript>This page needs JavaScript, which is in it.</noscript>
<script type="application/json" id="result">{_harmless(text)}
</script>
<script type="application/json" id="shapes">{_harmless(json.dumps(_content(result, names, dense)))}</script>
<script>{script}</script>
</body>
</html>
"""


def _harmless(text: str) -> str:
    """JSON that cannot end the element it stands in, nor begin another."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _name(info: dict[str, Any]) -> str:
    return Path(str(info.get("path") or "array")).name


def _content(result: Correspondence, names: list[str], dense: SurfaceMap | None) -> dict[str, Any]:
    """What is drawn, as JSON-able values; viewer/data.js reads it."""
    surfaces, infos = (result.source, result.target), (result.source_info, result.target_info)
    meshes = [mesh_of(surface, info) for surface, info in zip(surfaces, infos, strict=True)]
    shapes = [shape_of(mesh, numbers) for mesh, numbers in zip(meshes, result.pairs.T, strict=True)]
    drawn = [_drawn(mesh, surface) for mesh, surface in zip(meshes, surfaces, strict=True)]
    middles = [(shape.vertices.min(axis=0) + shape.vertices.max(axis=0)) / 2 for shape in shapes]
    # Both at one scale (equal areas look equal), unless that would make one of them tiny.
    fits = [
        1 / np.linalg.norm(shape.vertices - middle, axis=1).max() for shape, middle in zip(shapes, middles, strict=True)
    ]
    scales = [max(min(fits), fit / 1.5) for fit in fits]
    placed = [(shape.vertices - middle) * scale for shape, middle, scale in zip(shapes, middles, scales, strict=True)]
    sides = [
        {
            "name": name,
            "vertices": mesh.n_file_vertices,
            "simplified": len(kept) < len(mesh.vertices),
            **_quantised(vertices[kept]),
            "wide": len(kept) > 65535,
            "triangles": _packed(faces, "<u4" if len(kept) > 65535 else "<u2"),
        }
        for name, mesh, vertices, (kept, faces) in zip(names, meshes, placed, drawn, strict=True)
    ]
    explanations = [_explanation(result, "Chosen", "", meshes, placed)]
    for k, one in enumerate(result.alternatives, start=1):
        note = f"Lost by {one.margin:.2f}; {one.share:.0%} of the best triplets spoke for it."
        explanations.append(_explanation(one, f"Other {k}", note, meshes, placed))
    colourings: list[dict[str, Any]] = []
    if dense is not None:
        if any(
            (mine.sha256, len(mine.vertices)) != (mesh.sha256, len(mesh.vertices))
            for mine, mesh in zip((dense.source, dense.target), meshes, strict=True)
        ):
            raise MeshError("the map is of other meshes than the result; make it with the result (--dense)")
        colourings = _colourings(dense, shapes[0].vertices, [kept for kept, _ in drawn])
        for side, origins in zip(sides, _origins(dense, [kept for kept, _ in drawn]), strict=True):
            side["origins"] = origins
    return {
        "sides": sides,
        "explanations": explanations,
        "colourings": colourings,
        "azimuth": best_azimuth(shapes),
        "elevation": float(ELEVATION),
        "radius": 0.8 * RADIUS * min(scales),
    }


def _drawn(mesh: Mesh, surface: Surface | None) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (k,) of the vertices of the mesh that are drawn, and faces (m, 3) between them."""
    if len(mesh.vertices) <= MOST:
        return np.arange(len(mesh.vertices)), mesh.faces
    if surface is not None and surface.detail is not None:
        return surface.detail.kept, surface.mesh.faces
    simple, detail = simplified(mesh, FEWER)
    return (np.arange(len(mesh.vertices)) if detail is None else detail.kept), simple.faces


def _explanation(
    matches: Correspondence | Alternative, name: str, note: str, meshes: list[Mesh], placed: list[np.ndarray]
) -> dict[str, Any]:
    """Where the matches are on both sides, and their colours, those of :func:`mobius_match.figures.draw_matches`."""
    ends = [
        vertices[numbered(mesh, numbers)]
        for mesh, vertices, numbers in zip(meshes, placed, matches.pairs.T, strict=True)
    ]
    exact = matches.target_points
    if exact is not None:
        corners = numbered(meshes[1], exact.corners.ravel()).reshape(-1, 3)
        ends[1] = np.einsum("qk,qki->qi", exact.barycentric, placed[1][corners])
    return {
        "name": name,
        "note": note,
        "points": [_packed(end, "<f4") for end in ends],
        "colours": _bytes(colours_of(ends[0])),
    }


def _colourings(dense: SurfaceMap, source: np.ndarray, kept: list[np.ndarray]) -> list[dict[str, Any]]:
    """Colours of both surfaces that show what the map does."""
    from ..dense import quality

    found = quality(dense)
    places = colours_of(source)

    def both(values: np.ndarray) -> list[str]:
        carried = dense.back.values(values)
        carried[~dense.back_found] = np.nan
        return [
            _bytes(np.where(np.isnan(side[k]), NOTHING, side[k]))
            for side, k in zip((values, carried), kept, strict=True)
        ]

    carried = {"colours": both(places), "note": "Equal colours correspond by the dense map; grey has no counterpart."}
    return [
        {"name": "Places", **carried},
        {"name": "Squares", "checker": True, **carried},
        {
            "name": "Change of area",
            "colours": both(_scale(DIVERGING, (found.area + 1) / 2)),
            "note": "Area on the target over area on the source.",
            "scale": {"low": "half", "high": "double", "colours": _css(DIVERGING)},
        },
        {
            "name": "Change of distances",
            "colours": both(_scale(RISING, found.geodesic / 0.1)),
            "note": "Mean change of geodesic distances to landmarks, per root of the area.",
            "scale": {"low": "0", "high": "0.1", "colours": _css(RISING)},
        },
    ]


def _origins(dense: SurfaceMap, kept: list[np.ndarray]) -> list[str]:
    """Where each drawn vertex comes from on the source, in a box of side 1; none where nothing corresponds."""
    box = dense.source.vertices - dense.source.vertices.min(axis=0)
    box = box / box.max()
    packed = []
    for origin, known, k in ((box, dense.found, kept[0]), (dense.back.values(box), dense.back_found, kept[1])):
        codes = np.round(origin * STEPS).clip(0, STEPS)
        codes[~known] = STEPS + 1
        packed.append(_packed(codes[k], "<u2"))
    return packed


def _scale(stops: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of values (n,) from 0 to 1 along a scale; NaN stays."""
    at = np.linspace(0, 1, len(stops))
    return np.stack([np.interp(values.clip(0, 1), at, channel) for channel in stops.T / 255], axis=1)


def _css(stops: np.ndarray) -> list[str]:
    return ["#" + "".join(f"{value:02x}" for value in stop) for stop in stops.tolist()]


def _quantised(vertices: np.ndarray) -> dict[str, Any]:
    low, step = vertices.min(axis=0), np.ptp(vertices, axis=0) / STEPS
    codes = np.round((vertices - low) / np.where(step > 0, step, 1))
    return {"low": low.tolist(), "step": step.tolist(), "positions": _packed(codes, "<u2")}


def _bytes(colours: np.ndarray) -> str:
    """Colours (n, 3) from 0 to 1, a byte a channel."""
    return _packed(np.round(255 * colours), "u1")


def _packed(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values).astype(kind).tobytes()).decode()
