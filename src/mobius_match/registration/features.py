"""What points are compared by in registration, beside their positions."""

from __future__ import annotations

import numpy as np

from ..geometry.normals import vertex_normals
from ..surface.surface import Surface
from .parameters import FeatureWeights


def appearance(surface: Surface, weights: FeatureWeights) -> np.ndarray:
    """Weighted descriptors and curvatures (n, d) of the vertices; no column for what has no weight."""
    kinds: list[np.ndarray] = [np.empty((len(surface.mesh.vertices), 0), np.float32)]
    if weights.descriptor:
        kinds.append(weights.descriptor * surface.descriptors)
    if weights.curvature:
        kinds.append(weights.curvature * surface.curvature_features)
    return np.hstack(kinds)


def features(
    positions: np.ndarray, normals: np.ndarray, spectral: np.ndarray, appearance: np.ndarray, weights: FeatureWeights
) -> np.ndarray:
    """All features (p, 6 + k + d) float32 of points; single precision halves the time of the search."""
    return np.hstack([positions, weights.normal * normals, weights.spectral * spectral, appearance]).astype(np.float32)


def rotated_normals(normals: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Normals (p, 3) after rotations (p, 3, 3) of rows."""
    return np.asarray(np.einsum("ni,nij->nj", normals, rotations))


def oriented_points(vertices: np.ndarray, faces: np.ndarray, weight: float) -> np.ndarray:
    """Positions and weighted normals (n, 6) of vertices, which tell the two sides of a thin sheet apart."""
    return np.hstack([vertices, weight * vertex_normals(vertices, faces)])
