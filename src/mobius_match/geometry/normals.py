"""Vertex normals, weighted by area."""

from __future__ import annotations

import numpy as np

from ..mesh.measure import cross_products, vertex_sums


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) at the vertices; 0 where the faces around a vertex have no area."""
    sums = vertex_sums(faces, cross_products(vertices, faces), len(vertices))
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), np.finfo(float).tiny)
