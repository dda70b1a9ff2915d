"""Section 6, equations 3 and 4, as kernels: samples moved to the canonical domain of a triplet.

The canonical domain is the plane in which the points of the triplet lie at the corners of an equilateral triangle, or
the sphere above it (section 7). Samples come as the columns of float64 arrays (2, padded), the real and imaginary parts
of z; images are float32, (3, padded), the third coordinate for the sphere.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit
from .mobius import CANONICAL_TRIANGLE
from .nearest import padded

INFINITE = 1e100  # stands for infinity among the samples: less any other sample it is the same, to the last digit
FAR = 1e15  # stands for infinity in the canonical plane; its square still fits a float32

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)
SIDE = abs(Y1 - Y3)
TURN = SIDE / (Y1 - Y3)
"""The canonical triangle is turned so that y1 - y3 is real, which saves products and keeps all distances."""
CORNER = Y3 * TURN
RATIO = (Y1 - Y2) / (Y2 - Y3)


def coordinates(points: np.ndarray) -> np.ndarray:
    """Homogeneous points (N, 2) as the real and imaginary parts of z, (2, padded); the last point is repeated."""
    p, q = points[np.minimum(np.arange(padded(len(points))), len(points) - 1)].T
    infinite = q == 0
    z = np.where(infinite, INFINITE, p / np.where(infinite, 1.0, q))
    return np.stack([z.real, z.imag])


@jit
def to_canonical_plane(samples: np.ndarray, triplets: np.ndarray, i: int, image: np.ndarray) -> bool:
    """Apply the map m with m(z_j) = y_j (equations 3 and 4) to all samples; False if two of the z_j are equal.

    Only differences of samples are used, which are exact: samples may differ by 1e-10 of the plane's extent. With
    u = z - z_1, v = z_3 - z and r = (y_1 - y_2) / (y_2 - y_3) * z_23 / z_12, m(z) = y_3 + (y_1 - y_3) v / (r u + v).
    """
    one, two, three = triplets[i, 0], triplets[i, 1], triplets[i, 2]
    x1, y1 = samples[0, one], samples[1, one]
    x2, y2 = samples[0, two], samples[1, two]
    x3, y3 = samples[0, three], samples[1, three]
    z12, z23, z31 = complex(x1 - x2, y1 - y2), complex(x2 - x3, y2 - y3), complex(x3 - x1, y3 - y1)
    if z12 == 0 or z23 == 0 or z31 == 0:
        return False
    r = RATIO * z23 / z12
    for k in range(samples.shape[1]):
        ux, uy = samples[0, k] - x1, samples[1, k] - y1
        vx, vy = x3 - samples[0, k], y3 - samples[1, k]
        dx, dy = r.real * ux - r.imag * uy + vx, r.real * uy + r.imag * ux + vy
        real, imag, square = vx * dx + vy * dy, vy * dx - vx * dy, dx * dx + dy * dy
        scale = SIDE / square
        finite = square * FAR > abs(real) + abs(imag)
        image[0, k] = CORNER.real + real * scale if finite else FAR
        image[1, k] = CORNER.imag + imag * scale if finite else 0.0
    return True


@jit
def to_sphere(image: np.ndarray) -> None:
    """Stereographic projection of canonical points, in place, to the unit sphere."""
    for k in range(image.shape[1]):
        x, y = np.float64(image[0, k]), np.float64(image[1, k])
        square = x * x + y * y
        scale = 1 / (1 + square)
        image[0, k], image[1, k], image[2, k] = 2 * x * scale, 2 * y * scale, (square - 1) * scale
