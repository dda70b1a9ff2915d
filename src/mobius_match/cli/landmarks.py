"""``mobius landmarks FILE RESULT -o OUT``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from .common import Reporter
from .options import Back, NoCache, Quiet, ResultFile, System, Verbose
from .output import check_output, write
from .results import load_map

if TYPE_CHECKING:
    import numpy as np

    from ..landmarks.tables import Landmarks
    from ..transfer.transfer import Transfer

LISTED = 20
"""Names that a line lists at most."""


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
        Option("--output", "-o", metavar="OUT", help="File for the landmarks on the target, in one of these formats."),
    ],
    back: Back = False,
    specimen: Annotated[
        str | None, Option(metavar="NAME", help="Specimen to take if FILE has several, by name or by number from 0.")
    ] = None,
    coordinate_system: System = "LPS",
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Transfer landmarks from one matched shape to the other by the dense map.

    Each landmark is first moved to the nearest point of its surface. Landmarks without counterpart are left out.
    """
    from ..errors import NothingFoundError
    from ..landmarks.formats import landmark_writer, read_landmarks
    from ..landmarks.slicer import check_system

    check_output("--output", output, [given, result])
    check_system(coordinate_system)
    write_landmarks = landmark_writer(output)
    marks = read_landmarks(given, specimen, coordinate_system=coordinate_system)
    with Reporter(quiet, verbose) as reporter:
        import numpy as np

        if marks.points is not None:
            marks = _select(marks, ~np.isnan(marks.points).any(axis=1), "missing in the file", reporter)
        surface_map = load_map(result, reporter, cache=not no_cache, back=back)

        from ..transfer.transfer import Transfer

        transfer = Transfer(surface_map)
        images, distances = transfer.landmarks(marks)
        _report_far(marks, distances, transfer, reporter)
        images = _select(images, images.vertices >= 0, "without counterpart", reporter)
        if not len(images):
            raise NothingFoundError(f"{given}: none of its landmarks has a counterpart on {transfer.target.name}")
        direction = "target -> source" if back else "source -> target"
        comment = f"mobius-match; landmarks of {given.name} transferred {direction} to {transfer.target.name}"
        write(output, write_landmarks([replace(images, specimen=transfer.target.name)], comment, coordinate_system))
        reporter.notes([f"{len(images)} landmarks on {transfer.target.name} written to {output}"])


def _select(marks: Landmarks, selected: np.ndarray, reason: str, reporter: Reporter) -> Landmarks:
    """The selected landmarks; a line lists the others."""
    if not selected.all():
        reporter.notes([f"left out, {reason}: {_listed(marks[~selected].names)}"])
    return marks[selected]


def _listed(names: list[str]) -> str:
    return ", ".join(names[:LISTED]) + (f" and {len(names) - LISTED} more" if len(names) > LISTED else "")


def _report_far(marks: Landmarks, distances: np.ndarray, transfer: Transfer, reporter: Reporter) -> None:
    """A line on the landmarks that do not lie on the surface."""
    import numpy as np

    from ..landmarks.tables import FAR

    far = distances > FAR * float(np.linalg.norm(np.ptp(transfer.source.vertices, axis=0)))
    if far.any():
        reporter.notes(
            [
                f"{int(far.sum())} of {len(marks)} landmarks lie up to {distances.max():.3g} units off the surface of "
                f"{transfer.source.name} ({_listed(marks[far].names)}): check that they belong to this mesh, in its "
                "units and its coordinate system"
            ]
        )
