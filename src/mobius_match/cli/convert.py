"""``mobius convert RESULT OUT``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from .common import Reporter
from .options import Quiet, System, Verbose
from .output import STDOUT, check_output


def convert(
    result: Annotated[
        Path,
        Argument(
            metavar="RESULT",
            help="Result of 'mobius match -o', or dense map (.npz) of 'mobius match --dense'.",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path,
        Argument(
            metavar="OUT",
            help="File to write: .csv, .mrk.json, .fcsv, .tps, .morphologika, .pts, .pp, .ply, .glb, .npz, .mat or "
            ".txt. Formats that hold one shape get two files, with -source and -target in their names.",
            show_default=False,
        ),
    ],
    format: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="csv, slicer, fcsv, tps, morphologika, pts, pp, ply, glb, npz, mat or text.  [default: from the "
            "ending of OUT]",
        ),
    ] = None,
    min_confidence: Annotated[
        float, Option(metavar="F", help="Leave out matches below this confidence (0 to 1).")
    ] = 0.0,
    side: Annotated[
        str | None, Option(metavar="source|target", help="Write only the landmarks, or the mesh, of this shape.")
    ] = None,
    dense: Annotated[
        Path | None,
        Option(metavar="MAP.npz", help="Dense map, for .npz, .mat and .txt, and to colour meshes."),
    ] = None,
    coordinate_system: System = "LPS",
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Convert a result for other programs: landmarks of both shapes, coloured meshes, tables and arrays.

    Point k of the source corresponds to point k of the target. Coordinates are those of the mesh files, which are
    read again from the paths in the result.
    """
    from ..errors import SettingsError
    from ..exporting import export, outputs_of
    from ..results.correspondence import Correspondence
    from ..results.surface_map import SurfaceMap

    if out == STDOUT:
        raise SettingsError("OUT cannot be standard output; give a file name.")
    for path in outputs_of(out, format, side):
        check_output("OUT", path, [result] if dense is None else [result, dense])
    with Reporter(quiet, verbose) as reporter:
        kind = SurfaceMap if result.suffix.lower() == ".npz" else Correspondence
        written = export(
            kind.load(result),
            out,
            format=format,
            side=side,
            min_confidence=min_confidence,
            dense=None if dense is None else SurfaceMap.load(dense),
            coordinate_system=coordinate_system,
        )
        reporter.notes([f"written: {', '.join(map(str, written))}"])
