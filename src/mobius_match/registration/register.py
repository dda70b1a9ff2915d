"""The source bent onto the target, as rigidly as possible, along the chosen explanation: matches finer than samples.

Beyond the paper. A map of few eigenfunctions is right at large and blurred at small. So the source's proxy, joined to a
graph, is moved to where its map says, while every neighbourhood only turns (as-rigid-as-possible energy, Sorkine and
Alexa 2007), and then again and again to the nearest points of the target by place, normal and eigenfunctions together,
each time with more trust in the places. Points of the target draw as well, so that no part of it is left over. Pieces
that the map tears off (a hand sent to the other arm) are not believed: they follow the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.nearest_neighbors import NearestNeighbors, spatial_order
from ..geometry.normals import vertex_normals
from ..geometry.spectral import functional_map
from ..landmarks.constraints import LandmarkConstraints, apply_constraints
from ..surface.surface import Surface
from .energy import deformation_graph

TRUST = (0.02, 0.1, 0.3, 1.0)
"""Weight of the places against rigidity, from one round to the next; the first is for the map alone."""

TIGHT = (*TRUST, 3.0)
"""The same where explanations or places are judged by how the source is bent: what does not fit shows as strain."""

ROUNDS = 3
"""How often the nearest points are looked for at each weight."""

SETTLING, STEPS = 12, 2
"""Alternations of turning and moving at first, and after each search."""

NORMAL, SPECTRAL = 0.15, 0.02
"""How much normals and eigenfunctions count in the nearest point, against places per sqrt(area)."""

ALIKE, DIFFERENT, SKETCHED = (0.07, 0.05), (0.03, 0.1), (0.07, 0.0)
"""How much descriptors and curvatures do: where shapes are alike; where they differ, and descriptors tell less; and
where several ways are compared, as curvatures would pull a wrong one into shape as well."""

STRAIN, LITTLE = {"stretch": 16.0, "turn": 2.0}, {"stretch": 0.01, "turn": 0.001}
"""What the logarithm of each kind of strain counts, and how much of it is as good as none."""

NO_LENGTH = 1e-6
"""Added to lengths per sqrt(area), so that they have a logarithm."""


BELIEVED = 0.1
"""Trust above which torn pieces count like others: they have had their chance to find where they belong."""

CANDIDATES = 10_000
"""Vertices of the target that the nearest are looked for among, at most."""


@dataclass(frozen=True, eq=False)
class Registration:
    """The source's proxy on the target.

    Parameters
    ----------
    image
        (P1,) int64: target vertex of each vertex of the source's proxy.
    positions
        (P1, 3) float64: where the bent proxy lies, in the target's coordinates.
    misfit
        (P1,) float64: how far it lies from its image, per sqrt(area).
    rotations
        (P1, 3, 3) float64: how rows of coordinates around each vertex have turned.
    turn
        (P1,) float64: 1 - cosine of the angle between its turned normal and the target's.
    """

    image: np.ndarray
    positions: np.ndarray
    residual: np.ndarray
    rotations: np.ndarray
    normal_deviation: np.ndarray


def register(
    source: Surface,
    target: Surface,
    image: np.ndarray,
    *,
    whole: bool = True,
    rounds: int = ROUNDS,
    ignore_discontinuous: bool = True,
    data_weights: tuple[float, ...] | None = None,
    feature_weights: tuple[float, float] = ALIKE,
    constraints: LandmarkConstraints | None = None,
) -> Registration:
    """Bend the source onto the target.

    Parameters
    ----------
    source, target
        The surfaces.
    image
        (P1,) int64: target vertex of each vertex of the source's proxy, to begin with.
    whole
        Whether the source covers the target. If not, only places and normals count, and the target does not draw.
    rounds
        How often the nearest points are looked for at each weight.
    freeing
        Whether pieces that the map tears off are set free at first, to follow the body.
    trusts
        Weights of the places against rigidity, from one round to the next; None for :data:`TRUST`.
    seen
        Weights of descriptors and curvatures.
    hints
        Pairs that are known: the source is pinned there.
    """
    data_weights = data_weights or TRUST
    centre = target.mesh.vertices.mean(axis=0)
    here, there = source.mesh.vertices / np.sqrt(source.area), (target.mesh.vertices - centre) / np.sqrt(target.area)
    normals1, normals2 = vertex_normals(here, source.mesh.faces)[source.proxy], vertex_normals(there, target.mesh.faces)
    # Nothing is left of the eigenfunctions and descriptors of a part, or of who draws.
    drawers, shared = (target.proxy, target.eigenfunctions.shape[1]) if whole else (target.proxy[:0], 0)
    spectral1 = source.eigenfunctions[source.proxy].astype(np.float64)[:, :shared]
    spectral2 = target.eigenfunctions[:, :shared]
    appearance1, appearance2 = (_appearance(one, feature_weights if whole else (0.0, 0.0)) for one in (source, target))
    some = _candidates(target)
    goals = _features(there[some], normals2[some], spectral2[some], appearance2[some])
    among, drawing = NearestNeighbors(goals), goals[np.searchsorted(some, drawers)]
    beside = spatial_order(here[source.proxy])
    graph = deformation_graph(source)
    point_constraints = None if constraints is None else constraints.point_constraints(source, target, there)
    places, positions, rotations = there[image], there[image], np.empty(0)
    everything = np.ones(len(image), bool)
    continuous = graph.continuous(places) if ignore_discontinuous else everything
    positions, rotations = graph.solve(
        positions, *apply_constraints(point_constraints, places, data_weights[0] * continuous, rotations), SETTLING
    )
    for data_weight in data_weights[1:]:
        for _ in range(rounds):
            transfer = functional_map(spectral1[continuous], spectral2[image[continuous]])
            rotated_normals = np.einsum("ni,nij->nj", normals1, rotations)
            seekers = _features(positions, rotated_normals, spectral1 @ transfer, appearance1[source.proxy])
            image = some[among.nearest(seekers)]
            drawn = NearestNeighbors(seekers, beside).nearest(drawing)
            number = 1 + np.bincount(drawn, minlength=len(image))
            drawing_to = [np.bincount(drawn, axis, len(image)) for axis in there[drawers].T]
            places = (np.stack(drawing_to, axis=1) + there[image]) / number[:, None]
            continuous = (
                graph.continuous(there[image]) if ignore_discontinuous and data_weight <= BELIEVED else everything
            )
            positions, rotations = graph.solve(
                positions, *apply_constraints(point_constraints, places, data_weight * continuous, rotations), STEPS
            )
    rotated_normals = np.einsum("ni,nij->nj", normals1, rotations)
    return Registration(
        image,
        positions * np.sqrt(target.area) + centre,
        np.linalg.norm(positions - there[image], axis=1),
        rotations,
        1 - np.einsum("ij,ij->i", rotated_normals, normals2[image]),
    )


def register_coarsely(
    source: Surface, target: Surface, image: np.ndarray, constraints: LandmarkConstraints | None = None
) -> Registration:
    """:func:`register` in a fraction of the time: good enough to see which of several images is right."""
    return register(
        source, target, image, rounds=1, data_weights=TIGHT, feature_weights=SKETCHED, constraints=constraints
    )


def is_discontinuous(source: Surface, target: Surface, image: np.ndarray) -> bool:
    """Whether a map of the source's proxy to target vertices (P1,) tears pieces off."""
    return not deformation_graph(source).continuous(target.mesh.vertices[image] / np.sqrt(target.area)).all()


