"""Software rendering of a surface with spheres on it, with one depth buffer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core.compiling import jit
from .._core.display import one_line
from ..transfer.colours import SURFACE_GREY

LIGHT = np.array([-0.45, 0.60, 0.66], np.float32)
"""Unit vector towards the light, at the upper left."""
HALFWAY = np.array([-0.25, 0.33, 0.91], np.float32)
"""Unit vector halfway between light and viewer, for highlights (Blinn and Phong)."""
OCTAHEDRON = 1.25
"""Distance of the corners of an octahedron from its centre, in radii of a sphere."""


@dataclass(frozen=True)
class Shape:
    """A surface of area 1 with y upward, its unit normals at the vertices, and its matched vertices."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    matched: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)

    def turned(self, azimuth: float, elevation: float) -> Shape:
        """In view coordinates: x to the right, y up, z towards the viewer, the centre at 0. Angles are in radians."""
        c, s, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
        turn = np.array([[c, 0, -s], [-s * se, ce, -c * se], [s * ce, se, c * ce]])
        vertices = self.vertices @ turn.T
        centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        return Shape(vertices - centre, self.faces, self.normals @ turn.T, self.matched)


def unit(vectors: np.ndarray) -> np.ndarray:
    """The vectors (n, 3) normalised to length 1; zero vectors stay zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))[:, None]
    return vectors / np.maximum(lengths, 1e-30)


def rasterise(pixels: np.ndarray, shape: Shape, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Rasterise the shape with its vertices at other positions.

    Parameters
    ----------
    pixels
        (n, 3) positions of the vertices in pixels.
    shape
        Faces and normals.
    size
        Height h and width w.

    Returns
    -------
    depth
        (h, w) largest z, -inf for the background; row 0 is at y = 0.
    normal
        (h, w, 3) interpolated normals of the front surface.
    """
    depth = np.full(size, -np.inf, np.float32)
    normal = np.zeros((*size, 3), np.float32)
    _fill(pixels, shape.faces, shape.normals, depth, normal)
    return depth, normal


