"""One shape becoming another in the source's triangulation, limbs turning as wholes.

Each vertex has the rotation of its surroundings between the two shapes (polar decomposition). At a moment between,
every edge is turned by the same part of that rotation, stretched by the same part of its change, and one Poisson
equation puts the edges together (as Alexa, Cohen-Or and Levin do with triangles, 2000). With all of the rotation the
edges are those of the target, so both ends are exact.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial.transform import Rotation

from ..errors import MeshError, SettingsError
from ..geometry.cholesky import factorized
from ..mesh.measure import cross_products
from ..mesh.topology import edges_of
from ..results.surface_map import SurfaceMap

SMOOTHING = 3
"""How often the rotation vectors are averaged over neighbours: a dense map is rough at the scale of an edge."""


def morph(surface_map: SurfaceMap, times: Iterable[float]) -> np.ndarray:
    """Shapes between the source and the target.

    Parameters
    ----------
    surface_map
        The map; its ``source.faces`` are the faces of all the shapes.
    times
        T moments: 0 is the source, 1 the source's triangulation on the target.

    Returns
    -------
    numpy.ndarray
        (T, n1, 3) positions of the vertices of ``surface_map.source``, in the units of the files. Vertices without a
        counterpart follow those around them.

    Raises
    ------
    SettingsError
        If a time is no number from 0 to 1.
    MeshError
        If no vertex has a counterpart.
    """
    moments = np.array([float(time) for time in times])
    if not ((moments >= 0) & (moments <= 1)).all():
        raise SettingsError("a time of the morph is outside 0 to 1; 0 is the source, 1 the target")
    mesh = surface_map.source
    return interpolate(mesh.vertices, ends(surface_map), mesh.faces, moments)


def ends(surface_map: SurfaceMap) -> np.ndarray:
    """The source's vertices on the target (n1, 3); those without counterpart are moved as smoothly as can be."""
    mesh, found = surface_map.source, surface_map.source_mapped
    if not found.any():
        raise MeshError(f"{mesh.name}: no vertex has a counterpart on {surface_map.target.name}")
    places = surface_map.positions
    if not found.all():
        moved = np.where(found[:, None], places - mesh.vertices, 0.0)
        # Where a piece has no counterpart at all, next to nothing keeps it in place.
        firm = np.where(found, 1e6, 1e-9)
        laplacian, _ = _graph(edges_of(mesh.faces), len(found))
        moved = factorized(laplacian + sp.diags(firm)).solve(firm[:, None] * moved)
        places[~found] = (mesh.vertices + moved)[~found]
    return places


