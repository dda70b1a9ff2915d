"""Pairs of points that the user knows to correspond, and what follows from them for all others.

Beyond the paper. Of several explanations one that sends a hint elsewhere is worse by far. If all do, votes are cast
once more, for pairs that are as far from the two ends of a hint. Where the source is bent, it is pinned to its place.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import SettingsError
from ..geometry.geodesics import geodesic_solver
from ..geometry.points import SurfacePoints, points_at
from ..surface.surface import Surface

if TYPE_CHECKING:
    pass

ASTRAY = 0.2
"""Distance per sqrt(area) from which an explanation is held to send a hint elsewhere: maps are blurred, and a user's
landmarks need not be exact."""

PINNED = 10.0
"""Weight of the places of hints against rigidity."""

DIFFERING = 0.4
"""Median difference per sqrt(area) of a hint's distances from the others above which a user is asked."""

HEARD = 60
"""How many hints have a say about all other points; all are pinned."""


@dataclass(frozen=True, eq=False)
class PointConstraints:
    """Points of a body that is bent, and where they belong.

    Parameters
    ----------
    rows
        (p,) int64: which points of the body.
    places
        (p, 3): where the hints themselves belong.
    arms
        (p, 3): from the hints to the points, at rest.
    """

    rows: np.ndarray
    places: np.ndarray
    arms: np.ndarray


