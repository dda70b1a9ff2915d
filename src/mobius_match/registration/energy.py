"""The as-rigid-as-possible energy of a graph of points, and its local/global solver (Sorkine and Alexa 2007)."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, dijkstra

from .._core.compiling import jit
from ..geometry.cholesky import Pattern
from ..geometry.rotations import nearest_rotations
from ..surface.surface import Surface

TEAR = 0.07
"""How much longer than the edge its image is, per sqrt(area), where the map is torn."""


class DeformationGraph:
    """A graph of points (p, 3) with edges (E, 2), of which each neighbourhood would rather turn than change."""

    def __init__(self, rest: np.ndarray, edges: np.ndarray) -> None:
        size = len(rest)
        start, end = np.concatenate([edges, edges[:, ::-1]]).T
        order = np.argsort(start, kind="stable")
        self._start, self._end = start[order], end[order]
        self._starts = np.searchsorted(self._start, np.arange(size + 1))
        self._rest = rest[self._start] - rest[self._end]
        self._lengths = np.linalg.norm(self._rest, axis=1)
        everyone, degrees = np.arange(size), np.diff(self._starts).astype(float)
        entries = np.concatenate([-np.ones(len(start)), degrees])
        rows, columns = np.concatenate([self._start, everyone]), np.concatenate([self._end, everyone])
        self._laplacian = sp.csr_matrix((entries, (rows, columns)), shape=(size, size))
        self._pattern = Pattern(self._laplacian, np.ones(size))

    def continuous(self, images: np.ndarray) -> np.ndarray:
        """Which points (p,) bool images (p, 3) leave whole: the largest piece, and those that lie beside it as before.

        A piece that is only cut off by a few wrong points stays; one that was sent elsewhere does not.
        """
        size = len(images)
        kept = np.linalg.norm(images[self._start] - images[self._end], axis=1) < self._lengths + TEAR
        starts = np.concatenate([[0], np.cumsum(kept)])[self._starts]
        graph = sp.csr_matrix((self._lengths[kept], self._end[kept], starts), shape=(size, size))
        number, pieces = connected_components(graph, directed=False)
        found = pieces == np.bincount(pieces).argmax()
        if number == 1:
            return np.asarray(found)
        paths = sp.csr_matrix((self._lengths, self._end, self._starts), shape=(size, size))
        apart, _, beside = dijkstra(paths, indices=np.flatnonzero(found), min_only=True, return_predecessors=True)
        drift = np.linalg.norm(images - images[beside], axis=1) - apart
        nearest = np.lexsort((apart, pieces))
        first = nearest[np.searchsorted(pieces[nearest], np.arange(number))]
        return np.asarray(drift[first] < TEAR)[pieces]

    def solve(
        self, positions: np.ndarray, places: np.ndarray, data_weight: np.ndarray, steps: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions (p, 3) between rigidity and places, which count as trust (p,) says, and the turns (p, 3, 3).

        Turning and moving take turns.
        """
        factors = self._pattern.factors(self._laplacian.data, data_weight)
        for _ in range(steps):
            rotations = nearest_rotations(covariances(self._starts, self._end, self._rest, positions))
            wanted = rotated_edge_sums(self._starts, self._end, self._rest, rotations)
            positions = factors.solve(wanted + data_weight[:, None] * places)
        return positions, rotations


_graphs: WeakKeyDictionary[Surface, DeformationGraph] = WeakKeyDictionary()


def deformation_graph(source: Surface) -> DeformationGraph:
    """The source's proxy, which is bent along several explanations."""
    found = _graphs.get(source)
    if found is None:
        found = _graphs[source] = DeformationGraph(
            source.mesh.vertices[source.proxy] / np.sqrt(source.area), source.proxy_edges
        )
    return found


@jit
def covariances(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Sums (p, 3, 3) over each point's neighbours of rest vectors times what they are between positions (p, 3)."""
    found = np.zeros((len(positions), 3, 3))
    for i in range(len(positions)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                moved = positions[i, axis] - positions[ends[edge], axis]
                for row in range(3):
                    found[i, row, axis] += rest[edge, row] * moved
    return found


@jit
def rotated_edge_sums(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Sums (p, 3) over each point's neighbours of rest vectors, turned by the mean of the turns (p, 3, 3) of both."""
    found = np.zeros((len(rotations), 3))
    for i in range(len(rotations)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                for row in range(3):
                    turn = rotations[i, row, axis] + rotations[ends[edge], row, axis]
                    found[i, axis] += 0.5 * rest[edge, row] * turn
    return found
