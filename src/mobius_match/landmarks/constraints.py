"""Pairs of points that the user knows to correspond, and how they constrain the match of all others.

Beyond the paper. An alignment that displaces a landmark costs more. If every alignment does, votes are cast again, for
pairs of points with similar distances from the landmarks of their surface. Registration is constrained at landmarks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from .._core.display import one_line
from ..errors import SettingsError
from ..geometry.geodesics import geodesic_solver
from ..geometry.points import SurfacePoints, points_at
from ..mesh.user_mesh import repaired_numbers, user_mesh
from ..surface.surface import Surface
from .pairs import given_pairs
from .parameters import DEFAULT, LandmarkParameters


@dataclass(frozen=True, eq=False)
class PointConstraints:
    """Target positions of some points in registration.

    Parameters
    ----------
    rows
        (p,) int64: which points of the proxy.
    targets
        (p, 3): target positions of the landmarks.
    offsets
        (p, 3): from the landmarks to the points of the proxy, on the undeformed source.
    weight
        Data weight of these points.
    """

    rows: np.ndarray
    targets: np.ndarray
    offsets: np.ndarray
    weight: float

    def __repr__(self) -> str:
        return one_line(self)


def apply_constraints(
    point_constraints: PointConstraints | None, targets: np.ndarray, data_weights: np.ndarray, rotations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Replace the target positions and the weights of constrained points.

    Parameters
    ----------
    point_constraints
        The constraints; None for none.
    targets, data_weights
        (n, 3) target positions and (n,) weights of all points.
    rotations
        (n, 3, 3) rotations of row vectors, which rotate the offsets; empty before the first local step.

    Returns
    -------
    targets, data_weights
        The same with those of the constrained points.
    """
    if point_constraints is None:
        return targets, data_weights
    rows = point_constraints.rows
    targets, data_weights = targets.copy(), data_weights.copy()
    offsets = np.einsum("pi,pij->pj", point_constraints.offsets, rotations[rows]) if len(rotations) else 0.0
    targets[rows], data_weights[rows] = point_constraints.targets + offsets, point_constraints.weight
    return targets, data_weights


