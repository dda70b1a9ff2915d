"""Names and definitions of the numbers in a report."""

from __future__ import annotations

from typing import Any

from . import summary
from .page import Markup, join, number, tag

MEASURES = {
    "known": "matches with a known true point",
    "mean15": "mean of the first 15, per diameter",
    "mean45": "mean of the first 45, per diameter",
    "first15_close": "pairs with the first 15 all within 3 %",
    "wrong": "pairs with a mean of the first 45 above 0.10",
    "princeton_mean": "mean of all matches, per √area",
    "princeton_within": "matches within 0.05 √area",
    "dense_mean": "dense map: mean, per √area",
    "dense_within": "dense map: points within 0.05 √area",
    "dense_within_far": "dense map: points within 0.10 √area",
    "dense_wrong": "dense map: pairs with a mean above 0.10 √area",
}
"""Names of ``summary.measures`` in tables."""

TITLES = {"direct": "direct", "mirrored": "mirrored", "better": "better of both"}
"""Names of the ground truths of a symmetric shape."""

_SURFACE = {
    "matches": "number of matches",
    **{
        f"coverage_{side}_{name}": f"coverage of the {side}: {title}"
        for side in ("source", "target")
        for name, title in (
            ("mean", "mean distance from a match, per √area"),
            ("largest", "largest distance from a match, per √area"),
            ("evenness", "evenness, 0 to 1"),
        )
    },
    "dense_unmapped": "dense map: ground-truth points without a counterpart",
    "ranking": "rank correlation of confidence and negative error",
}


def surface_name(name: str) -> str:
    """The name of an entry of ``summary.surface_numbers`` in tables."""
    return _SURFACE.get(name, name.replace("_", ": ", 1).replace("_", " "))


_DEFINITIONS = {
    "Error": (
        "Geodesic distance on the target between the matched point and the true one. Per diameter (the paper's "
        "measure): divided by the geodesic diameter of the target, the largest distance between two of its points "
        "(the largest from any of 30 farthest points; it does not depend on the settings of the match). Per √area "
        "(Princeton's): divided by the square root of the target's area. Both have no unit."
    ),
    "Which point is compared": (
        "Each match is compared with the ground-truth point nearest to its source vertex. If only a few landmarks are "
        "known, each landmark is compared with the match whose source is nearest to it: the error of a match is the "
        "mean over its landmarks, and unknown if it has none. The distance between the ground-truth point and the "
        "match's source is part of the error; it is not subtracted."
    ),
    "Direct, mirrored, better of both": (
        "A symmetric shape has two ground truths, since distances alone cannot distinguish left and right. Direct: "
        "against the ground truth of the data set. Mirrored: against the one with left and right exchanged, if the "
        "data set has it. Better of both: for each pair of shapes as a whole, the one with the smaller mean over the "
        "first 45 matches (for dense maps, over all points)."
    ),
    "Means and shares": (
        "Matches are in order of confidence, highest first. If a pair has fewer than 15 or 45 matches, the mean is "
        "over all of them. In means over several pairs each pair has the same weight. Matches without a known true "
        "point are ignored. A pair with fewer than 15 matches does not count as having the first 15 within 3 %. "
        "Failed pairs are not part of any mean or share."
    ),
    "Wrong pairs": (
        "Pairs with a mean of the first 45 above 0.10 of the diameter. That is more than the resolution of the samples "
        "explains, so most likely the whole alignment is wrong (front and back swapped, or one limb and another)."
    ),
    "Cumulative errors": (
        "For each error x, the share of points with an error of at most x √area, averaged over the pairs. Sparse: the "
        "points are the matches. Dense: the points are all ground-truth points."
    ),
    "Coverage": (
        "How the matched points are distributed over each surface. Mean and largest distance (along edges) of the "
        "surface from the nearest match, per √area. Evenness: each match has a cell, the part of the surface nearest "
        "to it, with the share a of the area; exp(−Σ a log a) / number of matches is 1 if all cells are equal."
    ),
    "Confidence": (
        "The matches of all pairs are sorted into ten equal bins by their confidence. The table shows the share of "
        "matches in each bin within 5 % of the target's diameter. Confidence is useful if the share rises with it. "
        "Rank correlation: Spearman's, between confidence and negative error within a pair; 1 if the most confident "
        "matches are the most accurate, 0 if confidence carries no information."
    ),
}


def definitions(info: dict[str, Any], records: list[dict[str, Any]]) -> Markup:
    """The list of definitions, and the geodesics by which errors are measured."""
    entries = {**_DEFINITIONS, "Geodesic distances of the errors": geodesics(info, records)}
    return tag(
        "dl", *(join([tag("dt", name), tag("dd", text)]) for name, text in entries.items()), class_="definitions"
    )


def geodesics(info: dict[str, Any], records: list[dict[str, Any]]) -> str:
    """Which geodesic distances the errors are, and how much the heat method differs from exact ones."""
    if info["scoring"].get("geodesics") != "exact":
        return (
            "Errors are distances by the heat method, which is fast and has an error of one or two percent of the "
            "distance. This run has no exact distances to compare them with; measure with exact geodesics to see the "
            "difference."
        )
    differences = [record["heat_difference"] for record in summary.done(records)]
    known = [value for value in differences if value is not None]
    if not known:
        return "Errors are exact geodesic distances on the triangles of the mesh."
    return (
        "Errors are exact geodesic distances on the triangles of the mesh. By the heat method the same errors (of the "
        f"matches, or of a sample of a dense map) differ by {number(summary.mean(known), 5)} of the diameter on "
        f"average, and by {number(max(known), 5)} in the pair where they differ most."
    )
