"""Arguments and options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

Quiet = Annotated[bool, Option("--quiet", "-q", help="Print results and errors only.")]
Verbose = Annotated[bool, Option("--verbose", "-v", help="Print timings, and the traceback of an error.")]
NoCache = Annotated[bool, Option("--no-cache", help="Prepare the meshes again; neither read nor write the cache.")]

Samples = Annotated[int | None, Option(metavar="N", help="Number of sample points per surface.  [default: 100]")]
Votes = Annotated[
    int | None, Option(metavar="N", help="Number of triplets to evaluate.  [default: chosen automatically]")
]
Preset = Annotated[
    str | None, Option(metavar="paper", help="Use all published settings of the paper; other options override it.")
]
Geodesics = Annotated[
    str | None, Option(metavar="heat|dijkstra", help="How geodesic distances are computed.  [default: heat]")
]
Triangulation = Annotated[
    str | None,
    Option(
        metavar="delaunay|mesh",
        help="Flatten the intrinsic Delaunay triangulation, or the triangles of the mesh itself.  [default: delaunay]",
    ),
]
Pieces = Annotated[
    str | None,
    Option(
        metavar="largest|all|NAME",
        help="The piece that is matched, where there are several: the largest, or one by name (an OBJ group, object or "
        "material, a glTF node or mesh). 'all' matches all pieces that both shapes have.  [default: largest]",
    ),
]
Seed = Annotated[
    int | None, Option(metavar="N", help="Random seed; the result does not depend on --jobs.  [default: 0]")
]
Threads = Annotated[int | None, Option(metavar="N", help="Number of threads.  [default: all processors]")]
Processes = Annotated[int | None, Option(metavar="N", help="Number of processes.  [default: one per processor]")]
Config = Annotated[
    Path | None,
    Option(
        metavar="FILE",
        help="TOML file with settings of 'mobius match', named like its options; options given here override it.",
    ),
]

ResultFile = Annotated[
    Path,
    Argument(
        metavar="RESULT",
        help="Dense map (.npz) of 'mobius match --dense', or result (.json) of 'mobius match -o', for which the "
        "meshes are matched again.",
    ),
]
System = Annotated[
    str,
    Option(
        metavar="LPS|RAS",
        help="Coordinate system of the meshes, for formats that record one. Slicer reads meshes as LPS.",
    ),
]
Back = Annotated[bool, Option("--back", help="From the target to the source.")]
