"""The scene of a picture: shapes upright and of area 1, the direction of view, and the colours of matches."""

from __future__ import annotations

import numpy as np

from ..geometry.normals import vertex_normals
from ..mesh import Mesh
from ..mesh.measure import cross_products, unit_box
from .rendering import Shape, rasterise, visible
from .result_meshes import vertices_numbered

AZIMUTHS = np.radians(np.arange(0, 360, 22.5))
"""View directions to choose from; azimuth 0 is the front."""
ELEVATION = np.radians(12)
"""Height of the viewpoint above the horizon."""


def shape_of(mesh: Mesh, numbers: np.ndarray) -> Shape:
    """The mesh with area 1 and y upward, and its vertices with these numbers of the user's file."""
    matched = vertices_numbered(mesh, numbers)
    return with_normals(placed_upright(mesh.vertices, mesh.faces, mesh.vertices), mesh.faces, matched)


def placed_upright(vertices: np.ndarray, faces: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Vertices with y upward, at the scale at which the first shape, whose faces are given, has area 1."""
    placed = unit_box(vertices)
    if _up(reference.min(axis=0), reference.max(axis=0)) == 2:
        placed = placed[:, [0, 2, 1]] * [1, 1, -1]
    area = np.linalg.norm(cross_products(placed, faces), axis=1).sum() / 2
    return placed / max(np.sqrt(area), 1e-3)


def with_normals(vertices: np.ndarray, faces: np.ndarray, matched: np.ndarray) -> Shape:
    """The shape with normals at its vertices."""
    return Shape(vertices, faces, vertex_normals(vertices, faces), matched)


def _up(low: np.ndarray, high: np.ndarray) -> int:
    """The axis that points upward, y (1) or z (2), by rules that hold for most files."""
    extent = high - low
    grounded = np.abs(low) < 0.03 * extent  # a shape that stands on the ground begins at 0
    if grounded[1] != grounded[2]:
        return 1 if grounded[1] else 2
    thinnest = int(np.argmin(extent))
    if thinnest == 0:  # a side view: animals are longer than tall
        return 1 if extent[1] <= extent[2] else 2
    return 3 - thinnest  # a front view: people are taller than thick


def best_azimuth(sides: list[Shape]) -> float:
    """The azimuth (radians) from which most matches, and much of both surfaces, are visible."""
    n = 160  # pixels along each side of the pictures that are compared
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
    # Of equally good directions the front is preferred; most shapes face +z, or -y where z is up.
    total = seen + 0.5 * covered / max(covered.max(), 1e-9) + 0.02 * np.cos(AZIMUTHS)
    return float(AZIMUTHS[np.argmax(total)])


def colours_of(points: np.ndarray) -> np.ndarray:
    """A colour for each point: hue along the longest principal axis, lightness along the others.

    Hues go from blue over red to yellow, which remain distinct with the common colour-vision deficiencies, and all
    colours are far from grey.

    Parameters
    ----------
    points
        (Q, 3) positions.

    Returns
    -------
    numpy.ndarray
        (Q, 3) float32 sRGB, 0 to 1.
    """
    centred = points - points.sum(axis=0) / max(len(points), 1)
    axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1]
    along = centred @ (axes * np.where(axes.sum(axis=0) < 0, -1, 1))
    extent = np.abs(along).max(axis=0, initial=1e-9)
    along = along / np.maximum(extent, 0.1 * extent.max())
    rank = along[:, 0].argsort(kind="stable").argsort() / max(len(points) - 1, 1)
    # The mean of rank and position: neighbours have similar hues, and the whole range is used.
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
