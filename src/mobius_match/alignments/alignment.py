"""Several explanations of one pair of surfaces, and the choice between them.

Beyond the paper. On shapes that are nearly symmetric, or far from isometric, a wrong explanation (front taken for
back, head for feet) can gain more votes than the right one. The best triplets are grouped by where they send the
surface; each group's matches are extended to a map of the whole surface by spectral upsampling (Melzi et al. 2019) that
leaves no part of the target over, and the maps are compared by what the votes do not see (`evidence.py`). Where none
fits well, the ends of limbs make triplets of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter

import numpy as np

from .._core.threads import map_threads
from ..landmarks.constraints import LandmarkConstraints
from ..registration.register import ALIKE, DIFFERENT, Registration, is_discontinuous, register
from ..surface.surface import Surface
from .coarse_map import balanced_targets, refined_targets
from .cost import registration_cost

cost_of = attrgetter("cost")


AGAIN, LAST, TOGETHER = 4, 3, 0.05
"""How often the proxy is bent again, over how many of the last its positions are averaged, and how far from the best,
per sqrt(area), one counts."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """One way to see the target as the source in another pose.

    Parameters
    ----------
    image
        (P1,) int64: target vertex of each vertex of the source's proxy.
    evidence
        How badly it fits, by kind: 0 is perfect; "strain", where it was contested, against that of the first.
    badness
        The weighted sum of the evidence; the smallest wins.
    share
        The part of the best triplets that tell this explanation.
    registration
        The source bent along it, if that has been done.
    differ
        Whether the shapes differ much; then the registration, if there is one, is that of
        :func:`register_iteratively`.
    hints
        Pairs that are known, for bending.
    """

    image: np.ndarray
    cost_terms: dict[str, float]
    cost: float
    share: float
    registration: Registration | None = None
    shapes_differ: bool = False
    constraints: LandmarkConstraints | None = None

    @property
    def feature_weights(self) -> tuple[float, float]:
        """What descriptors and curvatures count when the source is bent along it."""
        return DIFFERENT if self.shapes_differ else ALIKE

    def initial_targets(self, source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
        """Target vertices (P1,) that the source's proxy is drawn to at first, from a map of it (P1,).

        Where shapes differ, what leaves nothing of the target over is better than what is finer than its proxy.
        """
        if self.shapes_differ:
            return balanced_targets(source, target, image)
        return refined_targets(source, target, image, source.proxy)

    def registered(self, source: Surface, target: Surface, jobs: int | None = 1) -> Registration:
        """The source bent onto the target along this explanation."""
        if self.registration is not None:
            return self.registration
        image = self.initial_targets(source, target, self.image)
        # A piece that was torn off by a few wrong points beside it is better believed.
        ways = (True, False) if is_discontinuous(source, target, image) else (True,)
        found = map_threads(
            lambda i, _: register(
                source,
                target,
                image,
                ignore_discontinuous=ways[i],
                feature_weights=self.feature_weights,
                constraints=self.constraints,
            ),
            len(ways),
            jobs,
            None,
        )
        return found[0] if len(found) == 1 else min(found, key=partial(registration_cost, source, target))


def register_iteratively(
    source: Surface,
    target: Surface,
    alignment: Alignment,
    jobs: int | None = 1,
    initial_targets: Registration | None = None,
) -> Registration:
    """The source's proxy bent along an explanation again and again, each time from where it had come to lie.

    A map that began badly gets better so, and what a single one is off along a limb averages out. The first time may
    have been ``initial_targets``.
    """
    if alignment.shapes_differ and alignment.registration is not None:
        return alignment.registration
    found = [initial_targets or alignment.registered(source, target, jobs)]
    for _ in range(AGAIN):
        image = alignment.initial_targets(source, target, found[-1].image)
        found.append(
            register(
                source, target, image, feature_weights=alignment.feature_weights, constraints=alignment.constraints
            )
        )
    # Where shapes differ, what is strained least is not what is right.
    best = found[-1] if alignment.shapes_differ else min(found, key=partial(registration_cost, source, target))
    places = np.stack([best.positions, *(one.positions for one in found[-LAST:])])
    near = np.linalg.norm(places - best.positions, axis=2) <= TOGETHER * np.sqrt(target.area)
    return replace(best, positions=np.einsum("kp,kpd->pd", near, places) / near.sum(axis=0)[:, None])
