"""The numbers of a report, computed from the records of the pairs.

Errors are geodesic distances on the target: per diameter (the paper's measure, figures 8 and 9) or per sqrt(area)
(Princeton's). A symmetric shape has two ground truths; the variant ``"better"`` uses for each pair, as a whole, the one
with the smaller mean over the first 45 matches (for dense maps, over all points).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

VARIANTS = ("direct", "mirrored", "better")
FEW, MANY = 15, 45
"""The paper evaluates the first 15 and the first 45 correspondences."""
CLOSE = 0.03
"""Error per diameter that the paper calls acceptable: "if we consider less than 3 % error acceptable"."""
WRONG = 0.10
"""Mean error of the first 45, per diameter, above which the alignment of a pair counts as wrong."""
NEAR = 0.05
"""Error of an accurate match: per diameter in the bins of confidence, per sqrt(area) in Princeton's share."""
THRESHOLDS = np.linspace(0, 0.25, 101)
"""Errors per sqrt(area) at which the cumulative curves are evaluated."""
BINS = np.linspace(0, 1, 11)
"""Edges of the bins of confidence."""


def done(records: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """The records of the pairs that were matched and scored."""
    return [record for record in records if record["status"] == "done"]


def errors(record: dict[str, Any], variant: str, dense: bool = False) -> np.ndarray | None:
    """Errors per diameter (Q,) in order of confidence, NaN where the true point is unknown; None without this variant.

    With ``dense``, one error for each ground-truth point of the dense map instead.
    """
    lists = record["dense"] if dense else record
    if variant == "better":
        both = [values for v in ("direct", "mirrored") if (values := errors(record, v, dense)) is not None]
        means = [mean(values if dense else without_nan(values)[:MANY]) for values in both]
        return both[int(np.argmin(np.nan_to_num(means, nan=np.inf)))] if both else None
    if not lists or lists.get(variant) is None:
        return None
    return np.array(lists[variant], np.float64)  # JSON's null becomes NaN


def without_nan(values: np.ndarray) -> np.ndarray:
    """The values that are not NaN."""
    return np.asarray(values[~np.isnan(values)])


def mean(values: Any) -> float:
    """The mean of the values that are not NaN; NaN if there are none."""
    finite = without_nan(np.asarray(values, np.float64))
    return float(finite.mean()) if len(finite) else float("nan")


def area_factor(record: dict[str, Any]) -> float:
    """The factor from errors per diameter to errors per sqrt(area) of the target."""
    return float(record["diameter"]) / float(np.sqrt(record["area"]))


def _share(values: np.ndarray, limit: float) -> float:
    finite = without_nan(values)
    return float((finite <= limit).mean()) if len(finite) else float("nan")


def variants(records: list[dict[str, Any]]) -> tuple[str, ...]:
    """The variants to report: ``"direct"`` alone, or all of ``VARIANTS`` if any pair has a mirrored ground truth."""
    mirrored = any(errors(r, "mirrored", dense) is not None for r in done(records) for dense in (False, True))
    return VARIANTS if mirrored else ("direct",)


def measures(record: dict[str, Any], variant: str) -> dict[str, float]:
    """The measures of one pair against one ground truth; NaN for those that it has not."""
    sparse, dense = errors(record, variant), errors(record, variant, dense=True)
    sparse = np.zeros(0) if sparse is None else sparse
    dense = np.zeros(0) if dense is None else dense
    # If the ground truth is a few landmarks, most matches are nearest to none of them.
    compared = without_nan(sparse)
    few = compared[:FEW]
    all_close = float(len(few) == FEW and bool((few <= CLOSE).all()))
    mean_of_many, factor = mean(compared[:MANY]), area_factor(record)
    dense_mean = mean(dense) * factor
    return {
        "known": float(len(compared)) if len(sparse) else float("nan"),
        "mean15": mean(few),
        "mean45": mean_of_many,
        "first15_close": all_close if len(compared) or 0 < len(sparse) < FEW else float("nan"),
        "wrong": float(mean_of_many > WRONG) if mean_of_many == mean_of_many else float("nan"),
        "princeton_mean": mean(sparse) * factor,
        "princeton_within": _share(sparse * factor, NEAR),
        "dense_mean": dense_mean,
        "dense_within": _share(dense * factor, NEAR),
        "dense_within_far": _share(dense * factor, WRONG),
        "dense_wrong": float(dense_mean > WRONG) if dense_mean == dense_mean else float("nan"),
    }


def distinct_variants(records: list[dict[str, Any]], variants: Sequence[str]) -> list[str]:
    """``"direct"``, and ``"better"`` too if the two differ in any pair."""
    for record in done(records) if "better" in variants else ():
        direct, better = errors(record, "direct"), errors(record, "better")
        if direct is None or better is None or not np.array_equal(direct, better, equal_nan=True):
            return ["direct", "better"]
    return ["direct"]


def headline(records: list[dict[str, Any]], variant: str) -> dict[str, float]:
    """The measures over the pairs that are done: means, with equal weights of the pairs, and counts of wrong pairs."""
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
    """Share of points with an error up to each of ``THRESHOLDS``, averaged over the pairs; None without any."""
    curves = []
    for record in done(records):
        values = errors(record, variant, dense)
        if values is not None and len(ordered := np.sort(without_nan(values) * area_factor(record))):
            curves.append(np.searchsorted(ordered, THRESHOLDS, side="right") / len(ordered))
    return np.mean(curves, axis=0) if curves else None


def matrix(records: list[dict[str, Any]], variant: str, columns: int) -> np.ndarray:
    """The errors per diameter as (pairs, columns), in order of confidence; NaN where a pair has fewer matches."""
    table = np.full((len(records), columns), np.nan)
    for row, record in zip(table, records, strict=True):
        values = errors(record, variant) if record["status"] == "done" else None
        if values is not None:
            row[: len(values)] = values[:columns]
    return table


def over_pairs(table: np.ndarray, reduce: Callable[[np.ndarray], Any]) -> np.ndarray:
    """``reduce`` (mean, median) of the entries of each column that are not NaN; NaN if there are none."""
    columns = [without_nan(column) for column in table.T]
    return np.array([float(reduce(column)) if len(column) else np.nan for column in columns])


def calibration(records: list[dict[str, Any]], variant: str) -> tuple[np.ndarray, np.ndarray]:
    """The number of matches in each bin of confidence, and the share of them within 5 % of the diameter."""
    confidence, near = [np.zeros(0)], [np.zeros(0)]
    for record in done(records):
        values = errors(record, variant)
        if values is not None:
            compared = ~np.isnan(values)
            confidence.append(np.array(record["confidence"], np.float64)[compared])
            near.append((values[compared] <= NEAR).astype(np.float64))
    bin_number = np.digitize(np.concatenate(confidence), BINS[1:-1])
    counts = np.bincount(bin_number, minlength=len(BINS) - 1)
    near_counts = np.bincount(bin_number, np.concatenate(near), minlength=len(BINS) - 1)
    return counts, np.divide(near_counts, counts, out=np.full(len(counts), np.nan), where=counts > 0)


def coverage(record: dict[str, Any]) -> dict[str, float]:
    """The numbers of the coverage by name."""
    return {name: value for name, value in (record["coverage"] or {}).items() if isinstance(value, int | float)}


def surface_numbers(records: list[dict[str, Any]]) -> dict[str, float]:
    """Means over the pairs of what is no error: number of matches, coverage, rank correlation of the confidence."""
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
    """Mean, median and largest seconds of each stage, over the pairs that have it."""
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
    """Mean and largest peak memory of the workers, in MB."""
    peaks = np.array([record["memory_mb"] for record in done(records)], np.float64)
    peaks = without_nan(peaks)
    return {"mean": float(peaks.mean()), "largest": float(peaks.max())} if len(peaks) else {}


def is_time(column: str) -> bool:
    """Whether a column of ``pairs.csv`` holds seconds or megabytes, which differ between equal runs."""
    return column.endswith(("_seconds", "_mb"))


def n_cases(info: dict[str, Any], records: list[dict[str, Any]]) -> int:
    """Number of pairs in the run, including those not processed yet."""
    return len(info.get("cases") or records)


def maps(info: dict[str, Any]) -> dict[str, Any] | None:
    """The scored dense maps of another program; None if the run has matched the pairs."""
    given = info.get("maps")
    return given and {"folder": file_name(given["folder"]), "vertices count from": given["index_base"]}


def dataset_name(info: dict[str, Any]) -> str:
    """The name of the folder that was evaluated."""
    return file_name(str(info["dataset"].get("path") or "")) or "meshes"


def file_name(path: str | None) -> str:
    """The name without its folder, so that a report has no paths of the machine that it was made on."""
    return PurePath(path).name if path else ""


def without_folders(text: str, record: dict[str, Any], info: dict[str, Any]) -> str:
    """A message with file names instead of paths."""
    folders = {str(PurePath(record[side]).parent) for side in ("source", "target")}
    folders |= {
        str(PurePath(path)) for path in (info["dataset"].get("path"), (info.get("maps") or {}).get("folder")) if path
    }
    for folder in sorted(folders, key=len, reverse=True):
        text = text.replace(folder.rstrip(os.sep) + os.sep, "") if len(folder) > 1 else text
    return text


def message(record: dict[str, Any], info: dict[str, Any]) -> str:
    """The error message of a failed pair."""
    return without_folders(record["error"] or "no message", record, info)


def row(record: dict[str, Any], info: dict[str, Any]) -> dict[str, Any]:
    """One row of ``pairs.csv``; None for empty cells."""
    out = {
        "name": record["name"],
        "category": record["category"],
        "source": file_name(record["source"]),
        "target": file_name(record["target"]),
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
