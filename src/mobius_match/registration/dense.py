"""Dense registration: every vertex of the source on the target, and the map that this gives.

Beyond the paper. The deformed proxy carries the whole mesh, which is then deformed in the same way, from there
(:mod:`.deform`).
"""

from __future__ import annotations

import numpy as np
import scipy

from ..geometry.nearest_neighbors import nearest_neighbors, spatial_order
from ..geometry.normals import vertex_normals
from ..geometry.points import SurfacePoints, closest_points
from ..geometry.spectral import functional_map
from ..mesh.topology import edge_table, edges_of
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .deform import State, Target, deform
from .energy import DeformationGraph
from .features import rotated_normals
from .parameters import RegistrationParameters
from .sparse import Registration

CARRIERS = 6
"""Vertices of the proxy that carry a vertex of the mesh: its surroundings; four give the same maps."""


def dense_map(
    source: Surface,
    target: Surface,
    registration: Registration,
    parameters: RegistrationParameters,
    *,
    whole: bool = True,
) -> SurfaceMap:
    """The map of all the user's vertices, both ways, that a registration leads to.

    Parameters
    ----------
    source, target, registration
        The surfaces, and the source's proxy on the target.
    parameters
        The constants.
    whole
        Whether the source covers the target. If not, what lies beyond its boundary has no counterpart.
    """
    deformed, deformed_normals = register_vertices(source, target, registration, parameters, whole)
    mesh1, mesh2, scale = source.mesh, target.mesh, target.scale
    normals, weight = vertex_normals(mesh2.vertices / scale, mesh2.faces), parameters.dense_normal
    first = np.hstack([deformed / scale, weight * deformed_normals])
    second = np.hstack([mesh2.vertices / scale, weight * normals])
    target_points, source_points = _closest(first, second, mesh2.faces), _closest(second, first, mesh1.faces)
    source_mapped, target_mapped = np.ones(len(first), bool), np.ones(len(second), bool)
    if not whole:
        distance = np.linalg.norm(source_points.values(deformed) - mesh2.vertices, axis=1) / scale
        target_mapped = (distance <= parameters.part_distance) & ~_on_boundary(source_points, mesh1.faces)
    simple = SurfaceMap(mesh1, mesh2, target_points, source_points, source_mapped, target_mapped)
    return simple if source.detail is None and target.detail is None else _in_detail(source, target, simple)


def _in_detail(source: Surface, target: Surface, simple: SurfaceMap) -> SurfaceMap:
    """The map between the user's own meshes, by that of the simplified ones which stand for them."""
    sides = []
    for here, there, onward in ((source, target, simple), (target, source, simple.inverse)):
        if here.detail is None:
            points, found = onward.target_points, onward.source_mapped
        else:
            points, found = onward.map_points(here.detail.places(here.mesh))
        if there.detail is not None:
            heights = None
            if here.detail is not None and here.envelope and there.envelope:
                # Walls inside of an envelope are mapped to walls, not to the outside.
                heights = here.detail.heights(here.mesh) * (there.scale / here.scale)
            points = there.detail.lifted(there.mesh, points, heights)
        sides.append((points, found))
    (points, found), (back, back_found) = sides
    return SurfaceMap(source.whole_mesh, target.whole_mesh, points, back, found, back_found)


def _on_boundary(points: SurfacePoints, faces: np.ndarray) -> np.ndarray:
    """Which points (q,) bool lie on the boundary: what they stand for is beyond it."""
    table = edge_table(faces)
    boundary = np.zeros(faces.max() + 1, bool)
    boundary[table.edges[table.counts == 1]] = True
    return np.asarray((boundary[points.corners] | (points.barycentric < 1e-9)).all(axis=1))


def register_vertices(
    source: Surface, target: Surface, registration: Registration, parameters: RegistrationParameters, whole: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Deform all of the source to the target, from where its registered proxy carries it.

    Returns
    -------
    positions, normals
        (n1, 3) float64 each: of the source's vertices, in the target's coordinates.
    """
    scale1, scale2 = source.scale, target.scale
    rest, there = source.mesh.vertices / scale1, target.mesh.vertices / scale2
    normals1, normals2 = vertex_normals(rest, source.mesh.faces), vertex_normals(there, target.mesh.faces)
    positions, rotations = _carried(rest, source.proxy, registration.positions / scale2, registration.rotations)
    # Eigenfunctions keep a point from a limb that lies close by but belongs elsewhere, and from sliding along its own.
    # A part has other eigenfunctions than its whole, and other curvatures at its boundary.
    n_spectral = source.eigenfunctions.shape[1] if whole else 0
    spectral1, spectral2 = (one.eigenfunctions[:, :n_spectral].astype(np.float64) for one in (source, target))
    spectral1 = spectral1 @ functional_map(spectral1[source.proxy], spectral2[registration.image])
    appearance1, appearance2 = (
        np.hstack(
            [parameters.dense_spectral * spectral, *[parameters.dense_curvature * one.curvature_features] * whole]
        )
        for one, spectral in ((source, spectral1), (target, spectral2))
    )

    def query(state: State) -> np.ndarray:
        normals = _unit(rotated_normals(normals1, state.rotations))
        return np.hstack([state.positions, parameters.dense_normal * normals, appearance1])

    everything = np.arange(len(there))
    state = deform(
        DeformationGraph(rest, edges_of(source.mesh.faces)),
        State(positions, rotations, np.zeros(len(rest), np.int64), np.ones(len(rest), bool)),
        query,
        Target(
            there,
            np.hstack([there, parameters.dense_normal * normals2, appearance2]),
            everything if whole else everything[:0],
        ),
        parameters.full,
        order=spatial_order(rest),
    )
    return state.positions * scale2, _unit(rotated_normals(normals1, state.rotations))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)


def _closest(queries: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> SurfacePoints:
    """The points of a mesh closest to queries, from positions and weighted normals (q, 6) and (n, 6)."""
    near = nearest_neighbors(queries, vertices)
    return closest_points(vertices[:, :3], faces, queries[:, :3], near)


def _carried(
    rest: np.ndarray, carriers: np.ndarray, positions: np.ndarray, rotations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) and rotations (n, 3, 3) of all points, from those of some of them (p,): means of the nearest."""
    distance, near = scipy.spatial.cKDTree(rest[carriers]).query(rest, min(CARRIERS, len(carriers)))
    weights = np.maximum(1 - distance / (1.001 * distance[:, -1:] + np.finfo(float).tiny), 1e-3) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    arms = rest[:, None] - rest[carriers[near]]
    ends = positions[near] + np.einsum("nki,nkij->nkj", arms, rotations[near])
    return np.einsum("nk,nkd->nd", weights, ends), np.einsum("nk,nkij->nij", weights, rotations[near])
