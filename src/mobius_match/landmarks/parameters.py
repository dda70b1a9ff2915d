"""Constants of the method that concern landmarks."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.parameters import AREA, HAND, parameter


@dataclass(frozen=True)
class LandmarkParameters:
    """How known pairs act on a match."""

    displacement_tolerance: float = parameter(
        0.2,
        "distance from its counterpart up to which a map may send a landmark without an additional cost",
        unit=AREA,
        origin=HAND + ": coarse maps are smooth, and a user's landmarks need not be exact",
    )
    weight: float = parameter(
        10.0,
        "data weight of landmarks in registration, where the rigidity term has weight 1",
        origin=HAND + ": larger than any weight of other points, so that the surface passes through the landmarks",
    )
    inconsistency: float = parameter(
        0.4,
        "median difference between a landmark's distances to the others on both surfaces, above which users are warned",
        unit=AREA,
        origin=HAND,
    )
    max_guides: int = parameter(
        60,
        "number of landmarks whose distances guide all other points; registration is constrained at all of them",
        origin="bounds time and memory, which grow with it",
    )


DEFAULT = LandmarkParameters()
