"""A mesh made ready for matching: sections 4 and 5 and the descriptors, computed once and shared between pairs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse.csgraph import dijkstra
from threadpoolctl import threadpool_limits

from .detail import Detail, simplified
from .errors import MeshError
from .flattening import choose_cut_face, flatten, vertex_positions
from .geometry.curvature import gauss_curvature, mean_curvature
from .geometry.geodesics import geodesic_solver, graph_of, heat_solver, nearest_centres
from .geometry.laplacian import intrinsic_mesh
from .geometry.spectral import eigenbasis, wave_kernel_signature
from .mesh import Mesh, as_mesh, repair, require_matchable
from .sampling import proxy_points, sample_points
from .settings import PrepareSettings
from .storage import load_fields, save_surface

Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, how much of it is done, and how much there is."""

EIGENFUNCTIONS = 50
PROXY_SIZE = 1200
RADIUS, WIDE_RADIUS = 0.035, 0.1
"""Widths that curvatures are smoothed to, per sqrt(area)."""

RELIEF, FLAT = 2.0, 1.0
"""What curvatures, in standard deviations, are multiplied by before asinh presses the great ones together, and the
standard deviation that they are taken to have at least: a sphere has none."""

NEARBY = 0.2
"""Length per sqrt(area) up to which ways between the proxy's vertices are known: the greatest spacing of matches."""

LEVELS = slice(4, None, 8)
"""Levels of the 100 of the wave kernel signature that all vertices are described by."""

LEAST_SPREAD = 0.1
"""Standard deviation that the logarithms of a level are taken to have at least: a sphere has none."""

