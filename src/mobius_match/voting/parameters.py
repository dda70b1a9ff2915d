"""The constants of guided voting; docs/method.md has the formulas. The paper's own voting has settings only."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.parameters import AREA, HAND, parameter


@dataclass(frozen=True)
class VotingParameters:
    """How triplets are drawn and weighed where geodesic distances guide them."""

    least_spread: float = parameter(
        0.3, "least distance between the three source samples of a triplet", unit=AREA, origin=HAND
    )
    length_tolerance: float = parameter(
        0.25,
        "largest relative difference of corresponding distances within a triplet; also the largest mean difference of "
        "two samples' distances from landmarks",
        origin=HAND,
    )
    centrality_tolerance: float = parameter(
        0.30,
        "largest relative difference of the average geodesic distances of two samples that may be matched in a triplet",
        origin=HAND,
    )
    most_widening: int = parameter(
        8, "tolerances are doubled up to this factor until half of the draws succeed", origin=HAND
    )
    pair_scale: float = parameter(
        0.15, "difference of distances at which the weight of a pair has fallen to 1/e", unit=AREA, origin=HAND
    )
    weight_power: float = parameter(
        6.0, "power of the sum of a triplet's pair weights that its votes are worth", origin=HAND
    )
    similarity_width: float = parameter(
        2.0,
        "width of the similarity of descriptors, in medians of the difference to the most similar sample; infinite: "
        "descriptors are not compared",
        origin=HAND,
    )
    settled_share: float = parameter(
        0.98,
        "voting ends when this share of the leading votes is for the same samples as a round before",
        origin=HAND,
    )
    kept: int = parameter(300, "best triplets that are kept, for candidate alignments", origin=HAND)
