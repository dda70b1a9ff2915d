"""Section 4, point samples: maxima of Gauss curvature, then farthest points.

Beyond the paper: the curvature is smoothed by small implicit heat steps to a fixed fraction of the surface, and a
maximum must be one over a geodesic disc of fixed size, so that two triangulations of a shape give the same points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core.display import one_line
from ..geometry.curvature import gauss_curvature
from ..geometry.farthest_points import farthest_points
from ..geometry.geodesics import DistanceFunction
from ..geometry.laplacian import IntrinsicMesh
from .parameters import SurfaceParameters


@dataclass(frozen=True, eq=False)
class Samples:
    """Sample points of one surface.

    Parameters
    ----------
    vertices
        Vertex numbers (N,) int64, maxima of curvature first.
    n_maxima
        How many of them are maxima.
    distances
        Geodesic distances (N, n) float64 from each sample to every vertex, in the units of the mesh.
    """

    vertices: np.ndarray
    n_maxima: int
    distances: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def covering_radius(self) -> float:
        """Largest distance of a vertex from the samples, in the units of the mesh."""
        return float(self.distances.min(axis=0).max())


def sample_points(
    mesh: IntrinsicMesh, distances_from: DistanceFunction, count: int, parameters: SurfaceParameters
) -> Samples:
    """N sample points: all maxima of smoothed curvature, then the farthest point from those there are.

    Parameters
    ----------
    mesh
        The triangulation that curvature is measured on.
    distances_from
        Geodesic distances from a vertex to all, as :func:`geodesic_solver` gives.
    count
        Number of samples N; a mesh with fewer vertices gives all its vertices.
    parameters
        The constants.
    """
    count = min(count, mesh.n_vertices)
    radius = parameters.maximum_radius * np.sqrt(mesh.areas.sum())
    curvature = gauss_curvature(mesh, parameters.sampling_smoothing)
    chosen: list[int] = []
    rows: list[np.ndarray] = []
    for vertex in _ring_maxima(mesh, curvature):
        if len(chosen) >= count // 2:  # a noisy surface must leave room for the even spread
            break
        row = distances_from(int(vertex))
        if curvature[vertex] >= curvature[row < radius].max():
            chosen.append(int(vertex))
            rows.append(row)
    n_maxima = len(chosen)
    if not chosen:  # a perfectly even surface has no maximum
        chosen.append(int(np.argmax(distances_from(0))))
        rows.append(distances_from(chosen[0]))
    nearest = np.minimum.reduce(rows)
    nearest[chosen] = -np.inf
    for vertex, row in farthest_points(distances_from, nearest, count - len(chosen)):
        chosen.append(vertex)
        rows.append(row)
    return Samples(np.array(chosen, np.int64), n_maxima, np.array(rows))


def straightness(points: np.ndarray, samples: Samples) -> float:
    """The least ratio of a distance between two samples to the straight line between them, points (N, 3).

    It is at least 1 for exact distances.
    """
    one, two = np.triu_indices(len(points), 1)
    straight = np.linalg.norm(points[one] - points[two], axis=1)
    apart = straight > 0
    found = samples.distances[:, samples.vertices]
    return float(((found + found.T)[one, two][apart] / (2 * straight[apart])).min(initial=np.inf))


def proxy_points(areas: np.ndarray, count: int, samples: np.ndarray) -> np.ndarray:
    """At most ``count`` vertices (p,) int64, ascending: the samples, and others drawn as likely as their areas.

    Parameters
    ----------
    areas
        (n,) area of each vertex.
    count
        How many are wanted; all samples are among them in any case.
    samples
        (N,) vertex numbers.
    """
    others = np.setdiff1d(np.arange(len(areas)), samples)
    wanted = max(count - len(samples), 0)
    if len(others) > wanted:
        shares = areas[others] / areas[others].sum()
        others = np.random.default_rng(0).choice(others, wanted, replace=False, p=shares)
    return np.sort(np.concatenate([samples, others])).astype(np.int64)


def thin_out(ways: np.ndarray, spacing: float, always: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Those of points (k,), in their order, that are no closer than the spacing to any before them.

    Some of them, (k,) bool, are kept always, and the others keep away from these. The ways (q, q) between all points
    are known.
    """
    kept, free = always.copy(), (ways[order[always]] >= spacing).all(axis=0)
    for place in np.flatnonzero(~always):
        if free[order[place]]:
            kept[place] = True
            free &= ways[order[place]] >= spacing
    return order[kept]


def _ring_maxima(mesh: IntrinsicMesh, values: np.ndarray) -> np.ndarray:
    """Vertices whose positive value none of their neighbours exceeds, largest first."""
    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    largest = np.full(mesh.n_vertices, -np.inf)
    np.maximum.at(largest, start, values[end])
    np.maximum.at(largest, end, values[start])
    maxima = np.flatnonzero((values >= largest) & (values > 0))
    return maxima[np.argsort(-values[maxima], kind="stable")]
