"""Every vertex of the source on the target: the bent proxy carries the whole mesh, which is then bent as closely.

Beyond the paper. What :mod:`mobius_match.registration` does with a thousand points is done until it settles, and then
once more with all vertices, from where the proxy carries them.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.nearest_neighbors import NearestNeighbors, nearest_neighbors, spatial_order
from ..geometry.normals import vertex_normals
from ..geometry.points import SurfacePoints, closest_points
from ..geometry.spectral import functional_map
from ..mesh.topology import edge_table, edges_of
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .energy import DeformationGraph
from .register import Registration

TRUST = (0.1, 0.3, 0.6, 1.2)
"""Weight of the places against rigidity, from one round to the next."""

ROUNDS, STEPS = 4, 4
"""Searches for the nearest points at each weight, and alternations of turning and moving after each."""

NORMAL, SPECTRAL, RELIEF = 0.04, 0.003, 0.015
"""How much normals, eigenfunctions and curvatures count in the nearest point, against places per sqrt(area)."""

BESIDE = 0.03
"""Distance per sqrt(area) from a bent part up to which a point of the whole belongs to it."""


CARRIERS = 6
"""Vertices of the proxy that carry each vertex of the mesh."""


def dense_map(source: Surface, target: Surface, registration: Registration, *, whole: bool = True) -> SurfaceMap:
    """The map of all the user's vertices, both ways, that a registration leads to.

    Parameters
    ----------
    source, target, registration
        The surfaces, and the source's proxy on the target.
    whole
        Whether the source covers the target. If not, what lies beyond its rim has no counterpart.
    """
    bent, bent_normals = deform(source, target, registration, whole)
    mesh1, mesh2, scale = source.mesh, target.mesh, np.sqrt(target.area)
    normals = vertex_normals(mesh2.vertices / scale, mesh2.faces)
    points = _closest(bent, bent_normals, mesh2.vertices, normals, mesh2.faces, scale)
    back = _closest(mesh2.vertices, normals, bent, bent_normals, mesh1.faces, scale)
    found = np.ones(len(mesh1.vertices), bool), np.ones(len(mesh2.vertices), bool)
    if not whole:
        apart = np.linalg.norm(back.values(bent) - mesh2.vertices, axis=1) / scale
        found = found[0], (apart <= BESIDE) & ~_on_boundary(back, mesh1.faces)
    simple = SurfaceMap(mesh1, mesh2, points, back, *found)
    return simple if source.detail is None and target.detail is None else _in_detail(source, target, simple)


def _in_detail(source: Surface, target: Surface, simple: SurfaceMap) -> SurfaceMap:
    """The map between the user's own meshes, by that of the simplified ones which stand for them."""
    sides = []
    for here, there, onward in ((source, target, simple), (target, source, simple.inverse)):
        if here.detail is None:
            points, found = onward.target_points, onward.source_mapped
        else:
            points, found = onward.map_points(here.detail.places(here.mesh))
        sides.append((points if there.detail is None else there.detail.lifted(there.mesh, points), found))
    (points, found), (back, back_found) = sides
    return SurfaceMap(source.whole_mesh, target.whole_mesh, points, back, found, back_found)


def _on_boundary(points: SurfacePoints, faces: np.ndarray) -> np.ndarray:
    """Which points (q,) bool lie on the boundary: what they stand for is beyond it."""
    table = edge_table(faces)
    rim = np.zeros(faces.max() + 1, bool)
    rim[table.edges[table.counts == 1]] = True
    return np.asarray((rim[points.corners] | (points.barycentric < 1e-9)).all(axis=1))


def deform(
    source: Surface, target: Surface, registration: Registration, whole: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Bend all of the source onto the target; if it does not cover the target, without being drawn.

    Returns
    -------
    positions, normals
        (n1, 3) float64 each: of the source's vertices, in the target's coordinates.
    """
    scale1, scale2 = np.sqrt(source.area), np.sqrt(target.area)
    rest, there = source.mesh.vertices / scale1, target.mesh.vertices / scale2
    normals1, normals2 = vertex_normals(rest, source.mesh.faces), vertex_normals(there, target.mesh.faces)
    positions, rotations = _interpolate_deformation(
        rest, source.proxy, registration.positions / scale2, registration.rotations
    )
    graph = DeformationGraph(rest, edges_of(source.mesh.faces))
    # Eigenfunctions keep a point from a limb that lies close by but belongs elsewhere, and from sliding along its own.
    # Nothing is left of them on a part, nor do curvatures hold at its rim.
    shared = source.eigenfunctions.shape[1] if whole else 0
    spectral1, spectral2 = (one.eigenfunctions[:, :shared].astype(np.float64) for one in (source, target))
    spectral1 = spectral1 @ functional_map(spectral1[source.proxy], spectral2[registration.image])
    appearance1, appearance2 = (
        np.hstack([SPECTRAL * spectral, *[RELIEF * one.curvature_features] * whole])
        for one, spectral in ((source, spectral1), (target, spectral2))
    )
    goals = _features(there, normals2, appearance2)
    among, beside = NearestNeighbors(goals), spatial_order(rest)
    for data_weight in TRUST:
        for _ in range(ROUNDS):
            seekers = _features(positions, rotated_normals(normals1, rotations), appearance1)
            places = there[among.nearest(seekers)]
            if whole:
                drawn = NearestNeighbors(seekers, beside).nearest(goals)
                number = 1 + np.bincount(drawn, minlength=len(rest))
                drawing = np.stack([np.bincount(drawn, axis, len(rest)) for axis in there.T], axis=1)
                places = (drawing + places) / number[:, None]
            positions, rotations = graph.solve(positions, places, np.full(len(rest), data_weight), STEPS)
    return positions * scale2, rotated_normals(normals1, rotations)


def _closest(
    queries: np.ndarray,
    query_normals: np.ndarray,
    vertices: np.ndarray,
    normals: np.ndarray,
    faces: np.ndarray,
    scale: float,
) -> SurfacePoints:
    """The points of a mesh that lie nearest to queries (q, 3) and are turned as they are."""
    queries, there = queries / scale, vertices / scale
    near = nearest_neighbors(_features(queries, query_normals), _features(there, normals))
    return closest_points(there, faces, queries, near)


def rotated_normals(normals: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) after turns (n, 3, 3) of rows."""
    found = np.einsum("ni,nij->nj", normals, rotations)
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), np.finfo(float).tiny)


def _interpolate_deformation(
    rest: np.ndarray, carriers: np.ndarray, positions: np.ndarray, rotations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where points (n, 3) go that some of them (p,) carry, and how they turn there: means over the nearest carriers."""
    apart, near = cKDTree(rest[carriers]).query(rest, min(CARRIERS, len(carriers)))
    weights = np.maximum(1 - apart / (1.001 * apart[:, -1:] + np.finfo(float).tiny), 1e-3) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    arms = rest[:, None] - rest[carriers[near]]
    ends = positions[near] + np.einsum("nki,nkij->nkj", arms, rotations[near])
    return np.einsum("nk,nkd->nd", weights, ends), np.einsum("nk,nkij->nij", weights, rotations[near])


def _features(places: np.ndarray, normals: np.ndarray, *seen: np.ndarray) -> np.ndarray:
    return np.hstack([places, NORMAL * normals, *seen])
