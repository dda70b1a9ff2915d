"""The tasks of a run's processes: prepare a mesh, or match and score a pair. Errors become records."""

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
from ..mesh.pieces import all_pieces
from ..settings import MatchSettings
from ..surface.prepare import matchable_mesh, prepare
from ..surface.surface import Surface
from .datasets import Case
from .scoring import Scorer, cached_diameter, mesh_area
from .vertexlists import read_vertices


def prepare_one(path: str, out: Path, settings: MatchSettings) -> str | None:
    """Prepare a mesh and save it; the error message if that fails."""
    try:
        prepare(path, settings.preparation()).save(out)
    except Exception as error:  # noqa: BLE001  # the run continues without this mesh
        return _message(error)
    return None


def surface_path(folder: Path, mesh: str | Path) -> Path:
    """The file of a prepared mesh in the folder of a run in progress."""
    return folder / "surfaces" / f"{hashlib.sha256(str(mesh).encode()).hexdigest()[:32]}.npz"


def record_of(work: Callable[..., dict[str, Any]], case: Case, *arguments: Any) -> dict[str, Any]:
    """The record of a pair: that of ``work``, or of its error."""
    try:
        return {**_head(case), "status": "done", "error": None, **work(case, *arguments), "memory_mb": _peak_memory()}
    except Exception as error:  # noqa: BLE001  # the run continues without this pair
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
    """Match two prepared meshes, and score the matches and, if ``dense``, the dense map."""
    source, target = (_load_surface(surface_path(folder, path)) for path in (case.source, case.target))
    result = match(source, target, parameters=parameters, **settings.to_dict())
    timings = {f"source {name}": seconds for name, seconds in source.timings.items()}
    timings |= {f"target {name}": seconds for name, seconds in target.timings.items()}
    timings |= {name: seconds for name, seconds in result.timings.items() if name not in ("reading", "total")}
    start = time.perf_counter()
    surface_map = result.dense() if dense else None
    if surface_map:
        timings["dense map"] = time.perf_counter() - start
    timings["total"] = sum(timings.values())
    start = time.perf_counter()
    meshes = all_pieces(source.whole_mesh), all_pieces(target.whole_mesh)
    scorer = _scorer(case, *meshes, scoring)
    scores = scorer.score(result.pairs, result.confidence)
    dense_record = _dense_record(scorer.score_map(surface_map.vertex_map)) if surface_map else None
    timings["scoring"] = time.perf_counter() - start
    return {
        "pairs": result.pairs.tolist(),
        "confidence": _numbers(result.confidence),
        "kind": result.kind.tolist(),
        "direct": _numbers(scores["direct"]),
        "mirrored": _numbers(scores["mirrored"]),
        "heat_difference": scores["heat_difference"],
        "diameter": scorer.diameter,
        "area": mesh_area(meshes[1]),
        "coverage": scores["coverage"],
        "ranking": scores["ranking"],
        "dense": dense_record,
        "warnings": list(result.warnings),
        "timings": timings,
    }


def _dense_record(scores: dict[str, Any]) -> dict[str, Any]:
    """The entry of a record for a scored dense map."""
    errors = {name: _numbers(scores[name]) for name in ("direct", "mirrored")}
    return {**errors, "unmapped": scores["unmapped"]}


def score_dense(case: Case, scoring: str, path: Path, index_base: int) -> dict[str, Any]:
    """Score a dense map of another program."""
    start = time.perf_counter()
    dense = read_vertices(path, index_base, gaps=True)
    source, target = (all_pieces(matchable_mesh(path)) for path in (case.source, case.target))
    scorer = _scorer(case, source, target, scoring)
    scores = scorer.score_map(dense)
    return {
        "pairs": [],
        "confidence": [],
        "kind": [],
        "direct": [],
        "mirrored": None if scores["mirrored"] is None else [],
        "heat_difference": scores["heat_difference"],
        "diameter": scorer.diameter,
        "area": mesh_area(target),
        "coverage": {},
        "ranking": None,
        "dense": _dense_record(scores),
        "warnings": [],
        "timings": {"scoring": time.perf_counter() - start},
    }


@lru_cache(maxsize=8)
def _load_surface(path: Path) -> Surface:
    return Surface.load(path)


def _scorer(case: Case, source: Mesh, target: Mesh, scoring: str) -> Scorer:
    return Scorer(case, source, target, scoring, cached_diameter(target, scoring))


def _numbers(values: np.ndarray | None) -> list[float | None] | None:
    """Values for JSON with nine digits; None for NaN."""
    return None if values is None else [None if v != v else float(f"{v:.9g}") for v in values.tolist()]


def _peak_memory() -> float | None:
    """Peak memory of this process in MB; None if the system does not report it."""
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)
