"""A mesh made ready for matching: sections 4 and 5 and the descriptors, computed once and shared between pairs."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse.csgraph import dijkstra

from .._core.display import html_table, shortened
from ..geometry.geodesics import graph_of, nearest_centres
from ..geometry.spectral import wave_kernel_signature
from ..mesh import Mesh
from ..mesh.pieces import pieces_of, unreached_vertices
from ..mesh.topology import boundary_edges, labels_of
from ..settings import LARGEST_SPACING, PrepareSettings
from .parameters import SurfaceParameters
from .simplified import Detail
from .storage import load_fields, save_surface

LEAST_LEVEL_DEVIATION, LEAST_CURVATURE_DEVIATION = 0.1, 1.0
"""Standard deviations below which the level of a descriptor, or a curvature, is not scaled up: a sphere has round-off
alone. Real shapes have more."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A prepared mesh: sample points, flattening, descriptors. It can be matched many times, and saved.

    Parameters
    ----------
    mesh
        The repaired mesh, or a simplified one where that is large; all vertex numbers below are its own.
    detail
        The repaired mesh and how the simplified one lies on it; None where nothing was simplified.
    settings, parameters
        The settings and the constants of the method that it was prepared with.
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
    disc
        (P,) complex128 positions of the proxy's vertices in the unit disc; empty where the surface is closed.
    signatures
        (N, 100) float64 wave kernel signatures of the samples.
    eigenvalues, eigenfunctions
        (k,) float64 and (n, k) float32: of the Laplacian, for a surface of area 1.
    proxy
        (P,) int64 vertices that represent the whole surface where detail is not needed, ascending: the samples, and
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
    loops, loop_sizes
        (l,) int64 vertices of the user's mesh along the loops around handles, one loop after the other, and (h,) int64
        how many each has; empty where there is no handle.
    handles_kept
        False if the mesh is cut open along all loops, as where parts of a body touch; True if handles are real, and
        cut in the flattening alone.
    envelope
        Distance per sqrt(area) of the envelope that stands for the mesh from it; 0 where none does.
    other
        The same mesh prepared with its handles kept, or on a wider envelope, where that is possible as well; else None.
    area, diameter
        Area and (estimated) geodesic diameter, in units of the mesh.
    timings
        Seconds that each stage took.
    warnings
        Notes on the preparation, one line each.
    """

    mesh: Mesh
    detail: Detail | None
    settings: PrepareSettings
    parameters: SurfaceParameters
    samples: np.ndarray
    n_maxima: int
    distances: np.ndarray
    cells: np.ndarray
    positions: np.ndarray
    disc: np.ndarray
    signatures: np.ndarray
    eigenvalues: np.ndarray
    eigenfunctions: np.ndarray
    proxy: np.ndarray
    proxy_edges: np.ndarray
    proxy_distances: np.ndarray
    curvatures: np.ndarray
    cut_vertex: int
    closure: float
    loops: np.ndarray
    loop_sizes: np.ndarray
    handles_kept: bool
    envelope: float
    other: Surface | None
    area: float
    diameter: float
    timings: dict[str, float]
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        mesh = self.mesh
        simplified = "" if self.detail is None else f" (simplified from {len(self.whole_mesh.vertices)})"
        return (
            f"<Surface {shortened(mesh.name)}: {len(mesh.vertices)} vertices{simplified}, "
            f"{len(self.samples)} samples, area {self.area:.4g}>"
        )

    def _repr_html_(self) -> str:
        info = self.info
        rows = [
            ("vertices", info["vertices"]),
            ("faces", info["faces"]),
            ("vertices that are computed on", len(self.mesh.vertices)),
            ("samples", len(self.samples)),
            ("area", f"{self.area:.4g}"),
            ("geodesic diameter", f"{self.diameter:.4g}"),
        ]
        return html_table(f"Prepared surface {shortened(self.mesh.name)}", (), rows, notes=self.notes)

    @property
    def scale(self) -> np.float64:
        """The length that coordinates and distances are divided by: sqrt(area)."""
        return np.float64(np.sqrt(self.area))

    @property
    def whole_mesh(self) -> Mesh:
        """The repaired mesh with all of the user's vertices."""
        return self.mesh if self.detail is None else self.detail.mesh

    @property
    def readings(self) -> tuple[Surface, ...]:
        """This surface, and the one with its handles kept, where both are possible."""
        return (self,) if self.other is None else (self, self.other)

    @property
    def info(self) -> dict[str, Any]:
        """Path, SHA-256, numbers of vertices and faces, area and diameter, as they stand in results.

        Where they are not zero, also the number of pieces beside the one that the area and the diameter are of, and of
        vertices that no face uses once the mesh is repaired.
        """
        mesh, others, unreached = self.mesh, self.whole_mesh.others, len(unreached_vertices(self.whole_mesh))
        return {
            "path": None if mesh.path is None else str(mesh.path),
            "sha256": mesh.sha256,
            "vertices": mesh.n_file_vertices,
            "faces": mesh.n_file_faces,
            "area": self.area,
            "diameter": self.diameter,
            **({} if others is None else {"other_pieces": len(pieces_of(others))}),
            **({"unreached_vertices": unreached} if unreached else {}),
        }

    @property
    def notes(self) -> list[str]:
        """Notes and warnings on the mesh and its preparation, one line each."""
        return [f"{self.mesh.name}: {note}" for note in (*self.mesh.notes, *self.warnings)]

    @property
    def normalized_distances(self) -> np.ndarray:
        """Geodesic distances between the samples per sqrt(area), (N, N)."""
        return self.distances / self.scale

    @property
    def average_distances(self) -> np.ndarray:
        """Average geodesic distance of each sample to the surface per sqrt(area), (N,)."""
        return self.normalized_distances @ self.cells / self.area

    @cached_property
    def open_edges(self) -> np.ndarray:
        """Edges (b, 2) of the boundary, without those along which handles were cut open: there nothing is missing."""
        edges = boundary_edges(self.mesh.faces)
        return edges[~np.isin(self.mesh.vertex_ids[edges], self.loops).all(axis=1)]

    @cached_property
    def rim(self) -> np.ndarray:
        """Edges (e, 2) of the longest loop of the boundary, as in ``open_edges``; none where the surface is closed."""
        edges = self.open_edges
        number, labels = labels_of(len(self.mesh.vertices), *edges.T)
        loop = labels[edges[:, 0]]
        return edges[loop == np.bincount(loop, self._lengths(edges), number).argmax()]

    @property
    def rim_length(self) -> float:
        """Length of the rim per sqrt(area); 0 where the surface is closed."""
        return float(self._lengths(self.rim).sum() / self.scale)

    def _lengths(self, edges: np.ndarray) -> np.ndarray:
        """Lengths (e,) of edges (e, 2) in the units of the mesh."""
        ends = self.mesh.vertices[edges]
        return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)

    @cached_property
    def descriptors(self) -> np.ndarray:
        """Standardised logarithms of wave kernel signatures (n, 12) float32 of all vertices; rows of length about 1."""
        step = self.parameters.descriptor_step
        signatures = wave_kernel_signature(self.eigenvalues, self.eigenfunctions)
        levels = np.log(signatures[:, step // 2 :: step] + np.finfo(float).eps)
        deviation = np.maximum(levels[self.proxy].std(axis=0), LEAST_LEVEL_DEVIATION)
        levels = (levels - levels[self.proxy].mean(axis=0)) / deviation
        return np.asarray(levels / np.sqrt(levels.shape[1]), np.float32)

    @cached_property
    def curvature_features(self) -> np.ndarray:
        """Gauss and mean curvature (n, 2) float32 of all vertices: from the median, large ones compressed by asinh."""
        median, deviation = (f(self.curvatures[:2, self.proxy], axis=1) for f in (np.median, np.std))
        deviation = np.maximum(deviation, LEAST_CURVATURE_DEVIATION)
        return np.arcsinh(self.parameters.curvature_gain * (self.curvatures[:2].T - median) / deviation)

    @cached_property
    def proxy_geodesics(self) -> np.ndarray:
        """Geodesic distances (P, P) per sqrt(area) along the proxy's edges; infinite beyond the largest spacing."""
        graph = graph_of(self.mesh.vertices[self.proxy], self.proxy_edges)
        graph.data /= self.scale
        return np.asarray(dijkstra(graph, directed=False, limit=LARGEST_SPACING))

    @cached_property
    def nearest_proxy(self) -> np.ndarray:
        """(n,) int64: place in ``proxy`` of the vertex that is nearest to each vertex of the mesh, along edges."""
        return nearest_centres(self.mesh.vertices / self.scale, self.mesh.faces, self.proxy)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the surface to a file; an existing one is replaced at once or not at all.

        Parameters
        ----------
        path
            The file. Name it .npz, so that :func:`mobius_match.match` takes it in place of the mesh.
        """
        save_surface(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Surface:
        """Read a file that :meth:`save` wrote.

        Parameters
        ----------
        path
            The file.

        Returns
        -------
        Surface
            The surface.

        Raises
        ------
        FormatError
            If the file cannot be read or is none of this version.
        """
        return cls._of(load_fields(path))

    @classmethod
    def _of(cls, found: dict[str, Any]) -> Surface:
        """The surface with the fields of a file."""
        other = found["other"]
        return cls(**found | {"other": None if other is None else cls._of(other)})


@dataclass(frozen=True, eq=False, repr=False)
class PartialSurface(Surface):
    """A part of a larger surface: its lengths are divided by sqrt(area) of the whole, not of the part.

    Parameters
    ----------
    whole_area
        Area of the whole in the units of the part.
    """

    whole_area: float

    @classmethod
    def of(cls, surface: Surface, whole_area: float) -> PartialSurface:
        """A surface as a part of another one."""
        return cls(**{one.name: getattr(surface, one.name) for one in fields(Surface)}, whole_area=whole_area)

    @property
    def scale(self) -> np.float64:
        """The length that coordinates and distances are divided by."""
        return np.float64(np.sqrt(self.whole_area))