@jit
def _fill(points: np.ndarray, faces: np.ndarray, normals: np.ndarray, depth: np.ndarray, normal: np.ndarray) -> None:
    """Draw triangles with interpolated normals; the greatest z wins."""
    height, width = depth.shape
    for a, b, c in faces:
        x0, y0 = points[a, 0], points[a, 1]
        x1, y1 = points[b, 0], points[b, 1]
        x2, y2 = points[c, 0], points[c, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0:
            continue
        sign = 1.0 if area > 0 else -1.0  # the back of an open surface is shaded like its front
        for y in range(max(0, int(min(y0, y1, y2))), min(height - 1, int(max(y0, y1, y2))) + 1):
            for x in range(max(0, int(min(x0, x1, x2))), min(width - 1, int(max(x0, x1, x2))) + 1):
                px, py = x + 0.5, y + 0.5
                u = ((x1 - px) * (y2 - py) - (x2 - px) * (y1 - py)) / area
                v = ((x2 - px) * (y0 - py) - (x0 - px) * (y2 - py)) / area
                w = 1.0 - u - v
                if min(u, v, w) < -1e-9:  # a tolerance, so that no pixel falls between two triangles
                    continue
                z = u * points[a, 2] + v * points[b, 2] + w * points[c, 2]
                if z > depth[y, x]:
                    depth[y, x] = z
                    for k in range(3):
                        normal[y, x, k] = sign * (u * normals[a, k] + v * normals[b, k] + w * normals[c, k])


def visible(points: np.ndarray, depth: np.ndarray, tolerance: float) -> np.ndarray:
    """Which points (q, 3), in pixels, no surface hides."""
    y, x = (np.clip(points[:, k].astype(int), 0, depth.shape[1 - k] - 1) for k in (1, 0))
    return points[:, 2] >= depth[y, x] - tolerance


def render(
    shape: Shape,
    scale: float,
    size: tuple[int, int],
    radii: np.ndarray,
    colours: np.ndarray,
    paint: np.ndarray | None = None,
    diamonds: np.ndarray | None = None,
) -> np.ndarray:
    """One surface with its matches as spheres, on white.

    Parameters
    ----------
    shape
        The surface in view coordinates.
    scale
        Pixels per unit of length.
    size
        Width w and height h in pixels.
    radii, colours
        (Q,) in units of length and (Q, 3) RGB, 0 to 1, of the spheres at ``shape.matched``.
    paint
        (n, 3) RGB colours of the vertices, 0 to 1; grey if None.
    diamonds
        (Q,) bool: which matches are octahedra, with a corner towards the viewer, instead of spheres.

    Returns
    -------
    numpy.ndarray
        (h, w, 3) float32, 0 to 1, the first row at the top.
    """
    width, height = size
    fine = 3 if width * height < 1_500_000 else 2  # samples along each side of a pixel
    pixels = fine * (shape.vertices * scale + [width / 2, height / 2, 0])
    depth, normal = rasterise(pixels, shape, (fine * height, fine * width))
    label = np.zeros(depth.shape, np.int32)  # 0 for the surface, then the spheres
    centres = pixels[shape.matched]
    seen = np.flatnonzero(visible(centres, depth, 0.01 * scale * fine))
    for k, (x, y, z), radius in zip(seen, centres[seen], fine * scale * radii[seen], strict=True):
        reach = OCTAHEDRON * radius
        rows, columns = (slice(max(0, int(centre - reach)), int(centre + reach) + 2) for centre in (y, x))
        dy = (np.arange(depth.shape[0])[rows, None] + 0.5 - y) / radius
        dx = (np.arange(depth.shape[1])[None, columns] + 0.5 - x) / radius
        if diamonds is not None and diamonds[k]:
            dx, dy = np.broadcast_arrays(dx, dy)
            dz = OCTAHEDRON - np.abs(dx) - np.abs(dy)
            inside, normals = dz > 0, (np.sign(dx), np.sign(dy), np.ones_like(dx))
        else:
            dz = np.sqrt(np.maximum(1 - dx**2 - dy**2, 0))
            inside, normals = dx**2 + dy**2 < 1, (dx, dy, dz)
        front = inside & (z + radius * dz > depth[rows, columns])
        depth[rows, columns][front] = (z + radius * dz)[front]
        normal[rows, columns][front] = np.stack(np.broadcast_arrays(*normals), axis=2)[front]
        label[rows, columns][front] = k + 1
    inside = np.isfinite(depth)
    picture = np.ones_like(normal)
    shades = np.vstack([np.array(SURFACE_GREY, np.float32), colours])[label[inside]]
    if paint is not None:
        painted = Shape(shape.vertices, shape.faces, paint, shape.matched)
        surface = np.abs(rasterise(pixels, painted, depth.shape)[1][inside])  # negative on the back
        shades = np.where(label[inside, None] > 0, shades, surface)
    picture[inside] = _lit(normal[inside], shades, label[inside] > 0)
    averaged = np.zeros((height, width, 3), np.float32)
    for i in range(fine * fine):
        averaged += picture[i // fine :: fine, i % fine :: fine] / fine**2
    coarse = depth[fine // 2 :: fine, fine // 2 :: fine] / (fine * scale)
    return (averaged * _occlusion(coarse, 0.06 * scale)[..., None])[::-1]


def _lit(normals: np.ndarray, colours: np.ndarray, glossy: np.ndarray) -> np.ndarray:
    """Shaded colours (n, 3): diffuse light from :data:`LIGHT` and above, and highlights where ``glossy`` (n,)."""
    normals = unit(normals)
    light = 0.30 + 0.80 * ((1 + normals @ LIGHT) / 2) ** 1.5
    highlight = np.where(glossy, np.float32(0.35) * np.maximum(normals @ HALFWAY, 0) ** 40, np.float32(0))
    return np.clip(colours * light[:, None] + highlight[:, None], 0, 1)


def _occlusion(depth: np.ndarray, radius: float) -> np.ndarray:
    """Ambient occlusion in screen space: factors (h, w) below 1 where the surface is deeper than its surroundings."""
    from scipy.ndimage import uniform_filter

    def blurred(values: np.ndarray) -> np.ndarray:
        return uniform_filter(uniform_filter(values, 2 * round(radius) + 1), 2 * round(radius) + 1)

    inside = np.isfinite(depth)
    weight = np.maximum(blurred(inside.astype(np.float32)), 1e-6)
    around = blurred(np.where(inside, depth, 0)) / weight
    deeper = np.where(inside, np.clip(around - depth, 0, 0.15), 0)
    return 1 - 2.2 * deeper
