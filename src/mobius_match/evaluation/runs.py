"""Runs over all pairs of a data set, in several processes, and the folder with their records.

``run.json`` describes the data and the settings; ``pairs/NAME.json`` is the record of a pair. Each file appears whole
or not at all, so an interrupted run can be resumed.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from .._core.display import one_line
from .._core.files import write_atomically
from .._core.processes import DIED, Died, Workers
from .._core.threads import Progress
from .._core.versions import software
from ..errors import FormatError, SettingsError
from ..settings import MatchSettings, make_settings
from .datasets import Case, Dataset
from .work import failed, match_pair, prepare_one, record_of, score_dense, surface_path

FORMAT = "mobius-match/bench-run"
VERSION = 1


@dataclass(frozen=True, eq=False)
class Run:
    """A run: its folder, the content of ``run.json``, and the records of the pairs in order."""

    folder: Path
    info: dict[str, Any]
    records: list[dict[str, Any]]

    def __repr__(self) -> str:
        return one_line(self)


def run(
    dataset: Dataset,
    out: str | os.PathLike[str],
    *,
    scoring: str = "exact",
    jobs: int | None = None,
    resume: bool = False,
    maps: str | os.PathLike[str] | None = None,
    index_base: int | None = None,
    dense: bool = False,
    preset: str | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> Run:
    """Match all pairs of a data set, or score dense maps of another program, and measure the errors.

    Parameters
    ----------
    dataset
        The pairs, as :func:`find_dataset` returns them.
    out
        Folder for the records; created if necessary.
    scoring
        Geodesic distances of the errors: ``"exact"``, or ``"heat"``, which is faster.
    jobs
        Number of processes; None for every processor. The result does not depend on it.
    resume
        Continue the run in ``out``; failed pairs are tried again.
    maps
        Folder of dense maps, which are scored instead of matching: ``PAIR.txt`` (``cat0-cat1.txt``) has one line for
        each vertex of the source, its target vertex or -1 for none.
    index_base
        Number of the first vertex in these files, 0 or 1; required with ``maps``.
    dense
        Also compute and score the dense map of each pair.
    preset, **settings
        As for :func:`mobius_match.match`.
    progress
        Called as ``progress(stage, done, total)``.

    Raises
    ------
    SettingsError
        If a setting is out of range, or ``out`` holds a run and ``resume`` is not set, or the run differs from this
        one.

    Notes
    -----
    This starts processes, so a script that calls it needs ``if __name__ == "__main__":``.
    """
    match_settings = make_settings(preset, **{**settings, "jobs": 1})
    if scoring not in ("exact", "heat"):
        raise SettingsError(f"`scoring` is {scoring!r}; choose one of exact, heat")
    if (maps is None) != (index_base is None) or index_base not in (None, 0, 1):
        raise SettingsError("`maps` and `index_base` (0 or 1, the number of the first vertex) must be given together")
    if jobs is not None and not 1 <= jobs <= 1024:
        raise SettingsError(f"`jobs` is {jobs}; give a number from 1 to 1024")
    folder = Path(out)
    measurement = {"geodesics": scoring} | ({"dense": True} if dense else {})
    info = _describe(dataset, match_settings, preset, measurement, maps, index_base)
    _open(folder, info, resume)
    report = progress or (lambda stage, done, total: None)
    waiting = {case.name: case for case in dataset.cases if not _is_done(_record_path(folder, case.name))}
    with Workers(min(jobs or os.cpu_count() or 1, max(len(waiting), 1))) as workers:
        unusable = {} if maps is not None else _prepare_all(waiting, folder, match_settings, workers, report)
        tasks: dict[str, tuple[Any, ...]] = {}
        for case in waiting.values():
            errors = [unusable[str(path)] for path in (case.source, case.target) if str(path) in unusable]
            if errors:
                _write_record(folder, failed(case, errors[0]))
            elif maps is None:
                tasks[case.name] = (match_pair, case, scoring, folder, match_settings, dense)
            else:
                tasks[case.name] = (score_dense, case, scoring, Path(maps) / f"{case.name}.txt", index_base)
        total = len(dataset.cases)
        report("pairs", total - len(tasks), total)
        for done, (name, record) in enumerate(workers.results(record_of, tasks), start=total - len(tasks) + 1):
            _write_record(folder, failed(waiting[name], DIED) if record is Died else record)
            report("pairs", done, total)
    shutil.rmtree(folder / "surfaces", ignore_errors=True)
    return load_run(folder)


def load_run(folder: str | os.PathLike[str]) -> Run:
    """Read the folder of a run. Pairs that are not done yet have no record.

    Raises
    ------
    FormatError
        If the folder holds no run of this version, or a damaged one.
    """
    folder = Path(folder)
    info = _read_json(folder / "run.json")
    if not isinstance(info, dict) or (info.get("format"), info.get("version")) != (FORMAT, VERSION):
        raise FormatError(f"{folder / 'run.json'}: not a run that this version reads; run it again")
    paths = [_record_path(folder, name) for name in info["cases"]]
    return Run(folder, info, [_read_json(path) for path in paths if path.exists()])


def _describe(
    dataset: Dataset,
    settings: MatchSettings,
    preset: str | None,
    scoring: dict[str, Any],
    maps: str | os.PathLike[str] | None,
    index_base: int | None,
) -> dict[str, Any]:
    """The content of run.json."""
    recorded = {name: value for name, value in settings.to_dict().items() if name != "jobs"}
    return {
        "format": FORMAT,
        "version": VERSION,
        "dataset": {"path": str(dataset.path), "layout": dataset.layout, "sha256": _digest(dataset)},
        "settings": {**recorded, "preset": preset},
        "scoring": scoring,
        "maps": None if maps is None else {"folder": str(maps), "index_base": index_base},
        "software": software(),
        "cases": [case.name for case in dataset.cases],
    }


def _digest(dataset: Dataset) -> str:
    """One digest of all meshes, known correspondences and pairs."""
    digest = hashlib.sha256()

    @cache
    def file(path: Path) -> bytes:
        return hashlib.sha256(path.read_bytes()).digest()

    for case in dataset.cases:
        digest.update(f"{case.name}\n{case.category}\n{case.truth.landmarks}\n".encode())
        digest.update(file(case.source) + file(case.target))
        for values in (case.truth.source, case.truth.target, case.truth.mirrored):
            digest.update(b"-" if values is None else hashlib.sha256(values.astype("<i8").tobytes()).digest())
    return digest.hexdigest()


def _open(folder: Path, info: dict[str, Any], resume: bool) -> None:
    """Create the folder of a new run, or check that an existing run is the same."""
    path = folder / "run.json"
    if path.exists():
        if not resume:
            raise SettingsError(f"{folder} already holds a run; continue it with `resume`, or choose another folder")
        existing = load_run(folder).info
        names = {"dataset": "meshes, known correspondence or pairs", "cases": "pairs", "maps": "dense maps"}
        for part in ("dataset", "settings", "scoring", "maps", "software", "cases"):
            old, new = (x[part] if isinstance(x[part], dict) else {part: x[part]} for x in (existing, info))
            for key in old | new:
                if old.get(key) != new.get(key) and key not in ("path", "folder"):
                    difference = names.get(part, f"{part}, {key}")
                    raise SettingsError(
                        f"{folder} holds a run with other {difference} ({old.get(key)!r:.80}, now "
                        f"{new.get(key)!r:.80}), which cannot be resumed; choose another folder"
                    )
    try:
        for part in ("pairs", "surfaces"):
            (folder / part).mkdir(parents=True, exist_ok=True)
            for incomplete in (folder / part).glob(".*"):  # of a run that was killed
                incomplete.unlink()
        if not path.exists():
            write_atomically(path, _json(info))
    except OSError as error:
        raise SettingsError(f"the folder {folder} cannot be written ({error.strerror}); choose another") from error


def _prepare_all(
    cases: dict[str, Case], folder: Path, settings: MatchSettings, workers: Workers, report: Progress
) -> dict[str, str]:
    """Prepare each mesh once; return the error messages of those that cannot be prepared, by path."""
    needed = {str(path) for case in cases.values() for path in (case.source, case.target)}
    tasks = {
        path: (path, surface_path(folder, path), settings)
        for path in sorted(needed)
        if not surface_path(folder, path).exists()
    }
    unusable = {}
    report("meshes", len(needed) - len(tasks), len(needed))
    results = workers.results(prepare_one, tasks)
    for done, (path, error) in enumerate(results, start=len(needed) - len(tasks) + 1):
        if error is not None:
            unusable[path] = DIED if error is Died else error
        report("meshes", done, len(needed))
    return unusable


def _record_path(folder: Path, name: str) -> Path:
    return folder / "pairs" / f"{name}.json"


def _is_done(path: Path) -> bool:
    return path.exists() and _read_json(path).get("status") == "done"


def _write_record(folder: Path, record: dict[str, Any]) -> None:
    write_atomically(_record_path(folder, record["name"]), _json(record))


def _json(content: Any) -> bytes:
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise FormatError(f"{path}: cannot be read ({error}); check that this is the folder of a run") from error
