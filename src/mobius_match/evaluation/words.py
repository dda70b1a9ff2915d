"""What the numbers of a report mean, in words."""

from __future__ import annotations

from typing import Any

from . import summary
from .page import Markup, join, number, tag

MEASURES = {
    "known": "matches whose true point is known",
    "mean15": "mean of the first 15, per diameter",
    "mean45": "mean of the first 45, per diameter",
    "first15_close": "pairs whose first 15 all lie within 3 %",
    "wrong": "pairs with a mean of the first 45 above 0.10",
    "princeton_mean": "mean of all matches, per √area",
    "princeton_within": "matches within 0.05 √area",
    "dense_mean": "dense map: mean, per √area",
    "dense_within": "dense map: points within 0.05 √area",
    "dense_within_far": "dense map: points within 0.10 √area",
    "dense_wrong": "dense map: pairs with a mean above 0.10 √area",
}
"""Names of ``summary.measures`` as a table shows them."""

TITLES = {"direct": "direct", "mirrored": "mirrored", "better": "better of both"}

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
    "dense_unmapped": "dense map: points of the truth that it leaves out",
    "ranking": "rank correlation of confidence and minus error",
}


def surface_name(name: str) -> str:
    """The name of an entry of ``summary.surface_numbers`` as a table shows it."""
    return _SURFACE.get(name, name.replace("_", ": ", 1).replace("_", " "))


_DEFINITIONS = {
    "Error": (
        "Geodesic distance on the target from the point that was found to the true one. Per diameter (the paper's "
        "measure): divided by the geodesic diameter of the target, the largest distance between two of its points "
        "(the farthest that a search from 30 well-spread points finds; no setting of the matching changes it). Per "
        "√area (Princeton's): divided by the square root of the target's area. Both are pure numbers."
    ),
    "Which point is compared": (
        "A match with the known point nearest to its source vertex. Where only a few landmarks are known, each of them "
        "with the match whose source is nearest to it: a match has the mean error of its landmarks, or none. What lies "
        "between the known point and the match's source counts as error; nothing is subtracted."
    ),
    "Direct, mirrored, better of both": (
        "A symmetric shape has two truths, and distances alone cannot tell left from right. Direct: against the truth "
        "of the data set. Mirrored: against the one with left and right exchanged, where the data set has it. Better "
        "of both: for each pair of shapes as a whole, whichever of the two has the smaller mean over the first 45 "
        "matches (dense maps: over all points)."
    ),
    "Means and shares": (
        "Matches are taken in order of confidence, highest first. The mean of the first 15 or 45 is over those there "
        "are, if there are fewer. Over several pairs each pair weighs the same. Matches whose true point the data set "
        "does not tell are left out. A pair with fewer than 15 matches is not one whose first 15 all lie within 3 %. "
        "Failed pairs are in no mean and no share."
    ),
    "Wrong pairs": (
        "A mean of the first 45 above 0.10 of the diameter: more than the resolution of the samples explains, so that "
        "most likely the whole pair was matched by a wrong explanation (front for back, or one limb for another)."
    ),
    "Cumulative errors": (
        "For each error x the share of points with an error of at most x √area: the mean of the curves of the pairs. "
        "Sparse: the points are the matches. Dense: all points whose truth is known."
    ),
    "Coverage": (
        "How the matched points lie on each of the two surfaces. Mean and largest distance (along edges) of the "
        "surface from the nearest match, per √area. Evenness: each match has the part of the surface nearest to it, "
        "the share a of the area; exp(−Σ a log a) / number of matches is 1 if all parts are equal."
    ),
    "Confidence": (
        "Matches of all pairs are put into ten equal bins by their confidence; a bin shows the share of its matches "
        "within 5 % of the target's diameter. Confidence is useful if the shares rise with it. Rank correlation: "
        "Spearman's, of confidence and minus the error (better of both) within a pair; 1 if the surest matches are the "
        "best, 0 if confidence tells nothing."
    ),
}


def definitions(info: dict[str, Any], records: list[dict[str, Any]]) -> Markup:
    """The list of definitions, and what the geodesics of the scoring are."""
    entries = {**_DEFINITIONS, "Geodesic distances of the scoring": geodesics(info, records)}
    return tag("dl", *(join([tag("dt", name), tag("dd", text)]) for name, text in entries.items()), class_="words")


def geodesics(info: dict[str, Any], records: list[dict[str, Any]]) -> str:
    """Which distances the errors are, and how far the other kind would be from them."""
    if info["scoring"].get("geodesics") != "exact":
        return (
            "Errors are distances by the heat method, which is quick and off by a percent or two of the distance. This "
            "run holds no exact distances to compare them with; score with --geodesics exact to see the difference."
        )
    differences = [record["heat_difference"] for record in summary.done(records)]
    known = [value for value in differences if value is not None]
    if not known:
        return "Errors are exact geodesic distances on the triangles of the mesh."
    return (
        "Errors are exact geodesic distances on the triangles of the mesh. The same errors by the heat method "
        f"(--geodesics heat), over matches, or a sample of a dense map, differ by "
        f"{number(summary.mean(known), 5)} of the diameter on average, and by {number(max(known), 5)} in the pair "
        "where they differ most."
    )
