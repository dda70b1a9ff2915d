"""Interpolation between two shapes in the source's triangulation, so that limbs rotate instead of shrinking.

Each vertex has the rotation of its neighbourhood between the two shapes, the polar factor of the edges' covariance. At
a time between, each edge is rotated by that fraction of the rotation and stretched by that fraction of the rest, and
one Poisson equation on the edge graph reconstructs the vertices (after Alexa, Cohen-Or and Levin 2000, who do this with
triangles). At both ends the edges are those of the two shapes, so both ends are exact.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial.transform import Rotation

from ..errors import MeshError, SettingsError
from ..geometry.cholesky import factorized
from ..geometry.geodesics import bridges
from ..geometry.rotations import nearest_rotations
from ..mesh.measure import cross_products
from ..mesh.topology import edges_of
from ..results.reflected import with_mirrored_source
from ..results.surface_map import SurfaceMap

SMOOTHING = 3
"""Rounds of averaging rotation vectors over neighbours: a dense map is rough at the scale of an edge."""

FIXED, FREE = 1e6, 1e-9
"""Weights against the graph Laplacian, of the displacements of vertices with a counterpart and without."""


def morph(surface_map: SurfaceMap, times: Iterable[float]) -> np.ndarray:
    """Shapes between the source and the target.

    Parameters
    ----------
    surface_map
        The map; its ``source.faces`` are the faces of all the shapes. The shapes of a map that is reflected begin with
        the mirror image of the source, at the plane through its centre, since a shape can only be flattened to become
        its mirror image; their faces are ``source.reflected().faces``.
    times
        T times from 0, the source, to 1, the source's triangulation on the target.

    Returns
    -------
    numpy.ndarray
        (T, n1, 3) positions of the vertices of ``surface_map.source``, in the units of the files. Vertices without a
        counterpart follow their neighbours.

    Raises
    ------
    SettingsError
        If a time is not a number from 0 to 1.
    MeshError
        If no vertex has a counterpart.
    """
    times = np.array([float(time) for time in times])
    if not ((times >= 0) & (times <= 1)).all():
        raise SettingsError("`times` has a time outside 0 to 1; 0 is the source, 1 the target")
    surface_map = oriented(surface_map)
    mesh = surface_map.source
    return interpolate(mesh.vertices, positions_on_target(surface_map), mesh.faces, times)


def oriented(surface_map: SurfaceMap) -> SurfaceMap:
    """A map that keeps the orientation: the map itself, or that of the mirror image of its source, in the same box."""
    if not surface_map.reflected:
        return surface_map
    mirrored, x = with_mirrored_source(surface_map), surface_map.source.vertices[:, 0]
    vertices = mirrored.source.vertices + np.array([x.min() + x.max(), 0.0, 0.0])
    return replace(mirrored, source=replace(mirrored.source, vertices=vertices))


def positions_on_target(surface_map: SurfaceMap) -> np.ndarray:
    """Positions (n1, 3) of the source's vertices on the target; displacements are extended smoothly to those without.

    Raises
    ------
    MeshError
        If no vertex has a counterpart.
    """
    mesh, mapped = surface_map.source, surface_map.source_mapped
    if not mapped.any():
        raise MeshError(f"{mesh.name}: no vertex has a counterpart on {surface_map.target.name}")
    positions = surface_map.positions
    if not mapped.all():
        displacements = np.where(mapped[:, None], positions - mesh.vertices, 0.0)
        # The small weight makes the matrix definite where a whole component has no counterpart.
        weights = np.where(mapped, FIXED, FREE)
        laplacian, _ = _graph_operators(edges_of(mesh.faces), len(mapped))
        displacements = factorized(laplacian + sp.diags(weights)).solve(weights[:, None] * displacements)
        positions[~mapped] = (mesh.vertices + displacements)[~mapped]
    return positions


def interpolate(start: np.ndarray, end: np.ndarray, faces: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Shapes between two that share their faces.

    Parameters
    ----------
    start, end
        (n, 3) positions at time 0 and at time 1.
    faces
        (m, 3) vertex numbers.
    times
        (T,) from 0 to 1.

    Returns
    -------
    numpy.ndarray
        (T, n, 3). The rigid motion between the two is separated: it is one rotation at constant speed, and the centre
        of mass moves along a straight line.
    """
    edges = edges_of(faces)
    edges = np.concatenate([edges, bridges(start, edges, every=True)])  # pieces move with what they lie next to
    weights = np.bincount(faces.ravel(), np.repeat(np.linalg.norm(cross_products(start, faces), axis=1), 3), len(start))
    weights = weights / weights.sum()
    start_centre, end_centre = weights @ start, weights @ end
    covariance = (start - start_centre).T @ (weights[:, None] * (end - end_centre))
    rigid = nearest_rotations(covariance[None])[0]  # of row vectors, as all matrices here
    rest, aligned = start - start_centre, (end - end_centre) @ rigid.T
    first, second = edges.T
    edges_start, edges_end = rest[second] - rest[first], aligned[second] - aligned[first]
    laplacian, divergence = _graph_operators(edges, len(start))
    vectors, remainders = rotation_vectors(edges_start, edges_end, edges, len(start))
    inverse = (Rotation.from_rotvec(vectors) * Rotation.from_rotvec(remainders)).inv()
    unrotated = [inverse[vertices].apply(edges_end) for vertices in (first, second)]
    # The constant of each component is fixed here, and the common one by the centre of mass below.
    solve = factorized(laplacian + sp.diags(1e-10 * (1 + laplacian.diagonal()))).solve
    rigid_vector = Rotation.from_matrix(rigid.T).as_rotvec()
    shapes = np.empty((len(times), len(start), 3))
    for shape, time in zip(shapes, times, strict=True):
        rotations = Rotation.from_rotvec(time * vectors) * Rotation.from_rotvec(time * remainders)
        rotated = [
            rotations[vertices].apply((1 - time) * edges_start + time * edges_unrotated)
            for vertices, edges_unrotated in zip((first, second), unrotated, strict=True)
        ]
        positions = (1 - time) * rest + time * aligned  # the solver adds the correction, which is small
        correction = (rotated[0] + rotated[1]) / 2 - (positions[second] - positions[first])
        positions = positions + solve(divergence @ correction)
        positions -= weights @ positions
        centre = (1 - time) * start_centre + time * end_centre
        shape[:] = Rotation.from_rotvec(time * rigid_vector).apply(positions) + centre
    shapes[times == 0], shapes[times == 1] = start, end
    return shapes


