"""``mobius prepare MESH... -o DIR``."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from ..errors import FormatError, MobiusError
from .common import SOME_FAILED, UNUSABLE, Reporter, say
from .config import given_settings
from .options import (
    Config,
    Geodesics,
    NoCache,
    Pieces,
    Preset,
    Processes,
    Quiet,
    Samples,
    Triangulation,
    Verbose,
)
from .output import STDOUT, make_folder, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..settings import PrepareSettings


def prepare(
    meshes: Annotated[
        list[Path], Argument(metavar="MESH...", help="Mesh files (OFF, OBJ, PLY, STL, GLB, glTF or VTK).")
    ],
    output: Annotated[Path, Option("--output", "-o", metavar="DIR", help="Output folder, created if needed.")],
    json: Annotated[
        bool, Option("--json", help="Print a JSON list with one entry per mesh instead of a table.")
    ] = False,
    samples: Samples = None,
    preset: Preset = None,
    geodesics: Geodesics = None,
    triangulation: Triangulation = None,
    pieces: Pieces = None,
    config: Config = None,
    jobs: Processes = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Prepare meshes once, for many matches.

    Writes one file per mesh to DIR (DIR/cat0.npz for cat0.off), which every command accepts in place of the mesh.
    The exit code is 3 if no mesh can be prepared, 5 if some of several cannot.
    """
    from ..settings import make_settings

    settings = make_settings(
        **given_settings(
            config,
            preset=preset,
            samples=samples,
            geodesics=geodesics,
            triangulation=triangulation,
            pieces=pieces,
            jobs=jobs,
        )
    )
    make_folder(output)
    tasks = {
        str(path): (path, output / name, settings.preparation(), not no_cache, verbose and not quiet)
        for path, name in file_names(meshes).items()
    }
    entry_of: dict[str, dict[str, Any]] = {}
    with Reporter(quiet, verbose) as reporter:
        reporter.progress("meshes", 0, len(tasks))
        results = _results(tasks, settings.jobs or os.cpu_count() or 1, reporter)
        for done, (name, entry) in enumerate(results, start=1):
            entry_of[name] = entry
            reporter.progress("meshes", done, len(tasks))
    entries = [entry_of[name] for name in tasks]
    for entry in entries:
        if entry["error"] is not None:
            say(f"error: {entry['error']}")
    if json:
        write(STDOUT, to_json(entries))
    else:
        print_table(_table(entries))
    failed = sum(entry["error"] is not None for entry in entries)
    if failed:
        raise SystemExit(UNUSABLE if failed == len(entries) else SOME_FAILED)


def file_names(meshes: list[Path]) -> dict[Path, str]:
    """A file name for each mesh: cat0.npz for cat0.off, or cat0-2.npz and so on if that is taken."""
    names: dict[Path, str] = {}
    used = set()
    for path in meshes:
        if path in names:
            continue
        name, number = path.stem, 1
        while name.casefold() in used:  # some file systems do not distinguish Cat0 from cat0
            number += 1
            name = f"{path.stem}-{number}"
        used.add(name.casefold())
        names[path] = f"{name}.npz"
    return names


def _results(tasks: dict[str, tuple[Any, ...]], jobs: int, reporter: Reporter) -> Iterator[tuple[str, dict[str, Any]]]:
    """The name and the entry of each mesh, in the order in which they are finished."""
    from .._core.processes import DIED, Died, Workers

    processes = min(jobs, len(tasks))
    if processes == 1:  # faster here than in a new process
        with reporter.compiling():
            yield from ((name, _prepare(*task)) for name, task in tasks.items())
        return
    with Workers(processes) as workers:
        for name, entry in workers.results(_prepare, tasks):
            yield name, _failed(Path(name), f"{name}: {DIED}") if entry is Died else entry


def _prepare(path: Path, out: Path, settings: PrepareSettings, cache: bool, verbose: bool) -> dict[str, Any]:
    """Prepare a mesh and save it; an error goes into the entry, so that the other meshes are still prepared."""
    import multiprocessing

    from ..surface.prepare import prepare
    from ..surface.storage import ENDING

    if verbose and multiprocessing.parent_process() is not None:
        logging.basicConfig(format="%(message)s", level=logging.INFO)
    start = time.perf_counter()
    try:
        if path.suffix.lower() == ENDING:
            raise FormatError(f"{path}: looks like a prepared surface; give the mesh file")
        surface = prepare(path, settings, cache=cache)
        surface.save(out)
    except MobiusError as error:
        return _failed(path, str(error))
    except Exception as error:  # noqa: BLE001  # one mesh must not stop the others
        return _failed(path, f"{path}: {type(error).__name__}: {error}")
    return {
        "mesh": str(path),
        "surface": str(out),
        "vertices": surface.mesh.n_file_vertices,
        "samples": len(surface.samples),
        "seconds": time.perf_counter() - start,
        "warnings": [*surface.mesh.notes, *surface.warnings],
        "error": None,
    }


def _failed(path: Path, message: str) -> dict[str, Any]:
    return {"mesh": str(path), "surface": None, "error": message}


def _table(entries: list[dict[str, Any]]) -> Table:
    from rich.table import Table

    table = Table()
    table.add_column("mesh", overflow="fold")
    table.add_column("prepared surface", overflow="fold")
    table.add_column("vertices", justify="right")
    table.add_column("seconds", justify="right")
    for entry in entries:
        if entry["error"] is None:
            table.add_row(entry["mesh"], entry["surface"], str(entry["vertices"]), f"{entry['seconds']:.2f}")
        else:
            table.add_row(entry["mesh"], "failed", "", "")
    return table
