"""Figure 1 of the paper: two surfaces side by side, each match a sphere of the same colour on both.

Drawn on the processor alone: triangles and spheres go through one depth buffer, so that a surface hides what lies
behind it. Nothing here needs a display, and the same result gives the same bytes.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from .._core.files import write_atomically
from ..errors import MeshError, SettingsError
from ..geometry.farthest_points import farthest_points
from ..mesh import as_mesh, repair
from ..mesh.files import unchanged
from ..mesh.measure import cross_products, unit_box, vertex_sums
from .rendering import Shape, rasterise, render, unit, visible

if TYPE_CHECKING:
    from ..mesh import Mesh
    from ..results.correspondence import Correspondence

SMALLEST, LARGEST = 64, 4096
"""Limits of a picture's width and height in pixels."""
RADIUS = 0.042
"""Radius of the sphere of a match of confidence 1, per sqrt(area) of the surface."""
AZIMUTHS = np.radians(np.arange(0, 360, 22.5))
ELEVATION = np.radians(12)
"""Directions to look from; azimuth 0 is the front."""


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

    The source is on the left and the target on the right, from the same side. A match has one colour, given by
    its place on the source, so that a sphere whose colour differs from its neighbours' is likely an error; its
    radius grows with its confidence. Voted matches are spheres, recovered ones diamonds. A match that the surface
    hides is not drawn.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`; for one that was loaded from a file, the meshes are read again.
    path
        Where to write: a name ending in ``.png`` or a binary stream. A file appears whole or not at all.
    most
        Draw only this many matches: the most confident one, then each time that which lies farthest from these on the
        source.
    size
        Width and height in pixels.
    title
        A line of text above.
    view
        Azimuth and elevation to look from, in degrees: (0, 0) is the front, (90, 0) the shapes' left, (0, 90) from
        above. By default from where most of the matches can be seen.

    Raises
    ------
    SettingsError
        If the name has another ending, or a number is out of range.
    MeshError
        If the meshes of a loaded result cannot be read, or have changed since the match.
    """
    _check(path, most, size, view)
    width, height = size
    meshes = mesh_of(result.source, result.source_info), mesh_of(result.target, result.target_info)
    chosen = farthest_first(meshes[0].vertices[numbered(meshes[0], result.pairs[:, 0])], most)
    confidence = np.clip(np.nan_to_num(result.confidence[chosen]), 0, 1)
    sides = [shape_of(mesh, vertices) for mesh, vertices in zip(meshes, result.pairs[chosen].T, strict=True)]
    colours = colours_of(sides[0].vertices[sides[0].matched])
    azimuth, elevation = np.radians(view) if view is not None else (best_azimuth(sides), ELEVATION)
    shapes = [side.turned(float(azimuth), float(elevation)) for side in sides]
    diamonds = result.kind[chosen] != "voted"
    # Both at one scale (equal areas look equal), unless that would make one of them tiny.
    top = round(0.07 * height) if title else 0
    room = np.array([width // 2, height - top]) * 0.94
    fits = [float((room / (np.ptp(shape.vertices[:, :2], axis=0) + 2 * RADIUS)).min()) for shape in shapes]
    halves = [
        render(
            shape,
            max(min(fits), fit / 1.5),
            (w, height - top),
            RADIUS * (0.4 + 0.6 * confidence),
            colours,
            diamonds=diamonds,
        )
        for shape, fit, w in zip(shapes, fits, (width // 2, width - width // 2), strict=True)
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
    """Draw shapes that share their faces, all from one place, in one light and at one scale.

    Parameters
    ----------
    shapes
        (T, n, 3) positions.
    faces
        (m, 3) vertex numbers.
    size
        Width and height in pixels.
    paint
        (n, 3) colours of the vertices from 0 to 1; grey if None.

    Yields
    ------
    numpy.ndarray
        (h, w, 3) float32 in [0, 1] for each shape.
    """
    everything = unit_box(shapes.reshape(-1, 3))
    if _up(shapes[0].min(axis=0), shapes[0].max(axis=0)) == 2:
        everything = everything[:, [0, 2, 1]] * [1, 1, -1]
    placed = everything.reshape(shapes.shape)
    area = np.linalg.norm(cross_products(placed[0], faces), axis=1).sum() / 2
    placed = placed / max(np.sqrt(area), 1e-3)
    nothing = np.empty(0, np.int64)
    azimuth = best_azimuth([_solid(one, faces, nothing) for one in placed[[0, len(placed) // 2, -1]]])
    # Turned together, so that the middle of the picture is the middle of all.
    turned = Shape(placed.reshape(-1, 3), faces, placed.reshape(-1, 3), nothing).turned(azimuth, ELEVATION).vertices
    scale = float((0.94 * np.array(size) / np.ptp(turned[:, :2], axis=0)).min())
    for shape in turned.reshape(shapes.shape):
        yield render(_solid(shape, faces, nothing), scale, size, np.empty(0), np.empty((0, 3)), paint)


def png(picture: np.ndarray) -> bytes:
    """A picture (h, w, 3) in [0, 1] as the bytes of a PNG file."""
    return _png(picture, (picture.shape[1], picture.shape[0]), None)


def _check(path: Any, most: int, size: tuple[int, int], view: tuple[float, float] | None) -> None:
    if isinstance(path, str | os.PathLike) and Path(path).suffix.lower() != ".png":
        raise SettingsError(f"{path}: pictures are PNG files; give a name that ends in .png")
    if not isinstance(most, int | np.integer) or most < 0:
        raise SettingsError(f"most is {most!r}; it must be a whole number from 0")
    if np.shape(size) != (2,) or not all(
        isinstance(number, int | np.integer) and SMALLEST <= number <= LARGEST for number in size
    ):
        raise SettingsError(f"size is {size!r}; it must be width and height, {SMALLEST} to {LARGEST} pixels each")
    if view is not None and (np.shape(view) != (2,) or not np.isfinite(view).all()):
        raise SettingsError(f"view is {view!r}; it must be azimuth and elevation, two numbers in degrees")


def mesh_of(surface: Any, info: dict[str, Any]) -> Mesh:
    """The repaired mesh of one side, read again where the result comes from a file."""
    if surface is not None:
        return surface.whole_mesh
    return repair(as_mesh(unchanged(info.get("path"), info.get("sha256", ""))))


def numbered(mesh: Mesh, numbers: np.ndarray) -> np.ndarray:
    """Which vertices of a repaired mesh have the user's numbers; of those that share a number, the first."""
    order = np.argsort(mesh.vertex_ids, kind="stable")
    place = np.searchsorted(mesh.vertex_ids[order], numbers).clip(max=len(order) - 1)
    matched = order[place]
    wrong = numbers[mesh.vertex_ids[matched] != numbers]
    if len(wrong):
        raise MeshError(f"{mesh.name}: has no vertex {wrong[0]}, which the result names; match again")
    return matched


def shape_of(mesh: Mesh, numbers: np.ndarray) -> Shape:
    """The mesh at area 1 with y upward, and where in it the user's vertex numbers are."""
    matched = numbered(mesh, numbers)
    vertices = unit_box(mesh.vertices)
    if _up(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) == 2:
        vertices = vertices[:, [0, 2, 1]] * [1, 1, -1]
    area = np.linalg.norm(cross_products(vertices, mesh.faces), axis=1).sum() / 2
    return _solid(vertices / max(np.sqrt(area), 1e-3), mesh.faces, matched)


def _solid(vertices: np.ndarray, faces: np.ndarray, matched: np.ndarray) -> Shape:
    return Shape(vertices, faces, unit(vertex_sums(faces, cross_products(vertices, faces), len(vertices))), matched)


def _up(low: np.ndarray, high: np.ndarray) -> int:
    """The axis that points upward, y (1) or z (2), by what most files have in common."""
    extent = high - low
    grounded = np.abs(low) < 0.03 * extent  # what stands on the ground begins at 0
    if grounded[1] != grounded[2]:
        return 1 if grounded[1] else 2
    thinnest = int(np.argmin(extent))
    if thinnest == 0:  # seen from the side: animals are longer than they are tall
        return 1 if extent[1] <= extent[2] else 2
    return 3 - thinnest  # seen from the front: people are taller than they are thick


def best_azimuth(sides: list[Shape]) -> float:
    """The direction from which most matches can be seen on both surfaces, and much of the surfaces."""
    n = 160
    scores = []
    for azimuth in AZIMUTHS:
        seen, covered = np.ones(len(sides[0].matched)), 0.0
        for side in sides:
            shape = side.turned(azimuth, ELEVATION)
            pixels = shape.vertices * (0.6 * n / np.ptp(side.vertices, axis=0).max()) + [n / 2, n / 2, 0]
            depth, _ = rasterise(pixels, shape, (n, n))
            seen *= visible(pixels[side.matched], depth, 0.02 * n)
            covered += np.isfinite(depth).mean()
        scores.append((seen.mean() if len(seen) else 0.0, covered))
    seen, covered = np.array(scores).T
    # Between equals, from the front: most files look towards +z (or -y where z is up).
    total = seen + 0.5 * covered / max(covered.max(), 1e-9) + 0.02 * np.cos(AZIMUTHS)
    return float(AZIMUTHS[np.argmax(total)])


def colours_of(points: np.ndarray) -> np.ndarray:
    """A colour (Q, 3) for each point (Q, 3): hue by the longest axis, lightness by the others.

    From blue by red to yellow, an order that the common colour blindnesses keep, and far from grey everywhere.
    """
    centred = points - points.sum(axis=0) / max(len(points), 1)
    axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1]
    along = centred @ (axes * np.where(axes.sum(axis=0) < 0, -1, 1))
    extent = np.abs(along).max(axis=0, initial=1e-9)
    along = along / np.maximum(extent, 0.1 * extent.max())
    rank = along[:, 0].argsort(kind="stable").argsort() / max(len(points) - 1, 1)
    # Between rank and distance: neighbours stay alike, and the whole range is used.
    first = rank / 2 + (along[:, 0] + 1) / 4
    hue = np.radians(258 + 200 * first)
    lightness = 0.50 + 0.32 * first + np.tanh(3 * along[:, 1:]) @ [0.11, 0.06]
    a, b = 0.2 * np.cos(hue), 0.2 * np.sin(hue)
    # Oklab to linear sRGB to sRGB: B. Ottosson, "A perceptual color space for image processing", 2020.
    lms = np.stack([lightness, a, b], axis=1) @ np.array([
        [1, 1, 1],
        [0.3963377774, -0.1055613458, -0.0894841775],
        [0.2158037573, -0.0638541728, -1.2914855480],
    ])  # fmt: skip
    linear = lms**3 @ np.array([
        [4.0767416621, -1.2684380046, -0.0041960863],
        [-3.3077115913, 2.6097574011, -0.7034186147],
        [0.2309699292, -0.3413193965, 1.7076147010],
    ])  # fmt: skip
    return (np.clip(linear, 0, 1) ** (1 / 2.2)).astype(np.float32)


def _png(picture: np.ndarray, size: tuple[int, int], title: str | None) -> bytes:
    """The bytes of a PNG file, with the title in the space above the picture."""
    from PIL import Image

    width, height = size
    pixels = _titled(width, height, title) if title else np.full((height, width, 3), 255, np.uint8)
    pixels[height - len(picture) :] = np.round(picture * 255)
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", dpi=(100, 100))
    return buffer.getvalue()


def _titled(width: int, height: int, title: str) -> np.ndarray:
    """A white picture (h, w, 3) with a line of text at the top."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    # A hair more than the size, which matplotlib rounds down.
    figure = Figure(figsize=((width + 0.1) / 100, (height + 0.1) / 100), dpi=100, facecolor="white")
    canvas = FigureCanvasAgg(figure)
    figure.text(
        0.5, 0.96, " ".join(title.split()), ha="center", va="center", color="0.25", parse_math=False,
        usetex=False, family="DejaVu Sans", fontsize=0.025 * height,
    )  # fmt: skip
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3].copy()
