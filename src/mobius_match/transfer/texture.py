"""Transfer of texture coordinates, which are given at the corners of faces and jump at seams."""

from __future__ import annotations

import numpy as np

from ..geometry.points import SurfacePoints
from ..mesh import Mesh
from ..mesh.measure import twins
from ..results.surface_map import SurfaceMap

MAX_EXTRAPOLATION = 3.0
"""Largest absolute barycentric coordinate of a corner outside the face whose texture it takes."""


def repaired_uv(file: Mesh, repaired: Mesh, uv: np.ndarray) -> np.ndarray:
    """Texture coordinates at the corners of the repaired mesh's faces.

    Parameters
    ----------
    file, repaired
        The same mesh, as in the user's file (m faces) and repaired (m' faces).
    uv
        (m, 3, 2) at the corners of ``file.faces``.

    Returns
    -------
    numpy.ndarray
        (m', 3, 2); NaN where repair has flipped an edge.
    """
    twin = twins(file.vertices)
    # A corner of a face has one key in both meshes: the number of the face and the vertex.
    size = len(twin)
    file_keys = (file.face_ids[:, None] * size + twin[file.faces]).ravel()
    keys = (repaired.face_ids[:, None] * size + twin[repaired.vertex_ids[repaired.faces]]).ravel()
    order = np.argsort(file_keys, kind="stable")
    corner = order[np.searchsorted(file_keys[order], keys).clip(max=len(order) - 1)]
    at_corners = np.where((file_keys[corner] == keys)[:, None], uv.reshape(-1, 2)[corner], np.nan)
    return at_corners.reshape(-1, 3, 2)


def transferred_uv(surface_map: SurfaceMap, source_uv: np.ndarray, target_faces: np.ndarray) -> np.ndarray:
    """Texture coordinates of faces of the target.

    A face takes those of the source face that contains the image of its centre, extrapolated linearly to its corners.
    Where the image of a corner itself has nearly the same coordinates, these are used. So no face spans a seam.

    Parameters
    ----------
    surface_map
        The map.
    source_uv
        (m1, 3, 2) at the corners of the repaired source's faces.
    target_faces
        (m, 3) vertices of the repaired target; -1 for none.

    Returns
    -------
    numpy.ndarray
        (m, 3, 2); NaN for faces without a counterpart, or with a vertex -1.
    """
    source, points = surface_map.source, surface_map.source_points
    centres = SurfacePoints(np.full(len(target_faces), -1), target_faces, np.full((len(target_faces), 3), 1 / 3))
    images, mapped = surface_map.inverse.map_points(centres)
    corners = points.values(source.vertices)[target_faces]
    weights = _extrapolation_weights(source.vertices[images.corners], corners)
    extrapolated = np.einsum("mck,mkd->mcd", weights, source_uv[images.faces])
    size = np.linalg.norm(extrapolated - np.roll(extrapolated, 1, axis=1), axis=2).max(axis=1)
    at_corners = np.einsum("nk,nkd->nd", points.barycentric, source_uv[points.faces])[target_faces]
    in_chart = np.linalg.norm(at_corners - extrapolated, axis=2) <= size[:, None]
    transferred = np.where(in_chart[..., None], at_corners, extrapolated)
    transferred[~mapped | (target_faces < 0).any(axis=1)] = np.nan
    return transferred


def _extrapolation_weights(triangles: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (m, c, 3) of positions (m, c, 3) in the planes of triangles (m, 3, 3)."""
    edges = triangles[:, 1:] - triangles[:, :1]
    offsets = positions - triangles[:, :1]
    gram, products = np.einsum("mik,mjk->mij", edges, edges), np.einsum("mck,mik->mci", offsets, edges)
    (a, b), c = gram[:, 0].T, gram[:, 1, 1]
    determinant = np.maximum(a * c - b * b, 1e-12 * a * c + np.finfo(float).tiny)[:, None]
    second = (products[..., 0] * c[:, None] - products[..., 1] * b[:, None]) / determinant
    third = (products[..., 1] * a[:, None] - products[..., 0] * b[:, None]) / determinant
    second, third = (np.clip(weight, -MAX_EXTRAPOLATION, MAX_EXTRAPOLATION) for weight in (second, third))
    return np.stack([1 - second - third, second, third], axis=2)
