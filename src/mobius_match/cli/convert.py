"""``mobius convert RESULT OUT``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from .common import Reporter
from .match import Quiet, Verbose
from .output import STDOUT, check_output

System = Annotated[
    str,
    Option(
        metavar="LPS|RAS",
        help="What the coordinates of the meshes are, for files that say so: in other files nothing tells. Slicer "
        "takes meshes for LPS.",
    ),
]


def convert(
    result: Annotated[
        Path,
        Argument(
            metavar="RESULT",
            help="Result of 'mobius match -o', or a dense map alone (.npz, of 'mobius match --dense').",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path,
        Argument(
            metavar="OUT",
            help="File to write: .csv, .mrk.json, .fcsv, .tps, .morphologika, .pts, .pp, .ply, .glb, .npz, .mat or "
            ".txt. Where a file holds one shape, two are written, OUT with -source and -target in the name.",
            show_default=False,
        ),
    ],
    format: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="csv, slicer, fcsv, tps, morphologika, pts, pp, ply, glb, npz, mat or text.  [default: as OUT ends]",
        ),
    ] = None,
    min_confidence: Annotated[float, Option(metavar="F", help="Leave out matches of less confidence (0 to 1).")] = 0.0,
    side: Annotated[
        str | None, Option(metavar="source|target", help="Only the landmarks, or the mesh, of this shape.")
    ] = None,
    dense: Annotated[
        Path | None,
        Option(metavar="MAP.npz", help="The dense map, for .npz, .mat and .txt, and to colour meshes by."),
    ] = None,
    coordinate_system: System = "LPS",
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write a result for other programs: landmarks of both shapes, coloured meshes, tables and arrays.

    Number k of the source corresponds to number k of the target. Coordinates are those of the mesh files, which are
    read again from where they were.
    """
    from ..errors import SettingsError
    from ..exporting import export, outputs_of
    from ..results.correspondence import Correspondence
    from ..results.surface_map import SurfaceMap

    if out == STDOUT:
        raise SettingsError("OUT is a file, not standard output; name one.")
    for path in outputs_of(out, format, side):
        check_output("OUT", path, [result] if dense is None else [result, dense])
    with Reporter(quiet, verbose) as reporter:
        found = (SurfaceMap if result.suffix.lower() == ".npz" else Correspondence).load(result)
        written = export(
            found,
            out,
            format=format,
            side=side,
            min_confidence=min_confidence,
            dense=None if dense is None else SurfaceMap.load(dense),
            coordinate_system=coordinate_system,
        )
        reporter.notes([f"written: {', '.join(map(str, written))}"])
