"""One alignment of two surfaces, and the source registered along it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from .._core.display import one_line
from .._core.threads import map_threads
from ..landmarks.constraints import LandmarkConstraints
from ..registration.parameters import FeatureWeights
from ..registration.sparse import Registration, is_discontinuous, register
from ..surface.surface import Surface
from .coarse_map import balanced_targets, refined_targets
from .evidence import evidence, log_odds
from .parameters import AlignmentParameters, Evidence

by_cost = attrgetter("cost")


@dataclass(frozen=True, eq=False)
class Alignment:
    """One way to see the target as the source in another pose.

    Parameters
    ----------
    image
        (P1,) int64: target vertex of each vertex of the source's proxy.
    cost_terms
        Terms of its cost by name, 0 is perfect.
    cost
        Their weighted sum; the alignments of least cost are registered.
    share
        Fraction of the best triplets that belong to its cluster.
    registration
        The source registered along it, if that has been done.
    shapes_differ
        Whether the shapes differ in more than their pose; then the registration, if there is one, is that of
        :func:`register_iteratively`.
    constraints
        Landmarks, for registration.
    probability
        That it is right, or one of its order; 0 if it was not registered for the choice.
    order
        How many alignments look the same, this one among them, by a symmetry of the shapes; 1 if it is alone.
    evidence
        What that comes from; None if it was not registered for the choice.
    """

    image: np.ndarray
    cost_terms: dict[str, float]
    cost: float
    share: float
    registration: Registration | None = None
    shapes_differ: bool = False
    constraints: LandmarkConstraints | None = None
    probability: float = 0.0
    order: int = 1
    evidence: Evidence[float] | None = None

    def __repr__(self) -> str:
        return one_line(self)

    def feature_weights(self, parameters: AlignmentParameters) -> FeatureWeights:
        """Weights of features when the source is registered along it."""
        return parameters.registration.features(self.shapes_differ)

    def initial_targets(
        self, source: Surface, target: Surface, image: np.ndarray, parameters: AlignmentParameters
    ) -> np.ndarray:
        """Target vertices (P1,) that the source's proxy moves to at first, from a map of it (P1,).

        Where shapes differ, targets that leave no part of the target over are better than targets finer than its proxy.
        """
        if self.shapes_differ:
            return balanced_targets(source, target, image, parameters.coarse_map)
        return refined_targets(source, target, image, source.proxy, parameters.coarse_map)

    def registered(
        self, source: Surface, target: Surface, parameters: AlignmentParameters, jobs: int | None = 1
    ) -> Registration:
        """The source registered to the target along this alignment."""
        if self.registration is not None:
            return self.registration
        image = self.initial_targets(source, target, self.image, parameters)
        # A piece that is torn off by a few wrong points beside it had better keep its data term: both ways are tried.
        torn = is_discontinuous(source, target, image, parameters.registration.discontinuity)
        ways = (True, False) if torn else (True,)
        registrations = map_threads(
            lambda i, _: register(
                source,
                target,
                image,
                parameters.registration,
                weights=self.feature_weights(parameters),
                ignore_discontinuous=ways[i],
                constraints=self.constraints,
            ),
            len(ways),
            jobs,
            None,
        )
        return likeliest(source, target, registrations, parameters)


def likeliest(
    source: Surface, target: Surface, registrations: list[Registration], parameters: AlignmentParameters
) -> Registration:
    """The registration that the evidence is for."""
    if len(registrations) == 1:
        return registrations[0]
    found = [evidence(source, target, one) for one in registrations]
    return registrations[int(log_odds(found, parameters.choice).argmax())]


def register_iteratively(
    source: Surface,
    target: Surface,
    alignment: Alignment,
    parameters: AlignmentParameters,
    jobs: int | None = 1,
    first: Registration | None = None,
) -> Registration:
    """The source registered along an alignment iteratively, each time from the result of the last.

    A map that began badly improves, and the median of their positions evens out errors along limbs. The first
    registration may be given.
    """
    if alignment.shapes_differ and alignment.registration is not None:
        return alignment.registration
    selection, weights = parameters.selection, alignment.feature_weights(parameters)
    registrations = [first or alignment.registered(source, target, parameters, jobs)]
    for _ in range(selection.repeats):
        image = alignment.initial_targets(source, target, registrations[-1].image, parameters)
        registrations.append(
            register(source, target, image, parameters.registration, weights=weights, constraints=alignment.constraints)
        )
    # Where shapes differ, the registration that strains least is not the right one.
    best = registrations[-1] if alignment.shapes_differ else likeliest(source, target, registrations, parameters)
    positions = [best.positions, *(one.positions for one in registrations[1:] or registrations)]
    return replace(best, positions=np.median(positions, axis=0))
