"""The constants of finding a part on a whole."""

from __future__ import annotations

from dataclasses import dataclass

from ..._core.parameters import AREA, HAND, parameter

SCRIPT = "fitted by `benchmarks/fit_partial.py`, before sizes were corrected by distances nearby"


@dataclass(frozen=True)
class PartialParameters:
    """Constants of :func:`mobius_match.matching.partial.part.locate_parts`.

    Lengths are per sqrt(area) of the whole, once the part has its size on it.
    """

    # Which surfaces may be parts, and how large they are then.
    opening: float = parameter(
        0.15, "length of a rim above which a surface may be a part, per sqrt(area) of its own", origin=HAND
    )
    smallest_share: float = parameter(
        0.1, "share of the whole's area below which a part is not looked for", origin=HAND
    )
    size_step: float = parameter(1.2, "ratio of one size of the part that is tried to the next", origin=HAND)

    # Triplets of samples.
    allowed_share: float = parameter(
        0.35, "share of the pairs of samples that triplets may use, those of the most similar curvature", origin=HAND
    )
    triplets: int = parameter(20_000, "triplets that are evaluated at the final size", origin=HAND)
    sizing_triplets: int = parameter(2_000, "triplets that are evaluated at each size that is tried", origin=HAND)
    best_share: float = parameter(
        0.03, "share of the triplets, the best ones, that alignments and the fit at a size come from", origin=HAND
    )
    points: tuple[int, int] = parameter(
        (50, 250), "points of the part and of the whole that a triplet is evaluated at", origin=HAND
    )
    error_scale: float = parameter(
        0.05, "error at which a point that a triplet matches counts 1 / e", unit=AREA, origin=HAND
    )

    # Error of matching two points.
    curvature_weight: float = parameter(
        0.033, "error that a difference in curvature by one standard deviation equals", unit=AREA, origin=HAND
    )
    direction_weight: float = parameter(
        0.1, "error that a difference by 1 in the sine or cosine between two paths equals", unit=AREA, origin=HAND
    )
    error_cap: float = parameter(
        0.15, "largest error of one distance: shortest paths may run through what is missing", unit=AREA, origin=HAND
    )
    landmarks: int = parameter(80, "landmarks that a map of the part follows from", origin=HAND)
    landmark_distance: float = parameter(
        0.1, "s in the weight 1 / (d + s) of a landmark at distance d", unit=AREA, origin=HAND
    )

    # Alignments of the part with the whole, and their cost.
    distinct: float = parameter(
        0.05, "distance between two images of a point from which they are different ones", unit=AREA, origin=HAND
    )
    registered_coarsely: int = parameter(12, "groups of triplets along which the part is registered", origin=HAND)
    registered: int = parameter(4, "of these, how many are registered once more from their best landmarks", origin=HAND)
    rival_ratio: float = parameter(
        1.5, "multiple of the least cost up to which an alignment is a rival of the best", origin=HAND
    )
    angle_cost: float = parameter(
        2.0, "weight of the angles between paths and between normals in the cost", origin=HAND
    )
    stretch_cost: float = parameter(3.0, "weight of the edges' logarithmic stretch in the cost", origin=HAND)
    residual_cost: float = parameter(20.0, "weight of the residual in the cost", unit=f"1/{AREA}", origin=HAND)

    # Part or whole.
    credible_cost: float = parameter(1.95, "cost above which the part does not belong to the whole", origin=HAND)
    same_error: float = parameter(
        0.1,
        "mean difference of the logarithms of distances up to which two surfaces with openings are wholes, and no part "
        "is looked for",
        origin="by hand: analytic discs cut to 84 % and the shipped person cut to 85 % have up to 0.08, discs cut to "
        "67 % and halves of the person 0.14 and more",
    )
    part_advantage: float = parameter(
        2.5,
        "a surface is taken for a part where two wholes cost so many times as much",
        origin="by hand: shapes with small holes or without a limb have up to 2.3, halves 3.6 and more",
    )
    rim_gap: float = parameter(
        0.1,
        "mean distance between the rims of two surfaces up to which they coincide",
        unit=AREA,
        origin="the distance between 100 samples",
    )
    incomplete_factor: float = parameter(
        0.5, "confidence is multiplied by this where each surface may lack what the other has", origin=HAND
    )
    incomplete_cost: float = parameter(
        3.5,
        "cost of a map between two surfaces with openings above which each lacks a part of the other",
        origin=HAND,
    )

    # Probability of a match.
    close_margin: float = parameter(
        0.05, "difference in cost at which a rival counts 1 / e, and below which it is reported", origin=HAND
    )
    boundary_margin: float = parameter(
        0.035, "distance from the cut below which no match is reported", unit=AREA, origin=HAND
    )
    offset: float = parameter(-3.93, "offset of the logistic regression", origin=SCRIPT)
    distance_slope: float = parameter(-0.83, "slope for the mean error of the distances", origin=SCRIPT)
    residual_slope: float = parameter(-0.78, "slope for the residual", origin=SCRIPT)
    boundary_slope: float = parameter(0.80, "slope for the distance from the cut", origin=SCRIPT)
    stretch_slope: float = parameter(-0.81, "slope for the edges' logarithmic stretch", origin=SCRIPT)
    cost_slope: float = parameter(-4.95, "slope for the cost of the alignment", origin=SCRIPT)
