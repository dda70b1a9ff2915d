"""Lengths and areas that neither overflow nor underflow, for meshes in any unit."""

from __future__ import annotations

import numpy as np

from .mesh import Floats, Ints


def box_scale(vertices: Floats) -> float:
    """Half of the largest extent, by which `unit_box` divides; 1 where all vertices coincide."""
    scale = float((vertices.max(axis=0) / 2 - vertices.min(axis=0) / 2).max()) if len(vertices) else 0.0
    return scale or 1.0


def areas(vertices: Floats, faces: Ints) -> Floats:
    """Area of each face (m,), in the units of `unit_box`."""
    return 0.5 * np.linalg.norm(cross_products(unit_box(vertices), faces), axis=1)


def unit_box(vertices: Floats) -> Floats:
    """The vertices, moved and scaled into the box from -1 to 1."""
    if not len(vertices):
        return vertices
    centre = vertices.min(axis=0) / 2 + vertices.max(axis=0) / 2
    return (vertices - centre) / box_scale(vertices)


def cross_products(vertices: Floats, faces: Ints) -> Floats:
    """Twice the area vector of each face (m, 3)."""
    a = vertices[faces[:, 0]]
    return np.cross(vertices[faces[:, 1]] - a, vertices[faces[:, 2]] - a)


def vertex_sums(faces: Ints, vectors: Floats, n_vertices: int) -> Floats:
    """Sum (n, 3) of the vectors (m, 3) of the faces around each vertex; of area vectors, an unnormalised normal."""
    corner = faces.ravel()
    return np.stack([np.bincount(corner, np.repeat(v, 3), n_vertices) for v in vectors.T], axis=1)


def twins(vertices: Floats) -> Ints:
    """For each vertex the lowest-numbered one with exactly the same coordinates."""
    order = np.lexsort(vertices.T)  # stable, so the lowest number leads each group
    ranked = vertices[order]
    fresh = np.ones(len(vertices), dtype=bool)
    fresh[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    twin = np.empty(len(vertices), dtype=np.int64)
    twin[order] = order[fresh][np.cumsum(fresh) - 1]
    return twin
