"""``mobius symmetry MESH``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from .common import Reporter, say
from .match import NoCache, Quiet, Verbose, draw
from .output import STDOUT, check_output, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..results.symmetry import Symmetry


def symmetry(
    mesh: Annotated[Path, Argument(metavar="MESH", help="Mesh file, or one of 'mobius prepare'.")],
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="FILE", help="Write the result as JSON; '-' is standard output."),
    ] = None,
    picture: Annotated[
        Path | None,
        Option(metavar="FILE.png", help="Draw the mesh twice: what has one colour left and right is mirrored."),
    ] = None,
    json: Annotated[bool, Option("--json", help="Print the result as JSON instead of a table.")] = False,
    samples: Annotated[int | None, Option(metavar="N", help="Sample points.  [default: 100]")] = None,
    votes: Annotated[
        int | None, Option(metavar="N", help="Triplets to evaluate.  [default: the program's choice]")
    ] = None,
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
    seed: Annotated[
        int | None, Option(metavar="N", help="Same seed, same result, whatever --jobs.  [default: 0]")
    ] = None,
    jobs: Annotated[int | None, Option(metavar="N", help="Threads.  [default: every processor]")] = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find the mirror symmetry of one mesh in any pose: left against right.

    The pairs of mirrored vertices are printed as a table (with --json or '-o -' as JSON), highest confidence
    first, with a score from 0 to 1 (perfectly symmetric) and, in the JSON, the vertices that stay in place.
    Vertices are numbered from 0, as in the file.
    """
    options = {
        "samples": samples,
        "votes": votes,
        "geodesics": geodesics,
        "triangulation": triangulation,
        "seed": seed,
        "jobs": jobs,
    }
    settings: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    _check(settings, output, picture, mesh)

    from ..matching.symmetry.symmetry import symmetry as find_symmetry

    with Reporter(quiet, verbose) as reporter, reporter.compiling():
        result = find_symmetry(mesh, cache=not no_cache, progress=reporter.progress, **settings)
        reporter.notes(result.warnings)
        content = to_json(result.to_dict())
        if picture is not None:
            write(picture, _draw(result))
            reporter.notes([f"picture written to {picture}"])
        if output is not None and output != STDOUT:
            write(output, content)
            reporter.notes([f"{len(result)} pairs, score {result.score:.2f}, written to {output}"])
    if verbose:
        for name, seconds in result.timings.items():
            say(f"{name}: {seconds:.3f} s")
    if json or output == STDOUT:
        write(STDOUT, content)
    elif output is None:
        print_table(_table(result))


def _check(settings: dict[str, Any], output: Path | None, picture: Path | None, mesh: Path) -> None:
    from ..errors import SettingsError
    from ..results.actions import check_json
    from ..settings import make_settings

    make_settings(**settings)
    if output is not None:
        check_output("--output", output, [mesh])
    if picture is not None:
        if picture.suffix.lower() != ".png":
            raise SettingsError(f"--picture: {picture} is not a .png file; name it so.")
        check_output("--picture", picture, [mesh])
        if output is not None and output.resolve() == picture.resolve():
            raise SettingsError(f"--picture: {picture} is the --output too; name another file.")
    if output is not None and output != STDOUT:
        check_json(output)


def _draw(result: Symmetry) -> bytes:
    """The mesh beside itself: the points of both halves in their colours, and those of their images."""
    import numpy as np

    from ..results.correspondence import Correspondence

    both_ways = np.stack([result.pairs, result.pairs[:, ::-1]], axis=1).reshape(-1, 2)
    return draw(
        Correspondence(
            pairs=both_ways,
            confidence=np.repeat(result.confidence, 2),
            kind=np.full(len(both_ways), "voted"),
            source_info=result.source_info,
            target_info=result.source_info,
            settings=result.settings,
            source=result.source,
            target=result.source,
        )
    )


def _table(result: Symmetry) -> Table:
    from rich.table import Table

    title = f"{len(result)} pairs, score {result.score:.2f}\n{len(result.stationary)} vertices stay in place"
    table = Table(title=title, title_justify="left")
    for heading in ("", "vertex", "mirrored", "confidence"):
        table.add_column(heading, justify="right")
    rows = zip(result.pairs.tolist(), result.confidence.tolist(), strict=True)
    for number, ((i, j), confidence) in enumerate(rows, start=1):
        table.add_row(str(number), str(i), str(j), f"{confidence:.3f}")
    return table
