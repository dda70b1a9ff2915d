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
from .config import merge, read_config
from .match import NoCache, Quiet, Verbose
from .output import STDOUT, make_folder, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..settings import PrepareSettings


def prepare(
    meshes: Annotated[
        list[Path], Argument(metavar="MESH...", help="Mesh files (OFF, OBJ, PLY, STL, GLB, glTF or VTK).")
    ],
    output: Annotated[Path, Option("--output", "-o", metavar="DIR", help="Folder for the files, made if need be.")],
    json: Annotated[bool, Option("--json", help="Print a JSON list, one entry a mesh, instead of a table.")] = False,
    samples: Annotated[int | None, Option(metavar="N", help="Sample points on each surface.  [default: 100]")] = None,
    preset: Annotated[str | None, Option(metavar="paper", help="The paper's published settings.")] = None,
    geodesics: Annotated[
        str | None,
        Option(metavar="heat|dijkstra", help="How geodesic distances are computed.  [default: heat]"),
    ] = None,
    triangulation: Annotated[
        str | None,
        Option(
            metavar="delaunay|mesh",
            help="Flatten the intrinsic Delaunay triangulation or the mesh's own.  [default: delaunay]",
        ),
    ] = None,
    config: Annotated[
        Path | None, Option(metavar="FILE", help="TOML file with settings of 'mobius match'; options here win.")
    ] = None,
    jobs: Annotated[int | None, Option(metavar="N", help="Processes.  [default: one for each processor]")] = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Prepare meshes once, for many matches.

    Each mesh gets a file in DIR, named after it (cat0.off: DIR/cat0.npz), which every command takes in place of
    the mesh. Ends with 3 if no mesh can be prepared, with 5 if some of several cannot.
    """
    from ..settings import make_settings

    options = {"preset": preset, "samples": samples, "geodesics": geodesics, "triangulation": triangulation}
    given = {name: value for name, value in {**options, "jobs": jobs}.items() if value is not None}
    settings = make_settings(**merge(read_config(config) if config else {}, given))
    make_folder(output)
    tasks = {
        str(path): (path, output / name, settings.preparation(), not no_cache, verbose and not quiet)
        for path, name in file_names(meshes).items()
    }
    found: dict[str, dict[str, Any]] = {}
    with Reporter(quiet, verbose) as reporter:
        reporter.progress("meshes", 0, len(tasks))
        results = _results(tasks, settings.jobs or os.cpu_count() or 1, reporter)
        for done, (name, entry) in enumerate(results, start=1):
            found[name] = entry
            reporter.progress("meshes", done, len(tasks))
    entries = [found[name] for name in tasks]
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
    """A file name for each mesh, cat0.npz for cat0.off; cat0-2.npz if that is taken, and so on."""
    names: dict[Path, str] = {}
    taken = set()
    for path in meshes:
        if path in names:
            continue
        name, number = path.stem, 1
        while name.casefold() in taken:  # there are file systems to which Cat0 and cat0 are one
            number += 1
            name = f"{path.stem}-{number}"
        taken.add(name.casefold())
        names[path] = f"{name}.npz"
    return names


def _results(tasks: dict[str, tuple[Any, ...]], jobs: int, reporter: Reporter) -> Iterator[tuple[str, dict[str, Any]]]:
    """The name and the entry of each mesh, in the order in which they end."""
    from .._core.processes import DIED, Died, Workers

    processes = min(jobs, len(tasks))
    if processes == 1:  # here it takes less time than a new process takes to start
        with reporter.compiling():
            yield from ((name, _prepare(*task)) for name, task in tasks.items())
        return
    with Workers(processes) as workers:
        for name, entry in workers.results(_prepare, tasks):
            yield name, _failed(Path(name), f"{name}: {DIED}") if entry is Died else entry


def _prepare(path: Path, out: Path, settings: PrepareSettings, cache: bool, verbose: bool) -> dict[str, Any]:
    """Prepare a mesh; an error is an entry, not an end."""
    import multiprocessing

    from ..surface.prepare import prepare
    from ..surface.storage import ENDING

    if verbose and multiprocessing.parent_process() is not None:
        logging.basicConfig(format="%(message)s", level=logging.INFO)
    start = time.perf_counter()
    try:
        if path.suffix.lower() == ENDING:
            raise FormatError(f"{path}: is prepared already, it seems; name the mesh")
        surface = prepare(path, settings, cache=cache)
        surface.save(out)
    except MobiusError as error:
        return _failed(path, str(error))
    except Exception as error:  # noqa: BLE001  # one mesh must not end the others
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
    table.add_column("prepared", overflow="fold")
    table.add_column("vertices", justify="right")
    table.add_column("seconds", justify="right")
    for entry in entries:
        if entry["error"] is None:
            table.add_row(entry["mesh"], entry["surface"], str(entry["vertices"]), f"{entry['seconds']:.2f}")
        else:
            table.add_row(entry["mesh"], "failed", "", "")
    return table