def apply_constraints(
    point_constraints: PointConstraints | None, places: np.ndarray, data_weight: np.ndarray, rotations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) and their trust (n,), pinned points where they belong, with the turns (n, 3, 3) around them."""
    if point_constraints is None:
        return places, data_weight
    places, data_weight = places.copy(), data_weight.copy()
    arms = np.einsum("pi,pij->pj", point_constraints.arms, rotations[point_constraints.rows]) if len(rotations) else 0.0
    places[point_constraints.rows], data_weight[point_constraints.rows] = point_constraints.places + arms, PINNED
    return places, data_weight


@dataclass(frozen=True, eq=False)
class LandmarkConstraints:
    """Hints on two prepared surfaces; those are none the wiser.

    Parameters
    ----------
    pairs
        (k, 2) int64: vertices of source and target, in the numbers of the user's files.
    ends
        (k,) int64 of each side: the same, in the numbers of the surfaces' whole meshes.
    vertices
        (k,) int64 of each side: the same, or the nearest, in the numbers of the meshes that are computed on.
    beside
        (k,) int64 of each side: the places in the proxy of its vertices next to these along the surface.
    distances
        (h, n1) and (h, n2) float32, from the first hints along the surfaces to all vertices, in the meshes' units.
    """

    pairs: np.ndarray
    ends: tuple[np.ndarray, np.ndarray]
    vertices: tuple[np.ndarray, np.ndarray]
    beside: tuple[np.ndarray, np.ndarray]
    distances: tuple[np.ndarray, np.ndarray]

    @property
    def inverse(self) -> LandmarkConstraints:
        """The hints from target to source."""
        return LandmarkConstraints(
            self.pairs[:, ::-1], self.ends[::-1], self.vertices[::-1], self.beside[::-1], self.distances[::-1]
        )

    def disagreement(self, source: Surface, target: Surface, here: np.ndarray, there: np.ndarray) -> np.ndarray:
        """How much vertices (q1,) and (q2,) differ in their distances from the hints, (q1, q2), mean per sqrt(area)."""
        mine, theirs = (
            self.distances[0][:, here] / np.sqrt(source.area),
            self.distances[1][:, there] / np.sqrt(target.area),
        )
        total = np.zeros((len(here), len(there)))
        for one, other in zip(mine, theirs, strict=True):
            total += np.abs(one[:, None] - other)
        return total / len(mine)

    def displacement(self, source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
        """How far (h,) per sqrt(area) of the target a map of the proxy (P1,) to its vertices sends the hints."""
        every, rows = np.arange(len(self.distances[0])), self.beside[0][: len(self.distances[0])]
        # What a vertex beside the hint may be off, it is not astray.
        beside = self.distances[0][every, source.proxy[rows]] / np.sqrt(source.area)
        return np.maximum(self.distances[1][every, image[rows]] / np.sqrt(target.area) - beside, 0.0)

    def point_constraints(self, source: Surface, target: Surface, places: np.ndarray) -> PointConstraints:
        """The hints for bending the source's proxy.

        Parameters
        ----------
        source, target
            The surfaces.
        places
            (n2, 3) of the target's vertices, wherever and at whatever size it lies.
        """
        rest = source.mesh.vertices / np.sqrt(source.area)
        rows, first = np.unique(self.beside[0], return_index=True)  # of two hints beside one vertex the first
        here, there = (vertices[first] for vertices in self.vertices)
        return PointConstraints(rows, places[there], rest[source.proxy[rows]] - rest[here])

    def inconsistency_warnings(self, source: Surface, target: Surface) -> list[str]:
        """A line on the hint that fits least with the others, if it does not fit with most of them."""
        heard = len(self.distances[0])
        mine, theirs = (
            distances[:, vertices[:heard]] / np.sqrt(surface.area)
            for distances, vertices, surface in zip(self.distances, self.vertices, (source, target), strict=True)
        )
        others = ~np.eye(heard, dtype=bool)
        differing = np.array(
            [np.median(row[k]) for row, k in zip(np.abs(mine - theirs), others, strict=True) if k.any()]
        )
        if differing.max(initial=0.0) < DIFFERING:
            return []
        i, j = self.pairs[differing.argmax()].tolist()
        return [
            f"landmarks: {source.mesh.name} vertex {i} and {target.mesh.name} vertex {j} are not as far from the other "
            "landmarks; are all of them right?"
        ]


def landmark_constraints(given: Any, source: Surface, target: Surface) -> tuple[LandmarkConstraints, list[str]]:
    """Hints, checked, and a line for whatever is left out of them.

    Parameters
    ----------
    given
        (k, 2) vertex numbers, counting from 0 as the user's files do; a file of pairs (CSV, columns ``source`` and
        ``target``) or of two specimens; or two files of landmarks, the source's and the target's.
    source, target
        The surfaces.

    Raises
    ------
    SettingsError
        For what is none of these, a vertex that is not there, a vertex that is given two counterparts, or no pair.
    FormatError
        If a file is malformed.
    """
    pairs, notes = _pairs(given, source, target)
    if not len(pairs):
        raise SettingsError("landmarks: there is no pair; give one at least")
    for side, surface in enumerate((source, target)):
        wrong = pairs[(pairs[:, side] < 0) | (pairs[:, side] >= surface.mesh.n_file_vertices), side]
        if len(wrong):
            raise SettingsError(
                f"landmarks: {surface.mesh.name} has no vertex {wrong[0]}; it has {surface.mesh.n_file_vertices}, "
                "numbered from 0"
            )
    _, first = np.unique(pairs, axis=0, return_index=True)
    if len(first) < len(pairs):
        notes.append(f"landmarks: {len(pairs) - len(first)} given more than once count once")
        pairs = pairs[np.sort(first)]
    for side, surface in enumerate((source, target)):
        values, counts = np.unique(pairs[:, side], return_counts=True)
        if counts.max() > 1:
            number = values[counts.argmax()]
            others = ", ".join(map(str, pairs[pairs[:, side] == number, 1 - side].tolist()))
            raise SettingsError(
                f"landmarks: vertex {number} of {surface.mesh.name} is given {counts.max()} counterparts ({others}); "
                "keep the right one"
            )
    ends = _ends(source, pairs[:, 0]), _ends(target, pairs[:, 1])
    simple = tuple(
        end if surface.detail is None else surface.detail.places(surface.mesh).nearest[end]
        for surface, end in zip((source, target), ends, strict=True)
    )
    with threadpool_limits(limits=1, user_api="blas"):  # sums must not depend on the number of processors
        (beside1, distances1), (beside2, distances2) = (
            _around(surface, vertices) for surface, vertices in zip((source, target), simple, strict=True)
        )
    found = LandmarkConstraints(pairs, ends, (simple[0], simple[1]), (beside1, beside2), (distances1, distances2))
    return found, notes + found.inconsistency_warnings(source, target)


def _around(surface: Surface, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (k,) in the proxy beside vertices, and distances (h, n) float32 from the first of them."""
    mesh, scale = surface.mesh, np.sqrt(surface.area)
    places = (mesh.vertices - mesh.vertices.mean(axis=0)) / scale  # far from overflow, as in preparation
    solve = geodesic_solver(places, mesh.faces, surface.settings.geodesics)
    distances = np.stack([solve(int(vertex)) * scale for vertex in vertices[:HEARD]]).astype(np.float32)
    return surface.nearest_proxy[vertices], distances


