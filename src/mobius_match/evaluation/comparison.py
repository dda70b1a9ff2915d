"""Comparison of runs: their curves in common axes, and which pairs became better or worse."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.files import write_atomically
from ..errors import SettingsError
from . import figures, summary
from .glossary import MEASURES, TITLES
from .page import Markup, figure, number, page, save_figures, section, setting, table, tag
from .sections import COLUMNS, measure

if TYPE_CHECKING:
    from .runs import Run

SAME = 0.01
"""Largest change of an error that counts as the same: per diameter, for dense maps per sqrt(area)."""
COMPARED = {"mean45": "mean of the first 45, per diameter", "dense_mean": "mean of the dense map, per √area"}
ORDER = ("worse", "same", "better")


def write_comparison(runs: Sequence[Run], folder: Path) -> Path:
    """Write ``comparison.html``, ``comparison.csv`` and its figures into a folder.

    Each later run is compared with the first, on the pairs (by name) that all runs contain.

    Parameters
    ----------
    runs
        Two or more runs.
    folder
        The folder; created if necessary.

    Returns
    -------
    path
        The page.

    Raises
    ------
    SettingsError
        If there are fewer than two runs, or they have no pair in common.
    """
    if len(runs) < 2:
        raise SettingsError("`runs`: there is nothing to compare; give two or more")
    names = run_names([Path(run.folder) for run in runs])
    common, records = common_pairs(runs)
    if not common:
        raise SettingsError(f"{', '.join(names)}: these runs have no pair in common; compare runs on the same data set")
    kept = [
        [record for record, *others in zip(mine, *records, strict=True) if all(r["status"] == "done" for r in others)]
        for mine in records
    ]
    files: dict[str, bytes] = {}
    content: list[Markup] = [_about(runs, names, common, kept)]
    if kept[0]:
        content += [
            section("Headline numbers", *_headlines(names, kept)),
            section("Cumulative errors", *_cumulative(names, kept, files)),
            section("The first 60", *_first_matches(names, kept, files)),
        ]
    rows = changes(names, records)
    content += [section("Pair by pair", *_changes(names, rows))]
    content += [section("Settings that differ", _differences(runs, names))]
    folder = Path(folder)
    save_figures(folder, files)
    write_atomically(folder / "comparison.csv", _csv(rows).encode())
    write_atomically(folder / "comparison.html", page("Comparison: " + ", ".join(names), *content))
    return folder / "comparison.html"


def run_names(folders: Sequence[Path]) -> list[str]:
    """The names of the folders, with as many parent folders as necessary to make them distinct."""
    parts = [folder.resolve().parts[1:] for folder in folders]
    names = []
    for k, mine in enumerate(parts):
        others = parts[:k] + parts[k + 1 :]
        unique = (n for n in range(1, len(mine) + 1) if all(mine[-n:] != other[-n:] for other in others))
        length = next(unique, None)
        # The same folder twice, or a folder whose whole path ends another's, gets a number.
        names.append("/".join(mine[-length:]) if length else f"{'/'.join(mine[-1:])} ({k + 1})")
    return names


def common_pairs(runs: Sequence[Run]) -> tuple[list[str], list[list[dict[str, Any]]]]:
    """The names of the pairs that all runs contain, in the order of the first run, and their records in each run."""
    tables = [{record["name"]: record for record in run.records} for run in runs]
    common = [name for name in tables[0] if all(name in table for table in tables)]
    return common, [[table[name] for name in common] for table in tables]


def verdict(before: dict[str, Any], after: dict[str, Any], name: str, variant: str) -> tuple[float, float, float, str]:
    """Error before and after, the change (infinite if one failed), and ``"better"``, ``"same"`` or ``"worse"``."""
    old, new = (
        summary.measures(record, variant)[name] if record["status"] == "done" else np.nan for record in (before, after)
    )
    if before["status"] != after["status"]:
        change = np.inf if after["status"] != "done" else -np.inf
    else:
        change = new - old
    word = "" if np.isnan(change) else ORDER[1 + int(change < -SAME) - int(change > SAME)]
    return old, new, change, word


def changes(names: Sequence[str], records: Sequence[Sequence[dict[str, Any]]]) -> list[dict[str, Any]]:
    """A row for each later run, measure, ground truth and pair, sorted by the change with the worst first."""
    rows = []
    variants = summary.VARIANTS if any(len(summary.variants(list(each))) > 1 for each in records) else ("direct",)
    for name, after in zip(names[1:], records[1:], strict=True):
        for key in COMPARED:
            for variant in (v for v in variants if v != "mirrored"):
                block = []
                for old, new in zip(records[0], after, strict=True):
                    before, now, change, word = verdict(old, new, key, variant)
                    known = np.isfinite(change) or not np.isnan(before) or not np.isnan(now)
                    if word and known:
                        block.append({
                            "pair": old["name"], "first": names[0], "run": name, "measure": key, "truth": variant,
                            "before": before, "after": now, "change": change, "verdict": word,
                        })  # fmt: skip
                rows += sorted(block, key=lambda row: -row["change"])
    return rows


def _csv(rows: list[dict[str, Any]]) -> str:
    columns = ("pair", "first", "run", "measure", "truth", "before", "after", "change", "verdict")
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        numbers = {name: row[name] if np.isfinite(row[name]) else None for name in ("before", "after", "change")}
        writer.writerow(row | numbers)
    return text.getvalue()


def _about(runs: Sequence[Run], names: Sequence[str], common: Sequence[str], kept: Sequence[Any]) -> Markup:
    rows = []
    for name, run in zip(names, runs, strict=True):
        n_done = len(summary.done(run.records))
        scoring = run.info["scoring"].get("geodesics", "–")
        rows.append(
            (
                name,
                summary.dataset_name(run.info),
                number(summary.n_cases(run.info, run.records)),
                number(n_done),
                (summary.maps(run.info) or {}).get("folder", "–"),
                scoring,
            )
        )
    header = ("run", "data", "pairs", "done", "maps of another program", "geodesics of the errors")
    text = (
        f"{len(common)} pairs are in all runs; {len(kept[0])} of them are done in all. Means and curves are over "
        "these, with equal weights of the pairs."
    )
    parts = [tag("p", text), table("Runs", header, rows)]
    if len({row[-1] for row in rows}) > 1:
        warning = "The runs measure errors with different geodesics, which causes differences of about one percent."
        parts.append(tag("p", warning, class_="alert"))
    return Markup("".join(parts))


def _variants(kept: Sequence[list[dict[str, Any]]]) -> tuple[str, ...]:
    return summary.VARIANTS if any(len(summary.variants(records)) > 1 for records in kept) else ("direct",)


def _headlines(names: Sequence[str], kept: Sequence[list[dict[str, Any]]]) -> list[Markup]:
    tables = []
    for variant in _variants(kept):
        columns = [summary.headline(records, variant) for records in kept]
        rows = [
            [title, *(measure(key, column[key]) for column in columns)]
            for key, title in MEASURES.items()
            if any(column[key] == column[key] and column["pairs"] for column in columns)
        ]
        if variant == "direct":
            matches = [summary.surface_numbers(records)["matches"] for records in kept]
            rows.append(["matches per pair", *(number(value, 1) for value in matches)])
        tables.append(table(f"Against the ground truth: {TITLES[variant]}", ("", *names), rows, "prose"))
    return [tag("div", *tables, class_="grid")]


def _cumulative(names: Sequence[str], kept: Sequence[Any], files: dict[str, bytes]) -> list[Markup]:
    drawn = []
    for dense, kind in ((False, "sparse"), (True, "dense")):
        panels = {}
        for variant in (v for v in _variants(kept) if v != "mirrored"):
            curves = [summary.cumulative(records, variant, dense) for records in kept]
            lines = [
                figures.Line(name, curve, figures.run_style(k))
                for k, (name, curve) in enumerate(zip(names, curves, strict=True))
                if curve is not None
            ]
            if lines:
                panels[f"{kind}, {TITLES[variant]}"] = lines
        if panels:
            labels = ("error per √area", "share of points", 1.02)
            svg_png = figures.draw(figures.curves, panels, summary.THRESHOLDS, *labels)
            alt = f"Cumulative error curves ({kind}) of {', '.join(names)}."
            caption = f"Share of points ({kind}) with at most this error; higher is better."
            drawn.append(figure(files, f"comparison-cumulative-{kind}", svg_png, alt, caption))
    return drawn


def _first_matches(names: Sequence[str], kept: Sequence[Any], files: dict[str, bytes]) -> list[Markup]:
    panels = {}
    for variant in (v for v in _variants(kept) if v != "mirrored"):
        tables = [summary.matrix(records, variant, COLUMNS) for records in kept]
        panels[TITLES[variant]] = [
            figures.Line(name, summary.over_pairs(errors, np.mean), figures.run_style(k))
            for k, (name, errors) in enumerate(zip(names, tables, strict=True))
            if not np.isnan(errors).all()
        ]
    if not any(panels.values()):
        return [tag("p", "No run has matches.")]
    labels = ("correspondence, in order of confidence", "mean error per diameter")
    svg_png = figures.draw(figures.curves, panels, np.arange(1, COLUMNS + 1), *labels)
    alt = f"Mean error of the k-th correspondence, for {', '.join(names)}."
    caption = "Error of the k-th correspondence, averaged over the pairs; lower is better."
    return [figure(files, "comparison-first-60", svg_png, alt, caption)]


def _changes(names: Sequence[str], rows: list[dict[str, Any]]) -> list[Markup]:
    text = f"Better or worse: the error differs by more than {SAME}, or the pair failed in one of the two runs."
    parts = []
    blocks: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in rows:
        blocks.setdefault((row["run"], row["measure"], row["truth"]), []).append(row)
    for (run, key, variant), block in blocks.items():
        counts = ", ".join(f"{sum(row['verdict'] == word for row in block)} {word}" for word in ORDER[::-1])
        caption = f"{names[0]} to {run}: {COMPARED[key]}, {TITLES[variant]}: {counts}"
        cells = [(r["pair"], _error(r["before"]), _error(r["after"]), _change(r), r["verdict"]) for r in block]
        parts.append(table(caption, ("pair", names[0], run, "change", "verdict"), cells))
    return [tag("p", text), tag("div", *parts, class_="grid")]


def _error(value: float) -> str:
    return "failed" if np.isnan(value) else number(value)


def _change(row: dict[str, Any]) -> str:
    return f"{row['change']:+.3f}".replace("-", "−") if np.isfinite(row["change"]) else "–"


def _differences(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    rows = []
    for part in ("settings", "scoring", "software"):
        for key in dict.fromkeys(key for run in runs for key in run.info[part]):
            values = [setting(run.info[part][key]) if key in run.info[part] else "–" for run in runs]
            if len(set(values)) > 1:
                rows.append((f"{part}: {key}", *values))
    return table("Settings that differ", ("name", *names), rows, "text") if rows else tag("p", "None.")
