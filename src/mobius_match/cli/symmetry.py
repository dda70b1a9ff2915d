"""``mobius symmetry MESH``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from ..results.actions import check_json
from ..settings import make_settings
from .common import Reporter, say
from .config import given_settings
from .options import Geodesics, NoCache, Quiet, Samples, Seed, Threads, Triangulation, Verbose, Votes
from .output import STDOUT, check_outputs, print_table, to_json, write
from .results import draw

if TYPE_CHECKING:
    from rich.table import Table

    from ..results.symmetry import Symmetry


def symmetry(
    mesh: Annotated[Path, Argument(metavar="MESH", help="Mesh file, or file of 'mobius prepare'.")],
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="FILE", help="Write the result as JSON; '-' is standard output."),
    ] = None,
    picture: Annotated[
        Path | None,
        Option(metavar="FILE.png", help="Draw the mesh twice, with mirrored points in the same colour."),
    ] = None,
    json: Annotated[bool, Option("--json", help="Print the result as JSON instead of a table.")] = False,
    samples: Samples = None,
    votes: Votes = None,
    geodesics: Geodesics = None,
    triangulation: Triangulation = None,
    seed: Seed = None,
    jobs: Threads = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find the intrinsic left-right symmetry of one mesh, in any pose.

    Prints the pairs of mirrored vertices as a table (with --json or '-o -' as JSON), most confident first, and a
    score from 0 to 1 (perfectly symmetric). The JSON also lists the vertices that are mapped to themselves. Vertices
    are numbered from 0, in the order of the file.
    """
    settings = given_settings(
        samples=samples, votes=votes, geodesics=geodesics, triangulation=triangulation, seed=seed, jobs=jobs
    )
    make_settings(**settings)  # checked before the mesh is read
    check_outputs({"--output": output, "--picture": picture}, [mesh], {"--picture": ".png"})
    if output is not None and output != STDOUT:
        check_json(output)

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


def _draw(result: Symmetry) -> bytes:
    """A picture of the mesh twice: the points of both halves on the left, their images on the right."""
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

    title = f"{len(result)} pairs, score {result.score:.2f}\n{len(result.stationary)} vertices map to themselves"
    table = Table(title=title, title_justify="left")
    for heading in ("", "vertex", "mirrored", "confidence"):
        table.add_column(heading, justify="right")
    rows = zip(result.pairs.tolist(), result.confidence.tolist(), strict=True)
    for number, ((i, j), confidence) in enumerate(rows, start=1):
        table.add_row(str(number), str(i), str(j), f"{confidence:.3f}")
    return table
