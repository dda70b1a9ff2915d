"""Evaluation against known correspondence: data sets, errors, runs over many pairs, reports."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "Case": "datasets",
    "Dataset": "datasets",
    "Run": "runs",
    "Truth": "datasets",
    "coverage": "metrics",
    "diameter": "metrics",
    "find_dataset": "datasets",
    "geodesic_distances": "metrics",
    "load_run": "runs",
    "ranking": "metrics",
    "read_truth": "known",
    "run": "runs",
    "write_comparison": "report",
    "write_report": "report",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