def _ends(surface: Surface, numbers: np.ndarray) -> np.ndarray:
    """Vertices (k,) of the repaired mesh with the user's numbers, or that repair has joined them with."""
    mesh = surface.whole_mesh
    known = np.full(mesh.n_file_vertices, -1, np.int64)
    known[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertices))[::-1]
    if (known[numbers] < 0).any():
        from ..mesh.user_mesh import repaired_numbers, user_mesh

        known = repaired_numbers(mesh, user_mesh(mesh))
    found = known[numbers]
    if (found < 0).any():
        raise SettingsError(
            f"landmarks: vertex {numbers[found < 0][0]} of {mesh.name} is in no matched face; name a neighbour"
        )
    return found


def _pairs(given: Any, source: Surface, target: Surface) -> tuple[np.ndarray, list[str]]:
    """Vertex numbers (k, 2) of whatever was given, and notes."""
    paths = [given] if isinstance(given, str | os.PathLike) else given
    if isinstance(paths, list | tuple) and paths and all(isinstance(one, str | os.PathLike) for one in paths):
        from .pairs import pairs_of_files

        return pairs_of_files([Path(one) for one in paths], (source.whole_mesh, target.whole_mesh))
    try:
        pairs = np.array(given)
    except (ValueError, TypeError):
        pairs = np.empty(0, object)
    if pairs.size == 0 and pairs.dtype != object:
        return np.empty((0, 2), np.int64), []
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu":
        raise SettingsError("landmarks are pairs (k, 2) of vertex numbers, a file of pairs, or two files of landmarks")
    return pairs.astype(np.int64), []


def with_given_pairs(
    matches: dict[str, Any], constraints: LandmarkConstraints | None, target: Surface
) -> dict[str, Any]:
    """Matches, as fields of a :class:`.Correspondence`, with hints before all others and in place of theirs."""
    if constraints is None:
        return matches
    number = len(constraints.pairs)
    kept = ~(
        np.isin(matches["pairs"][:, 0], constraints.pairs[:, 0])
        | np.isin(matches["pairs"][:, 1], constraints.pairs[:, 1])
    )
    found = {
        "pairs": np.concatenate([constraints.pairs, matches["pairs"][kept]]),
        "confidence": np.concatenate([np.ones(number), matches["confidence"][kept]]),
        "kind": np.concatenate([np.full(number, "voted"), matches["kind"][kept]]),
        "given": np.arange(number + kept.sum()) < number,
    }
    others = matches.get("target_points")
    if others is not None:
        mesh = target.whole_mesh
        exact = points_at(mesh.faces, constraints.ends[1])
        parts = mesh.face_ids[exact.faces], mesh.vertex_ids[exact.corners], exact.barycentric
        rest = others.faces[kept], others.corners[kept], others.barycentric[kept]
        points = SurfacePoints(*(np.concatenate(both) for both in zip(parts, rest, strict=True)))
        return {**found, "target_points": points}
    return found