def interpolate(start: np.ndarray, end: np.ndarray, faces: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Shapes (T, n, 3) between two (n, 3) that share faces (m, 3); the first at time 0, the second at time 1."""
    edges = edges_of(faces)
    weights = np.bincount(faces.ravel(), np.repeat(np.linalg.norm(cross_products(start, faces), axis=1), 3), len(start))
    weights = weights / weights.sum()
    centre1, centre2 = weights @ start, weights @ end
    whole = _turn((start - centre1).T @ (weights[:, None] * (end - centre2)))
    rest, goal = start - centre1, (end - centre2) @ whole.T  # the target as it is turned like the source
    first, second = edges.T
    before, after = rest[second] - rest[first], goal[second] - goal[first]
    laplacian, divergence = _graph(edges, len(start))
    vectors, rests = rotation_vectors(before, after, edges, len(start))
    back = (Rotation.from_rotvec(vectors) * Rotation.from_rotvec(rests)).inv()
    unturned = [back[ends].apply(after) for ends in (first, second)]
    # Constants are fixed by the centre below; every piece of the surface needs one.
    solve = factorized(laplacian + sp.diags(1e-10 * (1 + laplacian.diagonal()))).solve
    whole_vector = Rotation.from_matrix(whole.T).as_rotvec()  # the matrices here turn rows
    shapes = np.empty((len(times), len(start), 3))
    for shape, time in zip(shapes, times, strict=True):
        turns = Rotation.from_rotvec(time * vectors) * Rotation.from_rotvec(time * rests)
        middle = [
            turns[ends].apply((1 - time) * before + time * there)
            for ends, there in zip((first, second), unturned, strict=True)
        ]
        found = (1 - time) * rest + time * goal  # a start that is nearly right leaves the solver little to do
        wanted = (middle[0] + middle[1]) / 2 - (found[second] - found[first])
        found = found + solve(divergence @ wanted)
        found -= weights @ found
        shape[:] = Rotation.from_rotvec(time * whole_vector).apply(found) + (1 - time) * centre1 + time * centre2
    shapes[times == 0], shapes[times == 1] = start, end
    return shapes


def rotation_vectors(
    before: np.ndarray, after: np.ndarray, edges: np.ndarray, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """How the surroundings of each vertex turn, neighbours by about as much.

    Parameters
    ----------
    before, after
        (E, 3) the edges in both shapes.
    edges
        (E, 2) their vertices.
    size
        How many vertices there are.

    Returns
    -------
    vectors, rests
        (size, 3) each, radians along the axis: the rotation is that of the rest, which is small, then of the vector.

    Notes
    -----
    A rotation says nothing of whole turns, of which a coil has several. So the vectors are found one after the other
    from one vertex on, along a tree of edges whose ends turn as alike as can be; of all vectors of a rotation each
    takes the one nearest to its predecessor's. Close to a whole turn none may be near; the rest makes up for it.
    """
    around = _adjacency(edges, size)
    products = (before[:, :, None] * after[:, None, :]).reshape(-1, 9)
    gathered = _incidence(edges, size, 1.0) @ products
    # The surroundings of a single vertex of a surface may be flat or folded: those of its neighbours count as well.
    matrices = _turns((gathered + around @ gathered).reshape(-1, 3, 3))
    rotations = Rotation.from_matrix(matrices.transpose(0, 2, 1))
    first, second = edges.T
    apart = (rotations[first].inv() * rotations[second]).magnitude()
    tree = minimum_spanning_tree(sp.csr_matrix((apart + 1e-3, (first, second)), shape=(size, size)))
    root = int(np.argmin(rotations.magnitude()))
    mean = sp.diags(0.5 / np.maximum(around.sum(axis=1).A1, 1)) @ around
    vectors = _branches(rotations, *breadth_first_order(tree, root, directed=False))
    for _ in range(SMOOTHING):
        vectors = vectors / 2 + mean @ vectors
    rests = (Rotation.from_rotvec(-vectors) * rotations).as_rotvec()
    for _ in range(SMOOTHING):
        rests = rests / 2 + mean @ rests
    return vectors, rests


def _branches(rotations: Rotation, order: np.ndarray, predecessors: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3), each with as many whole turns as bring it nearest to its predecessor's."""
    quaternions, found = rotations.as_quat().tolist(), rotations.as_rotvec().tolist()
    for i, before in zip(order[1:].tolist(), predecessors[order[1:]].tolist(), strict=True):
        u, v, w = found[before]
        length = (u * u + v * v + w * w) ** 0.5
        x, y, z, real = quaternions[i]
        if length <= np.pi:  # the rotation's own axis
            u, v, w = found[i]
            length = (u * u + v * v + w * w) ** 0.5
            if not length:
                continue
            wanted = (found[before][0] * u + found[before][1] * v + found[before][2] * w) / length
        else:  # towards a whole turn the axis becomes uncertain: it stays
            wanted = length
        u, v, w = u / length, v / length, w / length
        angle = 2 * np.arctan2(x * u + y * v + z * w, real)
        angle += 2 * np.pi * np.round((wanted - angle) / (2 * np.pi))
        found[i] = [angle * u, angle * v, angle * w]
    return np.array(found).reshape(-1, 3)


def _turns(products: np.ndarray) -> np.ndarray:
    """The rotations (n, 3, 3) of rows that are nearest to matrices (n, 3, 3)."""
    left, _, right = np.linalg.svd(products)
    left[np.linalg.det(left @ right) < 0, :, 2] *= -1
    return left @ right


def _turn(product: np.ndarray) -> np.ndarray:
    return np.asarray(_turns(product[None])[0])


def _incidence(edges: np.ndarray, size: int, first: float) -> sp.csr_matrix:
    """Sums (size, E) over the edges at each vertex; those that begin there count `first`, those that end there 1."""
    number = np.arange(len(edges))
    values = np.repeat([first, 1.0], len(edges))
    return sp.csr_matrix((values, (edges.T.ravel(), np.tile(number, 2))), shape=(size, len(edges)))


def _adjacency(edges: np.ndarray, size: int) -> sp.csr_matrix:
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    return sp.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(size, size))


def _graph(edges: np.ndarray, size: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Laplacian (size, size) and divergence (size, E) of the graph."""
    divergence = _incidence(edges, size, -1.0)
    return divergence @ divergence.T, divergence
