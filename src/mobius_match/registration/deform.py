"""The loop of non-rigid registration, sparse and dense: closest points, then the energy, with a rising data weight.

As in Amberg et al. (2007) and Li et al. (2008), with rigidity in place of their smoothness: targets are the closest
points in a space of features (position, normal, and what tells points apart), looked for both ways, so that no part of
the target is left without a counterpart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .._core.display import one_line
from ..geometry.nearest_neighbors import NearestNeighbors
from ..landmarks.constraints import PointConstraints, apply_constraints
from .energy import DeformationGraph
from .parameters import Schedule


@dataclass(frozen=True, eq=False)
class State:
    """The source while it is deformed.

    Parameters
    ----------
    positions
        (p, 3) of its points, in the target's units per sqrt(area).
    rotations
        (p, 3, 3): how rows of coordinates around each point have turned.
    image
        (p,) int64: the target's vertex that is closest to each point.
    continuous
        (p,) bool: the points whose image is not torn off from its surroundings.
    """

    positions: np.ndarray
    rotations: np.ndarray
    image: np.ndarray
    continuous: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Target:
    """What the source is deformed to.

    Parameters
    ----------
    positions
        (n2, 3) of the target's vertices, per sqrt(area).
    features
        (n2, k) of these.
    pulling
        (r,) int64: the vertices that pull the point of the source that is closest to them.
    """

    positions: np.ndarray
    features: np.ndarray
    pulling: np.ndarray

    def __repr__(self) -> str:
        return one_line(self)


def deform(
    graph: DeformationGraph,
    state: State,
    query: Callable[[State], np.ndarray],
    target: Target,
    schedule: Schedule,
    *,
    order: np.ndarray,
    constraints: PointConstraints | None = None,
    release_weight: float = 0.0,
    discontinuity: float = np.inf,
) -> State:
    """Deform the source to the target.

    Parameters
    ----------
    graph
        The source's points at rest.
    state
        Where they are to begin with.
    query
        Gives the features (p, k) of the source's points in a state.
    target
        The target.
    schedule
        Data weights, searches and steps.
    order
        Spatial order of the source's points; see :func:`mobius_match.geometry.nearest_neighbors.spatial_order`.
    constraints
        Points with known places.
    release_weight
        Up to this data weight points whose image is discontinuous have no data term: they follow their surroundings.
    discontinuity
        See :meth:`.DeformationGraph.continuous`.
    """
    closest = NearestNeighbors(target.features)
    pulling = target.features[target.pulling]
    pulled_to = target.positions[target.pulling]
    size = len(state.positions)
    for weight in schedule.data_weights:
        for _ in range(schedule.rounds):
            features = query(state)
            image = closest.nearest(features)
            targets = target.positions[image]
            if len(pulling):
                # Each point goes to the mean of its closest point and of all that it is the closest to.
                pulled = NearestNeighbors(features, order).nearest(pulling)
                number = 1 + np.bincount(pulled, minlength=size)
                sums = np.stack([np.bincount(pulled, axis, size) for axis in pulled_to.T], axis=1)
                targets = (sums + targets) / number[:, None]
            if weight <= release_weight:
                continuous = graph.continuous(target.positions[image], discontinuity)
            else:
                continuous = np.ones(size, bool)
            weights = weight * continuous
            positions, rotations = graph.solve(
                state.positions, *apply_constraints(constraints, targets, weights, state.rotations), schedule.steps
            )
            state = replace(state, positions=positions, rotations=rotations, image=image, continuous=continuous)
    return state
