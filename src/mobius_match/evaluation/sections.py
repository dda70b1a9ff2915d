"""The sections of a report: each function makes a piece of HTML from the records of a run."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import MobiusError
from ..mesh import as_mesh
from ..results.correspondence import Correspondence
from . import figures, summary
from .glossary import MEASURES, TITLES, surface_name
from .page import Markup, figure, join, number, percent, picture, setting, table, tag, tiles, without_empty

COLUMNS = 60
"""Number of correspondences in the curves, as in the paper."""
MAX_COLUMNS = 120
"""Maximum number of correspondences in the error matrix."""
WORST = 4
"""Number of pairs that are drawn."""
Records = list[dict[str, Any]]


def measure(name: str, value: float) -> str:
    """A value of ``summary.headline`` as text."""
    share = name.endswith(("close", "within", "within_far"))
    return percent(value) if share else number(value, 1 if name == "known" else 3)


def head(info: dict[str, Any], records: Records, variants: Sequence[str]) -> Markup:
    """The headline numbers."""
    finished = summary.done(records)
    layout = info["dataset"].get("layout")
    about = f"Layout of the data: {layout}. " if layout else ""
    total = summary.n_cases(info, records)
    about += f"{total - len(records)} pairs are not processed yet. " if total > len(records) else ""
    shown = [("pairs done", f"{len(finished)} of {total}")]
    if finished:
        direct = summary.headline(records, "direct")
        names = [name for name in MEASURES if not name.startswith(("princeton", "known"))]
        shown += [(MEASURES[n], measure(n, direct[n])) for n in names if direct[n] == direct[n]]
        matches = summary.surface_numbers(records)["matches"]
        shown += [("matches per pair", number(matches, 1))] if matches == matches else []
        about += "Errors are against the direct ground truth" + (
            "; mirrored and better of both are below." if variants[1:] else "."
        )
    return join([tag("p", about, class_="quiet"), tiles(shown)])


def failures(info: dict[str, Any], records: Records) -> Markup:
    """The pairs that failed, with their error messages."""
    failed = [record for record in records if record["status"] != "done"]
    if not failed:
        return Markup("")
    rows = [(record["name"], summary.message(record, info)) for record in failed]
    text = f"{len(failed)} of {len(records)} pairs failed; they are not part of the numbers below."
    return tag("div", tag("p", text), table("Failed pairs", ("pair", "message"), rows, "text"), class_="alert")


def errors(records: Records, variants: Sequence[str]) -> Markup:
    """The measures, with a column for each ground truth, and the numbers that are no errors."""
    columns = [summary.headline(records, variant) for variant in variants]
    rows: list[list[str]] = [["pairs with this ground truth", *(number(column["pairs"]) for column in columns)]]
    for name, title in MEASURES.items():
        if any(column[name] == column[name] and column["pairs"] for column in columns):
            rows.append([title, *(measure(name, column[name]) for column in columns)])
    errors_table = table("Means over pairs", ("", *(TITLES[v] for v in variants)), rows, "prose")
    surface = summary.surface_numbers(records)
    surface.pop("heat_difference")
    others = [
        (surface_name(name), number(value, 1 if value > 1 else 3)) for name, value in surface.items() if value == value
    ]
    return tag(
        "div", errors_table, table("Other numbers, means over pairs", ("", "value"), others, "prose"), class_="grid"
    )


def paper(records: Records, variants: Sequence[str], files: dict[str, bytes]) -> list[Markup]:
    """The error matrix, the curves of the first 60 matches, and the histogram of their errors."""
    finished = summary.done(records)
    shown = summary.distinct_variants(records, variants)
    width = min(max(len(record["pairs"]) for record in finished), MAX_COLUMNS)
    panels = {TITLES[v]: summary.matrix(finished, v, width) for v in shown}
    names, groups = [r["name"] for r in finished], [r["category"] for r in finished]
    marks = (summary.FEW, summary.MANY)
    matrix = figures.draw(figures.error_matrix, names, groups, panels, marks)
    first = figures.draw(figures.first_matches, {t: p[:, :COLUMNS] for t, p in panels.items()}, shown)
    return [
        figure(
            files,
            "error-matrix",
            matrix,
            f"Matrix of {len(names)} rows (pairs) and {width} columns (correspondences), coloured by error.",
            "One row per pair, one column per correspondence in order of confidence. Light is accurate, dark is wrong. "
            "Horizontal lines separate categories; dashed lines mark the first 15 and the first 45."
            + (" Direct is the better of both in every pair." if variants[1:] and not shown[1:] else ""),
        ),
        figure(
            files,
            "first-60",
            first,
            "Left: mean and median error of the k-th correspondence. Right: histogram of the errors.",
            f"The most confident {COLUMNS} correspondences. Left: error of the k-th, mean and median over the pairs; "
            "the thin line is the paper's 3 %. Right: distribution of all these errors.",
        ),
    ]


def cumulative(records: Records, variants: Sequence[str], files: dict[str, bytes]) -> Markup:
    """Cumulative error curves (Princeton), of the matches and of the dense maps."""
    panels = {}
    for title, dense in (("matches (sparse)", False), ("dense map", True)):
        lines = [
            figures.Line(TITLES[variant], curve, figures.STYLES[variant])
            for variant in variants
            if (curve := summary.cumulative(records, variant, dense)) is not None
        ]
        if lines:
            panels[title] = lines
    return figure(
        files,
        "cumulative",
        figures.draw(figures.curves, panels, summary.THRESHOLDS, "error per √area", "share of points", 1.02),
        f"Cumulative error curves: {', '.join(panels)}.",
        "Share of points with at most this error (Princeton's measure); higher is better.",
    )


def confidence(records: Records, variants: Sequence[str], files: dict[str, bytes]) -> list[Markup]:
    """How well confidence predicts the error: a figure and its numbers."""
    shown = summary.distinct_variants(records, variants)
    calibration = {variant: summary.calibration(records, variant) for variant in shown}
    counts = calibration[shown[0]][0]
    shares = {variant: share for variant, (_, share) in calibration.items()}
    rows = [
        [f"{low:.1f} to {high:.1f}", number(int(n)), *(percent(share[k]) for share in shares.values())]
        for k, (low, high, n) in enumerate(zip(summary.BINS[:-1], summary.BINS[1:], counts, strict=True))
    ]
    parts = [
        figure(
            files,
            "confidence",
            figures.draw(figures.calibration, summary.BINS, counts, shares),
            "Share of accurate matches in each bin of confidence, and number of matches in each bin.",
            "Top: share of matches within 5 % of the diameter, by confidence. Bottom: number of matches.",
        ),
        table("Within 5 % of the diameter", ("confidence", "matches", *(TITLES[v] for v in shown)), rows),
    ]
    return [tag("div", *parts, class_="grid")]


def categories(records: Records, variants: Sequence[str]) -> Markup:
    """A row for each category, and one for all pairs."""
    last = variants[-1]
    groups = {**summary.by_category(records), "all": records}
    dense = any(record["dense"] for record in summary.done(records))
    header = [
        "category",
        "pairs",
        "failed",
        "matches",
        "first 15",
        "first 45",
        "first 15 within 3 %",
        "wrong pairs",
    ]
    header += ["first 45, better of both", "wrong pairs, better of both"] * (last == "better")
    header += ["dense", "dense, better of both"][: len(variants)] * dense
    rows = []
    for name, group in groups.items():
        n_done = len(summary.done(group))
        row = [name, number(len(group)), number(len(group) - n_done)]
        if n_done:
            direct, better = summary.headline(group, "direct"), summary.headline(group, last)
            row.append(number(summary.surface_numbers(group)["matches"], 1))
            row += [measure(key, direct[key]) for key in ("mean15", "mean45", "first15_close", "wrong")]
            row += [measure(key, better[key]) for key in ("mean45", "wrong")] * (last == "better")
            row += [number(each["dense_mean"]) for each in (direct, better)][: len(variants)] * dense
        rows.append(row + ["–"] * (len(header) - len(row)))
    return table(
        "Errors per diameter (dense: per √area), mean over the pairs of a category", *without_empty(header, rows)
    )


def every_pair(records: Records, variants: Sequence[str]) -> Markup:
    """A row for each pair; ``pairs.csv`` has more columns."""
    header = ["pair", "matches"] + [f"first {n}, {TITLES[v]}" for v in variants for n in (summary.FEW, summary.MANY)]
    dense = any(record["dense"] for record in summary.done(records))
    header += [f"dense, {TITLES[v]}" for v in variants] * dense
    rows = []
    for record in summary.done(records):
        each = [summary.measures(record, variant) for variant in variants]
        row = [record["name"], number(len(record["pairs"]) or None)]
        row += [number(m[key]) for m in each for key in ("mean15", "mean45")]
        rows.append(row + [number(m["dense_mean"]) for m in each] * dense)
    return table("Mean errors per diameter (dense: per √area); more columns in pairs.csv", *without_empty(header, rows))


def worst(info: dict[str, Any], records: Records, variants: Sequence[str], files: dict[str, bytes]) -> list[Markup]:
    """Pictures of the pairs with the largest errors, drawn with meshes read from their files."""
    finished = summary.done(records)
    means = np.array([summary.measures(record, "direct")["mean45"] for record in finished])
    order = np.argsort(-np.nan_to_num(means, nan=-1), kind="stable")[:WORST]
    shown = [finished[k] for k in order if not np.isnan(means[k])]
    note = tag("p", "By the mean error of the first 45. A match has the same colour on both shapes.", class_="quiet")
    drawn = [_match_picture(k, record, info, variants, files) for k, record in enumerate(shown, 1)]
    return [note, tag("div", *drawn, class_="grid")] if shown else [tag("p", "No pair has matches to draw.")]


def _match_picture(
    rank: int, record: dict[str, Any], info: dict[str, Any], variants: Sequence[str], files: dict[str, bytes]
) -> Markup:
    from ..exporting.figures import draw_matches

    means = [f"{TITLES[v]} {number(summary.measures(record, v)['mean45'])}" for v in variants]
    caption = f"{record['name']}: {'; '.join(means)}"
    buffer = io.BytesIO()
    try:
        draw_matches(_correspondence(record), buffer, most=summary.MANY, size=(1000, 500))
    except (MobiusError, OSError) as error:
        return tag("p", f"{caption}. Not drawn: {summary.without_folders(str(error), record, info)}")
    files[f"worst-{rank}.png"] = buffer.getvalue()
    return picture(buffer.getvalue(), "png", f"Both shapes of {record['name']} with their matches.", caption)


def _correspondence(record: dict[str, Any]) -> Correspondence:
    """The result of a record, with the fields that drawing needs."""
    infos = [{"path": record[side], "sha256": as_mesh(record[side]).sha256} for side in ("source", "target")]
    return Correspondence(
        pairs=np.array(record["pairs"], np.int64).reshape(-1, 2),
        confidence=np.array(record["confidence"], np.float64),
        kind=np.array(record["kind"], dtype="<U9"),
        source_info=infos[0],
        target_info=infos[1],
        settings={},
    )


def times(records: Records) -> list[Markup]:
    """Seconds of each stage, and peak memory."""
    rows = [
        [stage, *(number(values[key]) for key in ("mean", "median", "largest"))]
        for stage, values in summary.seconds(records).items()
    ]
    header = ("stage", "mean", "median", "largest")
    peak = summary.memory(records)
    text = (
        "Peak memory of a worker: {mean:,.0f} MB on average, {largest:,.0f} MB at most.".format(**peak) if peak else ""
    )
    note = "A mesh is prepared once for all its pairs. Its preparation time is included in each of these pairs."
    return [table("Seconds per pair", header, rows), tag("p", text), tag("p", note, class_="quiet")]


def settings(info: dict[str, Any]) -> list[Markup]:
    """The data, the settings and the versions of the run."""
    data = {"name": summary.dataset_name(info)}
    data |= {name: value for name, value in info["dataset"].items() if name != "path"}
    maps = summary.maps(info)
    parts = {
        "Data": data,
        "Measurement of errors": info["scoring"],
        **({"Dense maps of another program": maps} if maps else {"Matching": info["settings"]}),
        "Software": info["software"],
    }
    tables = [
        table(title, ("name", "value"), [(name, setting(value)) for name, value in values.items()], "text")
        for title, values in parts.items()
        if values
    ]
    return [tag("div", *tables, class_="grid")]
