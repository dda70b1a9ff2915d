"""The report of a run: a self-contained HTML page, its figures as files, and its numbers as CSV and JSON.

What differs between two runs with the same settings (times, memory) is confined to one section of the page
(``id="times"``), the columns of ``pairs.csv`` that end in ``_seconds`` or ``_mb``, and ``"times"`` in ``summary.json``.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._core.files import write_atomically
from . import sections, summary
from .comparison import write_comparison
from .glossary import definitions
from .page import page, save_figures, section

if TYPE_CHECKING:
    from .runs import Run

__all__ = ["pairs_csv", "summary_json", "write_comparison", "write_report"]

FORMAT, VERSION = "mobius-match/bench-summary", 1


def write_report(run: Run, folder: Path) -> Path:
    """Write ``report.html``, ``figures/``, ``pairs.csv`` and ``summary.json`` into a folder.

    The same records give the same bytes. A run in which every pair failed also gets a report.

    Parameters
    ----------
    run
        A finished or interrupted run.
    folder
        The folder; created if necessary.

    Returns
    -------
    path
        The page.
    """
    folder = Path(folder)
    files: dict[str, bytes] = {}
    name = summary.dataset_name(run.info)
    content = page(f"Evaluation: {name}", *_content(run, files))
    save_figures(folder, files)
    for old in (folder / "figures").glob("worst-*.png"):  # of an earlier report that drew more pairs
        if old.name not in files:
            old.unlink()
    write_atomically(folder / "pairs.csv", pairs_csv(run).encode(errors="replace"))
    write_atomically(folder / "summary.json", summary_json(run).encode())
    write_atomically(folder / "report.html", content)
    return folder / "report.html"


def _content(run: Run, files: dict[str, bytes]) -> Iterable[str]:
    records = run.records
    variants = summary.variants(records)
    yield sections.head(run.info, records, variants)
    yield sections.failures(run.info, records)
    if summary.done(records):
        yield section("Errors against the ground truth", sections.errors(records, variants))
        if any(record["pairs"] for record in summary.done(records)):
            yield section("Match by match (figures 8 and 9 of the paper)", *sections.paper(records, variants, files))
            yield section("Confidence and error", *sections.confidence(records, variants, files))
            yield section("The worst pairs", *sections.worst(run.info, records, variants, files))
        yield section("Cumulative errors", sections.cumulative(records, variants, files))
        yield section("Categories", sections.categories(records, variants))
        yield section("Time and memory", *sections.times(records), id="times")
        yield section("Every pair", sections.every_pair(records, variants))
    yield section("Settings and versions", *sections.settings(run.info))
    yield section("Definitions", definitions(run.info, records))


def pairs_csv(run: Run) -> str:
    """One row for each pair, including failed ones; see :func:`mobius_match.evaluation.summary.row`."""
    rows = [summary.row(record, run.info) for record in run.records]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    columns.sort(key=summary.is_time)  # a stable sort: times and memory come last
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def summary_json(run: Run) -> str:
    """The numbers of the page as JSON; null for what could not be measured."""
    records = run.records
    variants = summary.variants(records)
    content = {
        "format": FORMAT,
        "version": VERSION,
        "dataset": summary.dataset_name(run.info),
        "pairs": summary.n_cases(run.info, records),
        "done": len(summary.done(records)),
        "failed": {
            record["name"]: summary.message(record, run.info) for record in records if record["status"] != "done"
        },
        "errors": {variant: summary.headline(records, variant) for variant in variants},
        "surface": summary.surface_numbers(records),
        "categories": {
            category: {variant: summary.headline(group, variant) for variant in variants}
            for category, group in summary.by_category(records).items()
        },
        "cumulative": {
            "per_sqrt_area": summary.THRESHOLDS.tolist(),
            **{
                f"{kind}_{variant}": curve.tolist()
                for kind in ("sparse", "dense")
                for variant in variants
                if (curve := summary.cumulative(records, variant, kind == "dense")) is not None
            },
        },
        "maps": summary.maps(run.info),
        "settings": run.info["settings"],
        "scoring": run.info["scoring"],
        "software": run.info["software"],
        "times": {
            "seconds": summary.seconds(records),
            "memory_mb": summary.memory(records),
        },
    }
    return json.dumps(_without_nan(content), indent=1, allow_nan=False) + "\n"


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
