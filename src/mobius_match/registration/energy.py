"""The energy that registration minimises, and its local/global solver (Sorkine and Alexa 2007).

For points p_i of the source at rest, their images x_i, a rotation R_i around each, and targets y_i of weight w_i:

    E(x, R) = 1/2 sum_i sum_{j in N(i)} |(x_i - x_j) - R_i (p_i - p_j)|^2 + sum_i w_i |x_i - y_i|^2

The local step finds the rotations for given positions (a polar decomposition at each point), the global step the
positions for given rotations (one sparse linear system, whose matrix the rotations do not change). Rotations multiply
rows of coordinates from the right.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, dijkstra

from .._core.compiling import jit
from ..geometry.cholesky import Pattern
from ..geometry.rotations import nearest_rotations
from ..surface.surface import Surface


class DeformationGraph:
    """Points p (p, 3) at rest, per sqrt(area), and edges (E, 2) between neighbours, all of weight 1."""

    def __init__(self, rest: np.ndarray, edges: np.ndarray) -> None:
        size = len(rest)
        start, end = np.concatenate([edges, edges[:, ::-1]]).T
        order = np.argsort(start, kind="stable")
        self._start, self._end = start[order], end[order]
        self._first_edge = np.searchsorted(self._start, np.arange(size + 1))
        self._rest = rest[self._start] - rest[self._end]
        self._lengths = np.linalg.norm(self._rest, axis=1)
        points, degrees = np.arange(size), np.diff(self._first_edge).astype(float)
        entries = np.concatenate([-np.ones(len(start)), degrees])
        rows, columns = np.concatenate([self._start, points]), np.concatenate([self._end, points])
        self._laplacian = sp.csr_matrix((entries, (rows, columns)), shape=(size, size))
        self._pattern = Pattern(self._laplacian, np.ones(size))

    def continuous(self, images: np.ndarray, tolerance: float) -> np.ndarray:
        """Which points (p,) bool belong to the part of the surface that a map to images (p, 3) keeps together.

        Edges whose images are longer by more than the tolerance are cut. The largest piece is kept, and each piece
        whose images lie beside it as they did before: a few wrong points cut it off. A piece that was sent elsewhere is
        discontinuous.
        """
        size = len(images)
        kept = np.linalg.norm(images[self._start] - images[self._end], axis=1) < self._lengths + tolerance
        first_kept = np.concatenate([[0], np.cumsum(kept)])[self._first_edge]
        graph = sp.csr_matrix((self._lengths[kept], self._end[kept], first_kept), shape=(size, size))
        number, pieces = connected_components(graph, directed=False)
        largest = pieces == np.bincount(pieces).argmax()
        if number == 1:
            return np.asarray(largest)
        paths = sp.csr_matrix((self._lengths, self._end, self._first_edge), shape=(size, size))
        distance, _, nearest = dijkstra(paths, indices=np.flatnonzero(largest), min_only=True, return_predecessors=True)
        drift = np.linalg.norm(images - images[nearest], axis=1) - distance
        # Of each piece its point closest to the largest piece decides.
        order = np.lexsort((distance, pieces))
        closest = order[np.searchsorted(pieces[order], np.arange(number))]
        return np.asarray(drift[closest] < tolerance)[pieces]

    def solve(
        self, positions: np.ndarray, targets: np.ndarray, weights: np.ndarray, steps: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Minimise the energy from given positions (p, 3), for targets (p, 3) of weights (p,).

        Returns
        -------
        positions
            (p, 3) after so many alternations of the local and the global step.
        rotations
            (p, 3, 3) of the last local step.
        """
        factors = self._pattern.factors(self._laplacian.data, weights)
        for _ in range(steps):
            rotations = nearest_rotations(covariances(self._first_edge, self._end, self._rest, positions))
            rigid = rotated_edge_sums(self._first_edge, self._end, self._rest, rotations)
            positions = factors.solve(rigid + weights[:, None] * targets)
        return positions, rotations


_graphs: WeakKeyDictionary[Surface, DeformationGraph] = WeakKeyDictionary()


def deformation_graph(source: Surface) -> DeformationGraph:
    """The graph of the source's proxy; kept, since a source is deformed along several alignments."""
    graph = _graphs.get(source)
    if graph is None:
        rest = source.mesh.vertices[source.proxy] / source.scale
        graph = _graphs[source] = DeformationGraph(rest, source.proxy_edges)
    return graph


@jit
def covariances(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Sums (p, 3, 3) over each point's neighbours of (p_i - p_j)^T (x_i - x_j), for positions x (p, 3).

    The neighbours of point i are ``ends[starts[i] : starts[i + 1]]``; ``rest`` are the vectors p_i - p_j.
    """
    sums = np.zeros((len(positions), 3, 3))
    for i in range(len(positions)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                moved = positions[i, axis] - positions[ends[edge], axis]
                for row in range(3):
                    sums[i, row, axis] += rest[edge, row] * moved
    return sums


@jit
def rotated_edge_sums(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Sums (p, 3) over each point's neighbours of (p_i - p_j) (R_i + R_j) / 2, for rotations R (p, 3, 3)."""
    sums = np.zeros((len(rotations), 3))
    for i in range(len(rotations)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                for row in range(3):
                    both = rotations[i, row, axis] + rotations[ends[edge], row, axis]
                    sums[i, axis] += 0.5 * rest[edge, row] * both
    return sums
