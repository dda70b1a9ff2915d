"""Sparse registration: the source's proxy deformed to the target, along an initial map.

Beyond the paper. A map of few eigenfunctions is right at large and blurred at small. The proxy, joined to a graph,
first moves to where the map sends it, as rigidly as possible, and is then deformed to the closest points of the target
with a rising data weight (:mod:`.deform`). Pieces that the map tears off, such as a hand sent to the other arm, have no
data term at first: they follow the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core.display import one_line
from ..geometry.nearest_neighbors import spatial_order
from ..geometry.normals import vertex_normals
from ..geometry.spectral import functional_map
from ..landmarks.constraints import LandmarkConstraints, apply_constraints
from ..surface.surface import Surface
from .deform import State, Target, deform
from .energy import deformation_graph
from .features import appearance, features, rotated_normals
from .parameters import FeatureWeights, RegistrationParameters, Schedule


@dataclass(frozen=True, eq=False)
class Registration:
    """The source's proxy on the target.

    Parameters
    ----------
    image
        (P1,) int64: target vertex of each vertex of the source's proxy.
    positions
        (P1, 3) float64: where the deformed proxy lies, in the target's coordinates.
    residual
        (P1,) float64: its distance from its image, per sqrt(area).
    rotations
        (P1, 3, 3) float64: how rows of coordinates around each vertex have turned.
    normal_deviation
        (P1,) float64: 1 - cosine of the angle between its rotated normal and the target's.
    """

    image: np.ndarray
    positions: np.ndarray
    residual: np.ndarray
    rotations: np.ndarray
    normal_deviation: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)


def register(
    source: Surface,
    target: Surface,
    image: np.ndarray,
    parameters: RegistrationParameters,
    *,
    schedule: Schedule | None = None,
    weights: FeatureWeights | None = None,
    whole: bool = True,
    ignore_discontinuous: bool = True,
    constraints: LandmarkConstraints | None = None,
) -> Registration:
    """Deform the source's proxy to the target.

    Parameters
    ----------
    source, target
        The surfaces.
    image
        (P1,) int64: target vertex of each vertex of the source's proxy, to begin with.
    parameters
        The constants.
    schedule, weights
        None for those of a full registration of similar shapes, or of a part.
    whole
        Whether the source covers the target. If not, the target does not pull, and eigenfunctions are not compared.
    ignore_discontinuous
        Whether pieces that the map tears off have no data term at first.
    constraints
        Landmarks: the source is pinned there.
    """
    schedule = schedule or parameters.full
    weights = weights or (parameters.features(False) if whole else parameters.partial)
    centre, scale = target.mesh.vertices.mean(axis=0), target.scale
    rest, there = source.mesh.vertices / source.scale, (target.mesh.vertices - centre) / scale
    normals1 = vertex_normals(rest, source.mesh.faces)[source.proxy]
    normals2 = vertex_normals(there, target.mesh.faces)
    n_spectral = target.eigenfunctions.shape[1] if whole else 0
    spectral1 = source.eigenfunctions[source.proxy].astype(np.float64)[:, :n_spectral]
    spectral2 = target.eigenfunctions[:, :n_spectral]
    appearance1, appearance2 = appearance(source, weights)[source.proxy], appearance(target, weights)

    def query(state: State) -> np.ndarray:
        on_target = functional_map(spectral1[state.continuous], spectral2[state.image[state.continuous]])
        normals = rotated_normals(normals1, state.rotations)
        return features(state.positions, normals, spectral1 @ on_target, appearance1, weights)

    graph = deformation_graph(source)
    points = None if constraints is None else constraints.point_constraints(source, target, there)
    initial = there[image]
    if ignore_discontinuous:
        continuous = graph.continuous(initial, parameters.discontinuity)
    else:
        continuous = np.ones(len(image), bool)
    positions, rotations = graph.solve(
        initial,
        *apply_constraints(points, initial, parameters.initial_weight * continuous, np.empty(0)),
        parameters.initial_steps,
    )
    state = deform(
        graph,
        State(positions, rotations, image, continuous),
        query,
        Target(
            there,
            features(there, normals2, spectral2, appearance2, weights),
            target.proxy if whole else target.proxy[:0],
        ),
        schedule,
        order=spatial_order(rest[source.proxy]),
        constraints=points,
        release_weight=parameters.first_weight if ignore_discontinuous else 0.0,
        discontinuity=parameters.discontinuity,
    )
    normals = rotated_normals(normals1, state.rotations)
    return Registration(
        state.image,
        state.positions * scale + centre,
        np.linalg.norm(state.positions - there[state.image], axis=1),
        state.rotations,
        1 - np.einsum("ij,ij->i", normals, normals2[state.image]),
    )


def is_discontinuous(source: Surface, target: Surface, image: np.ndarray, tolerance: float) -> bool:
    """Whether a map of the source's proxy to target vertices (P1,) tears pieces off; tolerance per sqrt(area)."""
    images = target.mesh.vertices[image] / target.scale
    return not deformation_graph(source).continuous(images, tolerance).all()
