"""What the processes of a run do: prepare one mesh, or match and score one pair; an error is a record, not an end."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MobiusError
from ..matching.match import match
from ..matching.parameters import Parameters
from ..mesh import Mesh
from ..settings import MatchSettings
from ..surface.prepare import matchable_mesh, prepare
from ..surface.surface import Surface
from .datasets import Case
from .scoring import Scorer, cached_diameter, mesh_area
from .vertexlists import read_vertices


def prepare_one(path: str, out: Path, settings: MatchSettings) -> str | None:
    """Prepare a mesh and keep it; the message if that fails."""
    try:
        prepare(path, settings.preparation()).save(out)
    except Exception as error:  # noqa: BLE001  # one mesh must not end the run
        return _message(error)
    return None


def surface_path(folder: Path, mesh: str | Path) -> Path:
    """Where the folder of a run keeps a prepared mesh while it is under way."""
    return folder / "surfaces" / f"{hashlib.sha256(str(mesh).encode()).hexdigest()[:32]}.npz"


def record_of(work: Callable[..., dict[str, Any]], case: Case, *arguments: Any) -> dict[str, Any]:
    """The record of a pair, whatever happens."""
    try:
        return {**_head(case), "status": "done", "error": None, **work(case, *arguments), "memory_mb": _peak_memory()}
    except Exception as error:  # noqa: BLE001  # one pair must not end the run
        return failed(case, _message(error))


def _head(case: Case) -> dict[str, Any]:
    return {"name": case.name, "category": case.category, "source": str(case.source), "target": str(case.target)}


def failed(case: Case, message: str) -> dict[str, Any]:
    """The record of a pair that failed."""
    return {**_head(case), "status": "failed", "error": message}


def _message(error: Exception) -> str:
    return str(error) if isinstance(error, MobiusError) else f"{type(error).__name__}: {error}"


def match_pair(
    case: Case,
    scoring: str,
    folder: Path,
    settings: MatchSettings,
    dense: bool,
    parameters: Parameters = Parameters(),
) -> dict[str, Any]:
    """Match two prepared meshes and score the matches, and the dense map if wanted."""
    source, target = (_load_surface(surface_path(folder, path)) for path in (case.source, case.target))
    result = match(source, target, parameters=parameters, **settings.to_dict())
    timings = {f"source {name}": seconds for name, seconds in source.timings.items()}
    timings |= {f"target {name}": seconds for name, seconds in target.timings.items()}
    timings |= {name: seconds for name, seconds in result.timings.items() if name not in ("reading", "total")}
    start = time.perf_counter()
    spread = result.dense() if dense else None
    if spread:
        timings["dense map"] = time.perf_counter() - start
    timings["total"] = sum(timings.values())
    start = time.perf_counter()
    scored = _scorer(case, source.whole_mesh, target.whole_mesh, scoring)
    found = scored.score(result.pairs, result.confidence)
    of_map = _dense(scored.score_map(spread.vertex_map)) if spread else None
    timings["scoring"] = time.perf_counter() - start
    return {
        "pairs": result.pairs.tolist(),
        "confidence": _numbers(result.confidence),
        "kind": result.kind.tolist(),
        "direct": _numbers(found["direct"]),
        "mirrored": _numbers(found["mirrored"]),
        "heat_difference": found["heat_difference"],
        "diameter": scored.diameter,
        "area": mesh_area(target.whole_mesh),
        "coverage": found["coverage"],
        "ranking": found["ranking"],
        "dense": of_map,
        "warnings": list(result.warnings),
        "timings": timings,
    }


def _dense(found: dict[str, Any]) -> dict[str, Any]:
    """What a record keeps of a scored map."""
    errors = {name: _numbers(found[name]) for name in ("direct", "mirrored")}
    return {**errors, "unmapped": found["unmapped"]}


def score_dense(case: Case, scoring: str, path: Path, index_base: int) -> dict[str, Any]:
    """Score a dense map that another program made."""
    start = time.perf_counter()
    dense = read_vertices(path, index_base, gaps=True)
    source, target = matchable_mesh(case.source), matchable_mesh(case.target)
    scored = _scorer(case, source, target, scoring)
    found = scored.score_map(dense)
    return {
        "pairs": [],
        "confidence": [],
        "kind": [],
        "direct": [],
        "mirrored": None if found["mirrored"] is None else [],
        "heat_difference": found["heat_difference"],
        "diameter": scored.diameter,
        "area": mesh_area(target),
        "coverage": {},
        "ranking": None,
        "dense": _dense(found),
        "warnings": [],
        "timings": {"scoring": time.perf_counter() - start},
    }


@lru_cache(maxsize=8)
def _load_surface(path: Path) -> Surface:
    return Surface.load(path)


def _scorer(case: Case, source: Mesh, target: Mesh, scoring: str) -> Scorer:
    return Scorer(case, source, target, scoring, cached_diameter(target, scoring))


def _numbers(values: np.ndarray | None) -> list[float | None] | None:
    """For JSON, to nine digits; null where there is none."""
    return None if values is None else [None if v != v else float(f"{v:.9g}") for v in values.tolist()]


def _peak_memory() -> float | None:
    """The most memory that this process has used, in MB, where the system tells."""
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)
