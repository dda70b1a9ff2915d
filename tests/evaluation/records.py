"""Synthetic records of runs, for the tests of reports."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np


def record(name, category="cat", *, direct=(), mirrored=None, confidence=None, dense=None, **others):
    """A pair that is done, with these errors per diameter."""
    n = len(direct)
    confidence = np.linspace(0.95, 0.05, n).tolist() if confidence is None else confidence
    return {
        "name": name,
        "category": category,
        "source": f"/secret/home/data/{name.split('-')[0]}.off",
        "target": f"/secret/home/data/{name.split('-')[-1]}.off",
        "status": "done",
        "error": None,
        "pairs": [[k, k] for k in range(n)],
        "confidence": list(confidence),
        "kind": ["voted"] * n,
        "direct": list(direct),
        "mirrored": None if mirrored is None else list(mirrored),
        "heat_difference": 0.0004,
        "diameter": 3.0,
        "area": 4.0,
        "coverage": {"target_mean": 0.1, "target_evenness": 0.8},
        "ranking": 0.5,
        "dense": dense,
        "warnings": [],
        "timings": {"voting": 0.25, "total": 1.5},
        "memory_mb": 123.0,
    } | others


def failed(name, message, category="cat"):
    """A pair that failed."""
    done = record(name, category)
    return {key: done[key] for key in ("name", "category", "source", "target")} | {"status": "failed", "error": message}


def run(records, folder="/secret/home/run", **info):
    """A run with these records."""
    described = {
        "dataset": {"path": "/secret/home/data", "layout": "vertex lists"},
        "settings": {"samples": 100, "votes": None, "seed": 0},
        "scoring": {"geodesics": "exact"},
        "maps": None,
        "software": {"mobius-match": "0.1.0"},
        "cases": [pair["name"] for pair in records],
    }
    return SimpleNamespace(folder=Path(folder), info=described | info, records=list(records))


def usual():
    """Five pairs in two categories, of which one failed and one is mirrored."""
    rng = np.random.default_rng(0)
    good, bad = (lambda n: rng.uniform(0, 0.028, n).tolist()), (lambda n: rng.uniform(0.2, 0.4, n).tolist())
    return [
        record("cat0-cat1", direct=good(60), mirrored=bad(60)),
        record("cat0-cat2", direct=bad(50), mirrored=good(50)),
        failed("cat0-cat3", "/secret/home/data/cat3.off: 2 <components>; keep the largest"),
        record("dog0-dog1", "dog", direct=[0.2, *good(45)], mirrored=bad(46)),
        record("dog0-dog2", "dog", direct=good(10), mirrored=bad(10)),
    ]
