"""Figure 1 of the paper: two surfaces side by side, each match a sphere of the same colour on both.

Pictures are drawn in software, with one depth buffer for triangles and spheres. No display is needed, and the same
result gives the same bytes.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from .._core.files import write_atomically
from ..errors import SettingsError
from ..geometry.farthest_points import farthest_points
from .rendering import Shape, render
from .result_meshes import mesh_of, vertices_numbered
from .scene import ELEVATION, best_azimuth, colours_of, placed_upright, shape_of, with_normals

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence

SMALLEST, LARGEST = 64, 4096
"""Limits of a picture's width and height in pixels."""
RADIUS = 0.042
"""Radius of the sphere of a match with confidence 1, per sqrt(area) of the surface."""
MARGIN = 0.94
"""Part of a picture's width and height that the shapes fill."""


def draw_matches(
    result: Correspondence,
    path: str | os.PathLike[str] | IO[bytes],
    *,
    most: int = 60,
    size: tuple[int, int] = (1600, 800),
    title: str | None = None,
    view: tuple[float, float] | None = None,
) -> None:
    """Draw both surfaces with their matches, as a PNG file.

    The source is on the left and the target on the right, seen from the same direction. The colour of a match depends
    on its position on the source, so a sphere on the target whose colour differs from its neighbours' is likely an
    error. The radius grows with the confidence. Voted matches are spheres, recovered ones octahedra. Matches on the
    far side of a surface are not drawn.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`. The meshes of a loaded result are read from their files.
    path
        A file name ending in ``.png``, or a binary stream. A file appears whole or not at all.
    most
        Maximum number of matches drawn: the most confident one, then in turn the one farthest from those chosen, by
        the distance in space between source points.
    size
        Width and height in pixels.
    title
        A line of text above the picture.
    view
        Azimuth and elevation of the viewpoint in degrees: (0, 0) is the front, (90, 0) the shapes' left, (0, 90) above.
        By default the direction from which most matches are visible.

    Raises
    ------
    SettingsError
        If the name has another ending, or a number is out of range.
    MeshError
        If a mesh of a loaded result was an array or has changed since the match.
    FormatError
        If a mesh of a loaded result cannot be read.
    """
    _check(path, most, size, view)
    width, height = size
    meshes = mesh_of(result.source, result.source_info), mesh_of(result.target, result.target_info)
    chosen = farthest_first(meshes[0].vertices[vertices_numbered(meshes[0], result.pairs[:, 0])], most)
    confidence = np.clip(np.nan_to_num(result.confidence[chosen]), 0, 1)
    sides = [shape_of(mesh, vertices) for mesh, vertices in zip(meshes, result.pairs[chosen].T, strict=True)]
    colours = colours_of(sides[0].vertices[sides[0].matched])
    azimuth, elevation = np.radians(view) if view is not None else (best_azimuth(sides), ELEVATION)
    shapes = [side.turned(float(azimuth), float(elevation)) for side in sides]
    diamonds = result.kind[chosen] != "voted"
    title_height = round(0.07 * height) if title else 0
    space = np.array([width // 2, height - title_height]) * MARGIN
    scales = [float((space / (np.ptp(shape.vertices[:, :2], axis=0) + 2 * RADIUS)).min()) for shape in shapes]
    # Both at one scale, so that equal areas look equal, unless one of them would become tiny.
    halves = [
        render(
            shape,
            max(min(scales), scale / 1.5),
            (half_width, height - title_height),
            RADIUS * (0.4 + 0.6 * confidence),
            colours,
            diamonds=diamonds,
        )
        for shape, scale, half_width in zip(shapes, scales, (width // 2, width - width // 2), strict=True)
    ]
    content = _png(np.concatenate(halves, axis=1), (width, height), title)
    if isinstance(path, str | os.PathLike):
        write_atomically(Path(path), content)
    else:
        path.write(content)


def farthest_first(points: np.ndarray, most: int) -> np.ndarray:
    """Numbers, ascending, of at most so many points (q, 3): the first, then the one farthest from these, and so on."""
    chosen = farthest_points(
        lambda point: np.linalg.norm(points - points[point], axis=1),
        np.full(len(points), np.inf),
        min(most, len(points)),
    )
    return np.sort(np.array([point for point, _ in chosen], np.int64))


def draw_shapes(
    shapes: np.ndarray,
    faces: np.ndarray,
    *,
    size: tuple[int, int] = (800, 800),
    paint: np.ndarray | None = None,
) -> Iterator[np.ndarray]:
    """Draw shapes that share their faces, all from one viewpoint and at one scale.

    Parameters
    ----------
    shapes
        (T, n, 3) positions.
    faces
        (m, 3) vertex numbers.
    size
        Width and height in pixels.
    paint
        (n, 3) RGB colours of the vertices, 0 to 1; grey if None.

    Yields
    ------
    numpy.ndarray
        (h, w, 3) float32 RGB, 0 to 1, for each shape.
    """
    placed = placed_upright(shapes.reshape(-1, 3), faces, shapes[0]).reshape(shapes.shape)
    no_matches = np.empty(0, np.int64)
    azimuth = best_azimuth([with_normals(shape, faces, no_matches) for shape in placed[[0, len(placed) // 2, -1]]])
    # Turned together, so that all have one centre.
    together = Shape(placed.reshape(-1, 3), faces, placed.reshape(-1, 3), no_matches)
    turned = together.turned(azimuth, ELEVATION).vertices
    scale = float((MARGIN * np.array(size) / np.ptp(turned[:, :2], axis=0)).min())
    for shape in turned.reshape(shapes.shape):
        yield render(with_normals(shape, faces, no_matches), scale, size, np.empty(0), np.empty((0, 3)), paint)


def png(picture: np.ndarray) -> bytes:
    """The bytes of a PNG file with a picture (h, w, 3), 0 to 1."""
    return _png(picture, (picture.shape[1], picture.shape[0]), None)


def _check(path: Any, most: int, size: tuple[int, int], view: tuple[float, float] | None) -> None:
    if isinstance(path, str | os.PathLike) and Path(path).suffix.lower() != ".png":
        raise SettingsError(f"{path}: pictures are written as PNG; give a name that ends in .png")
    if not isinstance(most, int | np.integer) or most < 0:
        raise SettingsError(f"`most` is {most!r}; it must be an integer from 0")
    if np.shape(size) != (2,) or not all(
        isinstance(number, int | np.integer) and SMALLEST <= number <= LARGEST for number in size
    ):
        raise SettingsError(f"`size` is {size!r}; it must be width and height, {SMALLEST} to {LARGEST} pixels each")
    if view is not None and (np.shape(view) != (2,) or not np.isfinite(view).all()):
        raise SettingsError(f"`view` is {view!r}; it must be azimuth and elevation, two numbers in degrees")


def _png(picture: np.ndarray, size: tuple[int, int], title: str | None) -> bytes:
    """The bytes of a PNG file of this size, with the title above the picture."""
    from PIL import Image

    width, height = size
    pixels = _titled(width, height, title) if title else np.full((height, width, 3), 255, np.uint8)
    pixels[height - len(picture) :] = np.round(picture * 255)
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", dpi=(100, 100))
    return buffer.getvalue()


def _titled(width: int, height: int, title: str) -> np.ndarray:
    """A white picture (h, w, 3) with the title at the top."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    # Slightly more than the size, which matplotlib rounds down.
    figure = Figure(figsize=((width + 0.1) / 100, (height + 0.1) / 100), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    figure.text(
        0.5, 0.96, " ".join(title.split()), ha="center", va="center", color="0.25", parse_math=False,
        usetex=False, family="DejaVu Sans", fontsize=0.025 * height,
    )  # fmt: skip
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()