def edge_stretches(source: Surface, target: Surface, registration: Registration) -> np.ndarray:
    """Logarithms (E,) of how many times longer the edges of the proxy have become, both surfaces having area 1."""
    start, end = source.proxy_edges.T
    rest, bent = source.mesh.vertices[source.proxy], registration.positions
    before, after = (np.linalg.norm(points[start] - points[end], axis=1) for points in (rest, bent))
    return np.asarray(np.log((after / np.sqrt(target.area) + NO_LENGTH) / (before / np.sqrt(source.area) + NO_LENGTH)))


def stretching(source: Surface, target: Surface, registration: Registration) -> float:
    """How much the edges of the proxy are stretched or pressed: the mean of the logarithm's absolute value."""
    return float(np.abs(edge_stretches(source, target, registration)).mean())


def strain(source: Surface, target: Surface, registration: Registration) -> float:
    """How badly the source is bent, to be compared with another way: what it stretches, and how far normals are off."""
    found = {"stretch": stretching(source, target, registration), "turn": float(registration.normal_deviation.mean())}
    return sum(weight * float(np.log(found[kind] + LITTLE[kind])) for kind, weight in STRAIN.items())


def _appearance(surface: Surface, weights: tuple[float, float]) -> np.ndarray:
    """What tells vertices (n, d) from those beside them, as much as it counts; no column for what does not."""
    descriptor, curvature_features = weights
    kinds = [descriptor * surface.descriptors] if descriptor else []
    kinds += [curvature_features * surface.curvature_features] if curvature_features else []
    return np.hstack([np.empty((len(surface.mesh.vertices), 0), np.float32), *kinds])


def _features(places: np.ndarray, normals: np.ndarray, spectral: np.ndarray, feature_weights: np.ndarray) -> np.ndarray:
    """What points are compared by, (p, 6 + k + d); single precision halves the time of the search."""
    return np.hstack([places, NORMAL * normals, SPECTRAL * spectral, feature_weights]).astype(np.float32)


def oriented_points(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Places and weighted normals (n, 6) of the vertices, to tell the two sides of a thin sheet apart."""
    return np.hstack([vertices, NORMAL * vertex_normals(vertices, faces)])


def _candidates(surface: Surface) -> np.ndarray:
    """Vertices (c,) ascending: all if they are few, else the proxy and an even draw."""
    n = len(surface.mesh.vertices)
    if n <= CANDIDATES:
        return np.arange(n)
    drawn = np.random.default_rng(0).choice(n, CANDIDATES - len(surface.proxy), replace=False)
    return np.union1d(surface.proxy, drawn)