@dataclass(frozen=True, eq=False)
class LandmarkConstraints:
    """Landmarks on two prepared surfaces, which are not modified.

    Parameters
    ----------
    pairs
        (k, 2) int64 vertices of source and target, in the numbers of the user's files.
    whole_vertices
        (k,) int64 of each side: the same vertices in the numbers of the repaired meshes.
    vertices
        (k,) int64 of each side: the same vertices, or the nearest, in the numbers of the simplified meshes.
    proxy_rows
        (k,) int64 of each side: rows of the proxy that are nearest to these along the surface.
    distances
        (h, n1) and (h, n2) float32 geodesic distances from the first h landmarks to all vertices, in the meshes' units.
    parameters
        Constants of the method.
    """

    pairs: np.ndarray
    whole_vertices: tuple[np.ndarray, np.ndarray]
    vertices: tuple[np.ndarray, np.ndarray]
    proxy_rows: tuple[np.ndarray, np.ndarray]
    distances: tuple[np.ndarray, np.ndarray]
    parameters: LandmarkParameters

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def inverse(self) -> LandmarkConstraints:
        """The landmarks from target to source."""
        return LandmarkConstraints(
            self.pairs[:, ::-1],
            self.whole_vertices[::-1],
            self.vertices[::-1],
            self.proxy_rows[::-1],
            self.distances[::-1],
            self.parameters,
        )

    def disagreement(
        self, source: Surface, target: Surface, source_vertices: np.ndarray, target_vertices: np.ndarray
    ) -> np.ndarray:
        """Mean difference (q1, q2) per sqrt(area) between vertices' (q1,), (q2,) distances from the landmarks."""
        normalized1 = self.distances[0][:, source_vertices] / source.scale
        normalized2 = self.distances[1][:, target_vertices] / target.scale
        total = np.zeros((len(source_vertices), len(target_vertices)))
        for distances1, distances2 in zip(normalized1, normalized2, strict=True):
            total += np.abs(distances1[:, None] - distances2)
        return total / len(normalized1)

    def displacement(self, source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
        """Distance (h,) per sqrt(area) between landmarks' images and their counterparts.

        Parameters
        ----------
        source, target
            The surfaces.
        image
            (P1,) vertices of the target to which a map sends the source's proxy.
        """
        landmarks, rows = np.arange(len(self.distances[0])), self.proxy_rows[0][: len(self.distances[0])]
        # The map is known at the nearest vertex of the proxy, so its distance from the landmark is no displacement.
        tolerance = self.distances[0][landmarks, source.proxy[rows]] / source.scale
        return np.maximum(self.distances[1][landmarks, image[rows]] / target.scale - tolerance, 0.0)

    def point_constraints(self, source: Surface, target: Surface, positions: np.ndarray) -> PointConstraints:
        """The landmarks as constraints in the registration of the source's proxy.

        Parameters
        ----------
        source, target
            The surfaces.
        positions
            (n2, 3) of the target's vertices, in the coordinates of the registration.
        """
        rest = source.mesh.vertices / source.scale
        # Of two landmarks at one vertex of the proxy the first counts.
        rows, first = np.unique(self.proxy_rows[0], return_index=True)
        source_vertices, target_vertices = (vertices[first] for vertices in self.vertices)
        offsets = rest[source.proxy[rows]] - rest[source_vertices]
        return PointConstraints(rows, positions[target_vertices], offsets, self.parameters.weight)

    def inconsistency_warnings(self, source: Surface, target: Surface) -> list[str]:
        """A warning about the landmark whose distances from most others differ most, if they differ much."""
        count = len(self.distances[0])
        between1, between2 = (
            distances[:, vertices[:count]] / surface.scale
            for distances, vertices, surface in zip(self.distances, self.vertices, (source, target), strict=True)
        )
        others = ~np.eye(count, dtype=bool)
        differences = np.array(
            [np.median(row[k]) for row, k in zip(np.abs(between1 - between2), others, strict=True) if k.any()]
        )
        if differences.max(initial=0.0) < self.parameters.inconsistency:
            return []
        i, j = self.pairs[differences.argmax()].tolist()
        return [
            f"landmarks: the distances of {source.mesh.name} vertex {i} and {target.mesh.name} vertex {j} from the "
            "other landmarks differ; check this pair"
        ]


def landmark_constraints(
    given: Any, source: Surface, target: Surface, parameters: LandmarkParameters = DEFAULT
) -> tuple[LandmarkConstraints, list[str]]:
    """Check landmarks and compute what follows from them.

    Parameters
    ----------
    given
        (k, 2) vertex numbers, from 0 as in the user's files; a file of pairs (CSV, columns ``source`` and ``target``)
        or of two specimens; or two files of landmarks, the source's and the target's.
    source, target
        The surfaces.
    parameters
        Constants of the method.

    Returns
    -------
    constraints
        The landmarks on both surfaces.
    notes
        A line on each landmark that is ignored or doubtful.

    Raises
    ------
    SettingsError
        For anything else, a vertex that does not exist, a vertex with two counterparts, or no pair.
    FormatError
        If a file is malformed.
    """
    surfaces = source, target
    pairs, notes = given_pairs(given, (source.whole_mesh, target.whole_mesh))
    whole1, whole2 = (_whole_vertices(surface, numbers) for surface, numbers in zip(surfaces, pairs.T, strict=True))
    vertices1, vertices2 = (
        vertices if surface.detail is None else surface.detail.places(surface.mesh).nearest[vertices]
        for surface, vertices in zip(surfaces, (whole1, whole2), strict=True)
    )
    with threadpool_limits(limits=1, user_api="blas"):  # sums must not depend on the number of processors
        distances1, distances2 = (
            _distances(surface, vertices[: parameters.max_guides])
            for surface, vertices in zip(surfaces, (vertices1, vertices2), strict=True)
        )
    constraints = LandmarkConstraints(
        pairs,
        (whole1, whole2),
        (vertices1, vertices2),
        (source.nearest_proxy[vertices1], target.nearest_proxy[vertices2]),
        (distances1, distances2),
        parameters,
    )
    return constraints, notes + constraints.inconsistency_warnings(source, target)


def _distances(surface: Surface, vertices: np.ndarray) -> np.ndarray:
    """Geodesic distances (h, n) float32 from vertices (h,), in the units of the mesh."""
    mesh, scale = surface.mesh, surface.scale
    positions = (mesh.vertices - mesh.vertices.mean(axis=0)) / scale  # far from overflow, as in preparation
    solve = geodesic_solver(positions, mesh.faces, surface.geodesics)
    return np.stack([solve(int(vertex)) * scale for vertex in vertices]).astype(np.float32)


def _whole_vertices(surface: Surface, numbers: np.ndarray) -> np.ndarray:
    """Vertices (k,) of the repaired mesh with the user's numbers, or those that repair has joined them with."""
    mesh = surface.whole_mesh
    repaired = np.full(mesh.n_file_vertices, -1, np.int64)
    repaired[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertices))[::-1]
    if (repaired[numbers] < 0).any():
        repaired = repaired_numbers(mesh, user_mesh(mesh))
    vertices = repaired[numbers]
    if (vertices < 0).any():
        raise SettingsError(
            f"`landmarks`: vertex {numbers[vertices < 0][0]} of {mesh.name} is in no matched face; give a neighbour"
        )
    return vertices


def with_given_pairs(
    matches: dict[str, Any], constraints: LandmarkConstraints | None, target: Surface
) -> dict[str, Any]:
    """Matches with the landmarks first, in place of those that share a vertex with one.

    Parameters
    ----------
    matches
        Fields of a :class:`.Correspondence`.
    constraints
        The landmarks; None for none.
    target
        The target surface.
    """
    if constraints is None:
        return matches
    number = len(constraints.pairs)
    kept = ~(
        np.isin(matches["pairs"][:, 0], constraints.pairs[:, 0])
        | np.isin(matches["pairs"][:, 1], constraints.pairs[:, 1])
    )
    merged = {
        "pairs": np.concatenate([constraints.pairs, matches["pairs"][kept]]),
        "confidence": np.concatenate([np.ones(number), matches["confidence"][kept]]),
        "kind": np.concatenate([np.full(number, "voted"), matches["kind"][kept]]),
        "given": np.arange(number + kept.sum()) < number,
    }
    target_points = matches.get("target_points")
    if target_points is not None:
        mesh = target.whole_mesh
        exact = points_at(mesh.faces, constraints.whole_vertices[1])
        parts = mesh.face_ids[exact.faces], mesh.vertex_ids[exact.corners], exact.barycentric
        rest = target_points.faces[kept], target_points.corners[kept], target_points.barycentric[kept]
        points = SurfacePoints(*(np.concatenate(both) for both in zip(parts, rest, strict=True)))
        return {**merged, "target_points": points}
    return merged
