"""``mobius landmarks FILE RESULT -o OUT``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from .common import Reporter
from .convert import System
from .match import NoCache, Quiet, Verbose
from .output import check_output, write
from .results import ResultFile, load_map

if TYPE_CHECKING:
    import numpy as np

    from ..landmarks.tables import Landmarks
    from ..transfer.transfer import Transfer

FAR = 0.02
"""Distance from the surface, per diagonal of the mesh's box, from which on a landmark is told to lie beside it."""

LISTED = 20
"""How many names a line lists at most."""


def landmarks(
    given: Annotated[
        Path,
        Argument(
            metavar="FILE",
            help="Landmarks on the source: .mrk.json, .fcsv, .tps, .morphologika, .pts, .pp, .csv or .txt.",
            show_default=False,
        ),
    ],
    result: ResultFile,
    output: Annotated[
        Path,
        Option("--output", "-o", metavar="OUT", help="File for the landmarks on the target, in any of these formats."),
    ],
    back: Annotated[bool, Option("--back", help="From the target to the source.")] = False,
    specimen: Annotated[
        str | None, Option(metavar="NAME", help="Which of several specimens in FILE, by name or by number from 0.")
    ] = None,
    coordinate_system: System = "LPS",
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Carry landmarks from one matched shape to the other, by the dense map.

    Each is moved to the nearest point of the surface first. Those without counterpart are left out.
    """
    from ..errors import NothingFoundError
    from ..landmarks.formats import landmark_writer, read_landmarks
    from ..landmarks.slicer import check_system

    check_output("--output", output, [given, result])
    check_system(coordinate_system)
    make = landmark_writer(output)
    marks = read_landmarks(given, specimen, coordinate_system=coordinate_system)
    with Reporter(quiet, verbose) as reporter:
        import numpy as np

        if marks.points is not None:
            marks = _kept(marks, ~np.isnan(marks.points).any(axis=1), "missing in the file", reporter)
        surface_map = load_map(result, reporter, cache=not no_cache)

        from ..transfer.transfer import Transfer

        carrier = Transfer(surface_map.inverse if back else surface_map)
        carried, apart = carrier.landmarks(marks)
        _tell_far(marks, apart, carrier, reporter)
        carried = _kept(carried, carried.vertices >= 0, "without counterpart", reporter)
        if not len(carried):
            raise NothingFoundError(f"{given}: none of its landmarks has a counterpart on {carrier.target.name}")
        ends = "target -> source" if back else "source -> target"
        comment = f"mobius-match; landmarks of {given.name} carried {ends} onto {carrier.target.name}"
        write(output, make([replace(carried, specimen=carrier.target.name)], comment, coordinate_system))
        reporter.notes([f"{len(carried)} landmarks on {carrier.target.name} written to {output}"])


def _kept(marks: Landmarks, kept: np.ndarray, why: str, reporter: Reporter) -> Landmarks:
    """Those that are kept; a line tells which are not."""
    if not kept.all():
        reporter.notes([f"left out, {why}: {_listed(marks[~kept].names)}"])
    return marks[kept]


def _listed(names: list[str]) -> str:
    return ", ".join(names[:LISTED]) + (f" and {len(names) - LISTED} more" if len(names) > LISTED else "")


def _tell_far(marks: Landmarks, apart: np.ndarray, carrier: Transfer, reporter: Reporter) -> None:
    """A line on the landmarks that lie beside the surface."""
    import numpy as np

    far = apart > FAR * float(np.linalg.norm(np.ptp(carrier.source.vertices, axis=0)))
    if far.any():
        reporter.notes(
            [
                f"{int(far.sum())} of {len(marks)} landmarks lie beside {carrier.source.name}, by up to "
                f"{apart.max():.3g} in its units ({_listed(marks[far].names)}): are they placed on this mesh, in its "
                "units and coordinates?"
            ]
        )
