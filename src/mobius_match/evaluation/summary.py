"""Numbers of a report, from the records of the pairs; nothing here draws, writes or measures a distance.

Errors are geodesic distances on the target. Per diameter they are the paper's measure (figures 8 and 9), per
sqrt(area) Princeton's. Of the two truths that a symmetric shape has, ``"better"`` takes for each pair, as a whole, the
one with the smaller mean over the first 45 matches (for dense maps, over all points).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

VARIANTS = ("direct", "mirrored", "better")
FEW, MANY = 15, 45
"""The paper speaks of the first 15 and the first 45 correspondences."""
CLOSE = 0.03
"""Per diameter: "if we consider less than 3 % error acceptable"."""
WRONG = 0.10
"""Mean of the first 45, per diameter, from which a pair counts as matched by a wrong explanation."""
NEAR = 0.05
"""Per diameter in the calibration of the confidence, per sqrt(area) in Princeton's share."""
THRESHOLDS = np.linspace(0, 0.25, 101)
"""Errors per sqrt(area) at which the cumulative curves are given."""
BINS = np.linspace(0, 1, 11)
"""Of the confidence."""


def done(records: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """The records of the pairs that were matched and scored."""
    return [record for record in records if record["status"] == "done"]


def errors(record: dict[str, Any], variant: str, dense: bool = False) -> np.ndarray | None:
    """Errors per diameter (Q,), in order of confidence; NaN where no truth is known, None where there is no such truth.

    With ``dense``, one error for each ground-truth point instead.
    """
    lists = record["dense"] if dense else record
    if variant == "better":
        both = [found for v in ("direct", "mirrored") if (found := errors(record, v, dense)) is not None]
        decisive = [mean(found if dense else known_of(found)[:MANY]) for found in both]
        return both[int(np.argmin(np.nan_to_num(decisive, nan=np.inf)))] if both else None
    if not lists or lists.get(variant) is None:
        return None
    return np.array(lists[variant], np.float64)  # JSON's null becomes NaN


def known_of(values: np.ndarray) -> np.ndarray:
    """The values that are not NaN."""
    return np.asarray(values[~np.isnan(values)])


def mean(values: Any) -> float:
    """The mean of what is known; NaN of nothing."""
    known = known_of(np.asarray(values, np.float64))
    return float(known.mean()) if len(known) else float("nan")


def princeton(record: dict[str, Any]) -> float:
    """The factor from errors per diameter to errors per sqrt(area) of the target."""
    return float(record["diameter"]) / float(np.sqrt(record["area"]))


def _share(found: np.ndarray, limit: float) -> float:
    known = known_of(found)
    return float((known <= limit).mean()) if len(known) else float("nan")


def variants(records: list[dict[str, Any]]) -> tuple[str, ...]:
    """The truths to report: the direct one alone, or all of ``VARIANTS`` where any pair has a mirrored truth."""
    mirrored = any(errors(r, "mirrored", dense) is not None for r in done(records) for dense in (False, True))
    return VARIANTS if mirrored else ("direct",)


def has_dense(records: list[dict[str, Any]]) -> bool:
    """Whether any pair has a dense map."""
    return any(record["dense"] for record in done(records))


def measures(record: dict[str, Any], variant: str) -> dict[str, float]:
    """What is said of one pair against one truth; NaN where the pair has none."""
    found, dense = errors(record, variant), errors(record, variant, dense=True)
    found = np.zeros(0) if found is None else found
    dense = np.zeros(0) if dense is None else dense
    # Where the truth is a few landmarks, most matches are nearest to none of them.
    known = known_of(found)
    few = known[:FEW]
    first = float(len(few) == FEW and bool((few <= CLOSE).all()))
    many, factor = mean(known[:MANY]), princeton(record)
    dense_mean = mean(dense) * factor
    return {
        "known": float(len(known)) if len(found) else float("nan"),
        "mean15": mean(few),
        "mean45": many,
        "first15_close": first if len(known) or 0 < len(found) < FEW else float("nan"),
        "wrong": float(many > WRONG) if many == many else float("nan"),
        "princeton_mean": mean(found) * factor,
        "princeton_within": _share(found * factor, NEAR),
        "dense_mean": dense_mean,
        "dense_within": _share(dense * factor, NEAR),
        "dense_within_far": _share(dense * factor, WRONG),
        "dense_wrong": float(dense_mean > WRONG) if dense_mean == dense_mean else float("nan"),
    }


def unlike(records: list[dict[str, Any]], variants: Sequence[str]) -> list[str]:
    """``"direct"``, and ``"better"`` too if that is the other one in any pair."""
    for record in done(records) if "better" in variants else ():
        direct, better = errors(record, "direct"), errors(record, "better")
        if direct is None or better is None or not np.array_equal(direct, better, equal_nan=True):
            return ["direct", "better"]
    return ["direct"]


def headline(records: list[dict[str, Any]], variant: str) -> dict[str, float]:
    """The measures over the pairs that are done: means in which each pair weighs the same, and counts of the wrong."""
    each = [measures(record, variant) for record in done(records)]
    pairs = sum(errors(r, variant) is not None or errors(r, variant, True) is not None for r in done(records))
    total: dict[str, float] = {"pairs": pairs}
    for name in each[0] if each else ():
        values = np.array([measured[name] for measured in each])
        counted = name.endswith("wrong") and not np.isnan(values).all()
        total[name] = int(np.nansum(values)) if counted else mean(values)
    return total


def by_category(records: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The records of each category, in order of first appearance."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for record in records:
        groups.setdefault(record["category"], []).append(record)
    return groups


def cumulative(records: list[dict[str, Any]], variant: str, dense: bool = False) -> np.ndarray | None:
    """Share of points with an error of at most each of ``THRESHOLDS``, per sqrt(area); each pair weighs the same."""
    curves = []
    for record in done(records):
        found = errors(record, variant, dense)
        if found is not None and len(known := np.sort(known_of(found) * princeton(record))):
            curves.append(np.searchsorted(known, THRESHOLDS, side="right") / len(known))
    return np.mean(curves, axis=0) if curves else None


def matrix(records: list[dict[str, Any]], variant: str, columns: int) -> np.ndarray:
    """The errors per diameter as (pairs, columns), in order of confidence; NaN where a pair has fewer matches."""
    table = np.full((len(records), columns), np.nan)
    for row, record in zip(table, records, strict=True):
        found = errors(record, variant) if record["status"] == "done" else None
        if found is not None:
            row[: len(found)] = found[:columns]
    return table


def over_pairs(table: np.ndarray, reduce: Callable[[np.ndarray], Any]) -> np.ndarray:
    """``reduce`` (mean, median) of the known entries of each column; NaN where there are none."""
    columns = [known_of(column) for column in table.T]
    return np.array([float(reduce(column)) if len(column) else np.nan for column in columns])


def calibration(records: list[dict[str, Any]], variant: str) -> tuple[np.ndarray, np.ndarray]:
    """For each bin of the confidence the number of matches, and the share of them within 5 % of the diameter."""
    confidence, near = [np.zeros(0)], [np.zeros(0)]
    for record in done(records):
        found = errors(record, variant)
        if found is not None:
            known = ~np.isnan(found)
            confidence.append(np.array(record["confidence"], np.float64)[known])
            near.append((found[known] <= NEAR).astype(np.float64))
    place = np.digitize(np.concatenate(confidence), BINS[1:-1])
    number = np.bincount(place, minlength=len(BINS) - 1)
    hits = np.bincount(place, np.concatenate(near), minlength=len(BINS) - 1)
    return number, np.divide(hits, number, out=np.full(len(number), np.nan), where=number > 0)


def coverage(record: dict[str, Any]) -> dict[str, float]:
    """The coverage's numbers, by name."""
    return {name: value for name, value in (record["coverage"] or {}).items() if isinstance(value, int | float)}


def surface_numbers(records: list[dict[str, Any]]) -> dict[str, float]:
    """Means over the pairs of what needs no truth: number of matches and coverage; and how well confidence ranks."""
    finished = done(records)
    names = dict.fromkeys(name for record in finished for name in coverage(record))
    return {
        "matches": mean([len(record["pairs"]) or np.nan for record in finished]),
        **{f"coverage_{name}": mean([coverage(r).get(name, np.nan) for r in finished]) for name in names},
        "ranking": mean([record["ranking"] for record in finished]),
        "dense_unmapped": mean([(record["dense"] or {}).get("unmapped", np.nan) for record in finished]),
        "heat_difference": mean([record["heat_difference"] for record in finished]),
    }


def seconds(records: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """For each stage the mean, median and largest of the seconds of the pairs that went through it."""
    stages = dict.fromkeys(stage for record in done(records) for stage in record["timings"])
    table = {}
    for stage in stages:
        spent = np.array([record["timings"][stage] for record in done(records) if stage in record["timings"]])
        table[stage] = {
            "mean": float(spent.mean()),
            "median": float(np.median(spent)),
            "largest": float(spent.max()),
        }
    return table


def memory(records: list[dict[str, Any]]) -> dict[str, float]:
    """Mean and largest of the workers' peaks, in MB."""
    peaks = np.array([record["memory_mb"] for record in done(records)], np.float64)
    peaks = known_of(peaks)
    return {"mean": float(peaks.mean()), "largest": float(peaks.max())} if len(peaks) else {}


def is_time(column: str) -> bool:
    """Whether a column of ``pairs.csv`` differs from run to run: seconds and megabytes."""
    return column.endswith(("_seconds", "_mb"))


def n_cases(info: dict[str, Any], records: list[dict[str, Any]]) -> int:
    """How many pairs the run has, those included that were not worked on yet."""
    return len(info.get("cases") or records)


def maps(info: dict[str, Any]) -> dict[str, Any] | None:
    """Where the dense maps of another program came from, None if the pairs were matched here."""
    given = info.get("maps")
    return given and {"folder": shown_path(given["folder"]), "numbers from": given["index_base"]}


def dataset_name(info: dict[str, Any]) -> str:
    """The name of the folder that was evaluated."""
    return shown_path(str(info["dataset"].get("path") or "")) or "meshes"


def shown_path(path: str | None) -> str:
    """The file's name alone: a report tells nothing else about the machine that it was made on."""
    return PurePath(path).name if path else ""


def without_folders(text: str, record: dict[str, Any], info: dict[str, Any]) -> str:
    """A message with the names of files instead of their paths."""
    folders = {str(PurePath(record[side]).parent) for side in ("source", "target")}
    folders |= {
        str(PurePath(path)) for path in (info["dataset"].get("path"), (info.get("maps") or {}).get("folder")) if path
    }
    for folder in sorted(folders, key=len, reverse=True):
        text = text.replace(folder.rstrip(os.sep) + os.sep, "") if len(folder) > 1 else text
    return text


def message(record: dict[str, Any], info: dict[str, Any]) -> str:
    """Why a pair failed."""
    return without_folders(record["error"] or "no message", record, info)


def row(record: dict[str, Any], info: dict[str, Any]) -> dict[str, Any]:
    """One line of ``pairs.csv``: the same columns for each pair of a run, None where there is nothing to say."""
    out = {
        "name": record["name"],
        "category": record["category"],
        "source": shown_path(record["source"]),
        "target": shown_path(record["target"]),
        "status": record["status"],
    }
    if record["status"] != "done":
        return out | {"error": message(record, info)}
    out["matches"] = len(record["pairs"])
    for variant in VARIANTS:
        measured = measures(record, variant)
        out |= {f"{name}_{variant}": value for name, value in measured.items() if not name.endswith("wrong")}
    out |= {f"coverage_{name}": value for name, value in coverage(record).items()}
    out |= {name: record[name] for name in ("ranking", "heat_difference", "diameter", "area")}
    out["dense_unmapped"] = (record["dense"] or {}).get("unmapped")
    out["memory_mb"] = record["memory_mb"]
    out |= {f"{stage.replace(' ', '_')}_seconds": seconds for stage, seconds in record["timings"].items()}
    return {name: None if isinstance(value, float) and value != value else value for name, value in out.items()}