LARGEST_CLOSURE = 1e-6
"""Closure of the conjugate function above which a flattening is not to be trusted."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A prepared mesh: plain arrays, no solver.

    Parameters
    ----------
    mesh
        The repaired mesh, or a simplified one where that is large; all vertex numbers below are its own.
    detail
        The repaired mesh and how the simplified one lies on it; None where nothing was simplified.
    settings
        What it was prepared with.
    samples
        (N,) int64 vertex numbers of the sample points in ``mesh`` (section 4), maxima of curvature first.
    n_maxima
        How many of the samples are maxima of curvature.
    distances
        (N, N) float64 geodesic distances between the samples, symmetric, in the units of the mesh.
    cells
        (N,) float64 areas of the samples' cells, in squared units of the mesh.
    positions
        (N,) complex128 positions in the plane (section 5).
    signatures
        (N, 100) float64 wave kernel signatures of the samples.
    eigenvalues, eigenfunctions
        (k,) float64 and (n, k) float32: of the Laplacian, for a surface of area 1.
    proxy
        (P,) int64 vertices that stand for the whole surface where detail is not needed, ascending: the samples, and
        others drawn evenly by area.
    proxy_edges
        (E, 2) int64 places in ``proxy`` of vertices whose cells touch.
    proxy_distances
        (N, P) float32 geodesic distances from the samples to the proxy's vertices, in the units of the mesh.
    curvatures
        (3, n) float32 Gauss curvature, mean curvature, and mean curvature smoothed more widely, free of scale.
    cut_vertex
        Vertex of least average geodesic distance, at which the flattening is cut.
    closure
        Closure error of the conjugate function, as a fraction of the flattening's extent.
    area, diameter
        Area and (estimated) geodesic diameter, in units of the mesh.
    timings
        Seconds that each stage took.
    warnings
        What a user should know.
    """

    mesh: Mesh
    detail: Detail | None
    settings: PrepareSettings
    samples: np.ndarray
    n_maxima: int
    distances: np.ndarray
    cells: np.ndarray
    positions: np.ndarray
    signatures: np.ndarray
    eigenvalues: np.ndarray
    eigenfunctions: np.ndarray
    proxy: np.ndarray
    proxy_edges: np.ndarray
    proxy_distances: np.ndarray
    curvatures: np.ndarray
    cut_vertex: int
    closure: float
    area: float
    diameter: float
    timings: dict[str, float]
    warnings: tuple[str, ...]

    @property
    def whole_mesh(self) -> Mesh:
        """The repaired mesh with all of the user's vertices."""
        return self.mesh if self.detail is None else self.detail.mesh

    @property
    def info(self) -> dict[str, Any]:
        """Path, SHA-256, numbers of vertices and faces, area and diameter, as they stand in results."""
        mesh = self.mesh
        return {
            "path": None if mesh.path is None else str(mesh.path),
            "sha256": mesh.sha256,
            "vertices": mesh.n_file_vertices,
            "faces": mesh.n_file_faces,
            "area": self.area,
            "diameter": self.diameter,
        }

    @property
    def notes(self) -> list[str]:
        """What a user should know of the mesh and its preparation, one line each."""
        return [f"{self.mesh.name}: {note}" for note in (*self.mesh.notes, *self.warnings)]

    @property
    def normalized_distances(self) -> np.ndarray:
        """Geodesic distances between the samples per sqrt(area), (N, N)."""
        return self.distances / np.sqrt(self.area)

    @property
    def average_distances(self) -> np.ndarray:
        """Average geodesic distance of each sample to the surface per sqrt(area), (N,)."""
        return self.normalized_distances @ self.cells / self.area

    @cached_property
    def descriptors(self) -> np.ndarray:
        """Wave kernel signatures (n, 12) of all vertices: logarithms, 0 on average, squares of a row sum to about 1."""
        found = np.log(wave_kernel_signature(self.eigenvalues, self.eigenfunctions)[:, LEVELS] + np.finfo(float).eps)
        spread = np.maximum(found[self.proxy].std(axis=0), LEAST_SPREAD)
        found = (found - found[self.proxy].mean(axis=0)) / spread
        return np.asarray(found / np.sqrt(found.shape[1]), np.float32)

    @cached_property
    def relief(self) -> np.ndarray:
        """Gauss and mean curvature (n, 2) float32 of all vertices, for comparison: from the median, about 1 in size."""
        median, spread = (f(self.curvatures[:2, self.proxy], axis=1) for f in (np.median, np.std))
        return np.arcsinh(RELIEF * (self.curvatures[:2].T - median) / np.maximum(spread, FLAT))

    @cached_property
    def proxy_ways(self) -> np.ndarray:
        """Lengths (P, P) per sqrt(area) of the shortest ways along the proxy's edges; infinite beyond 0.2."""
        graph = graph_of(self.mesh.vertices[self.proxy], self.proxy_edges)
        graph.data /= np.sqrt(self.area)
        return np.asarray(dijkstra(graph, directed=False, limit=NEARBY))

    @cached_property
    def homes(self) -> np.ndarray:
        """(n,) int64: place in ``proxy`` of the vertex that is nearest to each vertex of the mesh, along edges."""
        return nearest_centres(self.mesh.vertices / np.sqrt(self.area), self.mesh.faces, self.proxy)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the surface to a file (numpy's .npz); an existing one is replaced at once or not at all."""
        save_surface(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Surface:
        """Read a file that :meth:`save` wrote.

        Raises
        ------
        FormatError
            If the file cannot be read or is none of this version.
        """
        return cls(**load_fields(path))


def matchable(thing: Any) -> Mesh:
    """The repaired mesh of a path, of arrays, or of an object with both, if it can be matched at all.

    Raises
    ------
    MeshError
        If it cannot; the message says why and what to do.
    """
    mesh = repair(as_mesh(thing))
    require_matchable(mesh)
    return mesh


def prepare_mesh(mesh: Mesh, settings: PrepareSettings, progress: Progress | None = None) -> Surface:
    """:func:`prepare` for a mesh that :func:`matchable` gave."""
    # One BLAS thread: these are many small calls, and sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        return _prepare(mesh, settings, progress or (lambda stage, done, total: None))


def _prepare(mesh: Mesh, settings: PrepareSettings, progress: Progress) -> Surface:
    warnings = []
    clock = _Clock()
    mesh, detail = simplified(mesh, settings.resolution) if settings.resolution else (mesh, None)
    if detail:
        clock.lap("simplifying")
    # A box of size 1 keeps squares and areas far from overflow, whatever the units of the file.
    scale = float(np.ptp(mesh.vertices, axis=0).max())
    vertices = (mesh.vertices - mesh.vertices.mean(axis=0)) / scale
    triangulation = intrinsic_mesh(vertices, mesh.faces, delaunay=settings.triangulation == "delaunay")
    areas = triangulation.areas
    area = float(areas.sum())
    progress(f"sampling {mesh.name}", 0, 3)
    if (settings.geodesics, settings.triangulation) == ("heat", "delaunay"):
        solver = heat_solver(triangulation)
    else:
        solver = geodesic_solver(vertices, mesh.faces, settings.geodesics)
    samples = sample_points(triangulation, solver, settings.samples)
    if not np.isfinite(samples.distances).all():
        raise MeshError(f"{mesh.name}: geodesic distances could not be computed; check the mesh for sliver triangles")
    if len(samples.vertices) < settings.samples:
        warnings.append(
            f"has only {len(samples.vertices)} vertices; each of them is a sample ({settings.samples} were asked for)"
        )
    cells = np.bincount(samples.distances.argmin(axis=0), areas, len(samples.vertices))
    distances = samples.distances[:, samples.vertices]
    # Heat distances are not quite symmetric.
    distances = (distances + distances.T) / 2
    np.fill_diagonal(distances, 0.0)
    clock.lap("sampling")
    progress(f"flattening {mesh.name}", 1, 3)
    average = cells @ samples.distances / area
    cut_face = choose_cut_face(triangulation, average)
    flattening = flatten(triangulation, cut_face)
    if not flattening.closure < LARGEST_CLOSURE:
        warnings.append(
            f"the flattening closes only to {flattening.closure:.1e} of its extent; "
            "matches may suffer; remove sliver triangles"
        )
    positions = vertex_positions(flattening, triangulation, samples.vertices, settings.placement)
    clock.lap("flattening")
    progress(f"describing {mesh.name}", 2, 3)
    eigenvalues, eigenfunctions = eigenbasis(triangulation, EIGENFUNCTIONS)
    signatures = wave_kernel_signature(eigenvalues, eigenfunctions[samples.vertices])
    curvatures = np.stack(
        [
            gauss_curvature(triangulation, RADIUS),
            mean_curvature(triangulation, vertices, mesh.faces, RADIUS),
            mean_curvature(triangulation, vertices, mesh.faces, WIDE_RADIUS),
        ]
    )
    proxy = proxy_points(areas, PROXY_SIZE, samples.vertices)
    nearest = nearest_centres(vertices, mesh.faces, proxy)
    touching = np.sort(nearest[mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)], axis=1)
    clock.lap("descriptors")
    progress(f"prepared {mesh.name}", 3, 3)
    return Surface(
        mesh=mesh,
        detail=detail,
        settings=settings,
        samples=samples.vertices,
        n_maxima=samples.n_maxima,
        distances=distances * scale,
        cells=cells * scale**2,
        positions=positions,
        signatures=signatures,
        eigenvalues=eigenvalues,
        eigenfunctions=eigenfunctions.astype(np.float32),
        proxy=proxy,
        proxy_edges=np.unique(touching[touching[:, 0] < touching[:, 1]], axis=0),
        proxy_distances=(samples.distances[:, proxy] * scale).astype(np.float32),
        curvatures=curvatures.astype(np.float32),
        cut_vertex=int(np.argmin(average)),
        closure=flattening.closure,
        area=area * scale**2,
        diameter=float(samples.distances.max()) * scale,
        timings=clock.laps,
        warnings=tuple(warnings),
    )


class _Clock:
    """Seconds between one call of :meth:`lap` and the next."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.laps[name] = now - self._last
        self._last = now