def rotation_vectors(
    edges_start: np.ndarray, edges_end: np.ndarray, edges: np.ndarray, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """The rotation of each vertex's neighbourhood between two shapes, smooth over the surface.

    Parameters
    ----------
    edges_start, edges_end
        (E, 3) edge vectors in both shapes.
    edges
        (E, 2) their vertices.
    size
        Number of vertices.

    Returns
    -------
    vectors, remainders
        (size, 3) each, rotation vectors in radians: the rotation is the small one of ``remainders``, then that of
        ``vectors``.

    Notes
    -----
    A rotation does not tell its number of full turns, of which a coil has several. So the vectors are propagated along
    a minimum spanning tree of the edges, weighted by the angle between the rotations at both ends, from the vertex
    that rotates least: of all vectors of a rotation each vertex takes the one nearest to its predecessor's. Close to a
    full turn none may be near; the remainder corrects that.
    """
    adjacency = _adjacency(edges, size)
    products = (edges_start[:, :, None] * edges_end[:, None, :]).reshape(-1, 9)
    covariances = _edge_sums(edges, size, 1.0) @ products
    # The edges of a single vertex may be flat or folded, so those of its neighbours are added.
    matrices = nearest_rotations((covariances + adjacency @ covariances).reshape(-1, 3, 3))
    rotations = Rotation.from_matrix(matrices.transpose(0, 2, 1))
    first, second = edges.T
    angles = (rotations[first].inv() * rotations[second]).magnitude()
    tree = minimum_spanning_tree(sp.csr_matrix((angles + 1e-3, (first, second)), shape=(size, size)))
    root = int(np.argmin(rotations.magnitude()))
    mean = sp.diags(0.5 / np.maximum(adjacency.sum(axis=1).A1, 1)) @ adjacency
    vectors = _propagated_vectors(rotations, *breadth_first_order(tree, root, directed=False))
    for _ in range(SMOOTHING):
        vectors = vectors / 2 + mean @ vectors
    remainders = (Rotation.from_rotvec(-vectors) * rotations).as_rotvec()
    for _ in range(SMOOTHING):
        remainders = remainders / 2 + mean @ remainders
    return vectors, remainders


def _propagated_vectors(rotations: Rotation, order: np.ndarray, predecessors: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3), each with the number of full turns that brings it nearest to its predecessor's."""
    quaternions, vectors = rotations.as_quat().tolist(), rotations.as_rotvec().tolist()
    for i, predecessor in zip(order[1:].tolist(), predecessors[order[1:]].tolist(), strict=True):
        u, v, w = vectors[predecessor]
        length = (u * u + v * v + w * w) ** 0.5
        x, y, z, real = quaternions[i]
        if length <= np.pi:  # about the rotation's own axis
            u, v, w = vectors[i]
            length = (u * u + v * v + w * w) ** 0.5
            if not length:
                continue
            before = vectors[predecessor]
            expected = (before[0] * u + before[1] * v + before[2] * w) / length
        else:  # towards a full turn its own axis becomes uncertain, so the predecessor's is kept
            expected = length
        u, v, w = u / length, v / length, w / length
        angle = 2 * np.arctan2(x * u + y * v + z * w, real)
        angle += 2 * np.pi * np.round((expected - angle) / (2 * np.pi))
        vectors[i] = [angle * u, angle * v, angle * w]
    return np.array(vectors).reshape(-1, 3)


def _edge_sums(edges: np.ndarray, size: int, first: float) -> sp.csr_matrix:
    """Matrix (size, E) that sums over the edges at each vertex, with weight `first` where it is the first vertex."""
    number = np.arange(len(edges))
    values = np.repeat([first, 1.0], len(edges))
    return sp.csr_matrix((values, (edges.T.ravel(), np.tile(number, 2))), shape=(size, len(edges)))


def _adjacency(edges: np.ndarray, size: int) -> sp.csr_matrix:
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    return sp.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(size, size))


def _graph_operators(edges: np.ndarray, size: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Laplacian (size, size) and divergence (size, E) of the edge graph, with weight 1 for each edge."""
    divergence = _edge_sums(edges, size, -1.0)
    return divergence @ divergence.T, divergence
