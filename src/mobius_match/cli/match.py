"""``mobius match SOURCE TARGET``."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from ..settings import LEAST_ALIGNMENT_PROBABILITY, make_settings
from .common import NOTHING_FOUND, Reporter, say
from .config import given_settings
from .options import (
    Config,
    Geodesics,
    NoCache,
    Pieces,
    Preset,
    Quiet,
    Samples,
    Seed,
    Threads,
    Triangulation,
    Verbose,
    Votes,
)
from .output import ROWS, STDOUT, check_output, check_outputs, number_omitted, print_table, to_json, write
from .results import draw

if TYPE_CHECKING:
    from rich.table import Table

    from ..results.correspondence import Correspondence


def match(
    source: Annotated[
        Path,
        Argument(
            metavar="SOURCE",
            help="Mesh to match from (OFF, OBJ, PLY, STL, GLB, glTF or VTK), or a file of 'mobius prepare'.",
        ),
    ],
    target: Annotated[Path, Argument(metavar="TARGET", help="Mesh to match to.")],
    output: Annotated[
        Path | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write the result as .json, .csv or another format of 'mobius convert'; '-' prints JSON.",
        ),
    ] = None,
    dense: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            help="Write the dense map: one line per source vertex with its target vertex, or -1 for none. "
            "A .npz file holds the exact positions too.",
        ),
    ] = None,
    picture: Annotated[Path | None, Option(metavar="FILE.png", help="Draw both surfaces with their matches.")] = None,
    html: Annotated[
        Path | None,
        Option(
            metavar="FILE.html",
            help="Write an interactive page with both shapes and their matches; with --dense also the dense map.",
        ),
    ] = None,
    json: Annotated[bool, Option("--json", help="Print the result as JSON instead of a table.")] = False,
    landmarks: Annotated[
        list[Path] | None,
        Option(
            metavar="FILE",
            help="Known pairs: a table with the columns source and target (vertex numbers from 0). Or, given twice, "
            "landmarks of the source and of the target (.mrk.json, .fcsv, .tps, .pts, .pp, .csv ...), paired by name.",
        ),
    ] = None,
    samples: Samples = None,
    votes: Votes = None,
    proposal: Annotated[
        str | None,
        Option(
            metavar="guided|uniform",
            help="How triplets are drawn: guided by geodesic distances, or uniformly as in the paper.  "
            "[default: guided]",
        ),
    ] = None,
    preset: Preset = None,
    distance: Annotated[
        str | None,
        Option(metavar="euclidean|spherical", help="Distance between mapped points.  [default: euclidean]"),
    ] = None,
    min_fraction: Annotated[
        float | None,
        Option(
            metavar="F",
            help="The paper's K as a fraction of the samples: triplets with fewer mutually nearest pairs do not "
            "vote.  [default: 0.4 for uniform proposals, 0 for guided]",
        ),
    ] = None,
    geodesics: Geodesics = None,
    triangulation: Triangulation = None,
    assignment: Annotated[
        str | None,
        Option(
            metavar="greedy|linear",
            help="How matches are extracted from the votes: one after the other, or all at once as a linear "
            "assignment.  [default: greedy]",
        ),
    ] = None,
    threshold: Annotated[
        float | None,
        Option(
            metavar="S",
            help="Minimum confidence (0 to 1). Matches below it are dropped (with --proposal uniform: kept only if "
            "neighbouring matches support them).  [default: 0.5 times the alignment's probability; 0.1 for uniform]",
        ),
    ] = None,
    spacing: Annotated[
        float | None,
        Option(
            metavar="S",
            help="Minimum distance of the extra matches from the samples and from each other, in units of "
            "sqrt(area) (0 to 0.2). 0.2: samples only.  [default: 0.025]",
        ),
    ] = None,
    reflect: Annotated[
        str | None,
        Option(
            metavar="no|yes|auto",
            help="Match the mirror image of the source, as a left hand with a right one. 'auto' matches both and takes "
            "the mirror image where it fits clearly better.  [default: no]",
        ),
    ] = None,
    pieces: Pieces = None,
    seed: Seed = None,
    jobs: Threads = None,
    config: Config = None,
    alternatives: Annotated[
        bool,
        Option(
            "--alternatives",
            help="Add the other plausible alignments of the two shapes, with their matches, to the JSON.",
        ),
    ] = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find corresponding vertices of two meshes.

    Prints the most confident matches as a table (with --json or '-o -' all matches as JSON). Vertices are numbered
    from 0, in the order of the files. The exit code is 4 if the shapes hardly belong together; what was asked for is
    written all the same.
    """
    settings = given_settings(
        config,
        samples=samples,
        votes=votes,
        proposal=proposal,
        preset=preset,
        distance=distance,
        min_fraction=min_fraction,
        geodesics=geodesics,
        triangulation=triangulation,
        assignment=assignment,
        threshold=threshold,
        spacing=spacing,
        reflect=reflect,
        pieces=pieces,
        seed=seed,
        jobs=jobs,
    )
    make_settings(**settings)  # checked before any mesh is read
    inputs = source, target, *(landmarks or ())
    outputs = {"--output": output, "--dense": dense, "--picture": picture, "--html": html}
    check_outputs(outputs, inputs, {"--picture": ".png", "--html": ".html"})
    _check_format(output, alternatives and not json, inputs)

    with Reporter(quiet, verbose) as reporter:
        result = run_match(source, target, reporter, settings, cache=not no_cache, landmarks=landmarks or None)
        if picture is not None:
            write(picture, draw(result))
            reporter.notes([f"picture written to {picture}"])
        if dense is not None:
            reporter.notes([write_map(result, dense)])
        if html is not None:
            from ..viewer import page

            write(html, page(result, dense=None if dense is None else result.dense()).encode())
            reporter.notes([f"page written to {html}"])
        if output is not None and output != STDOUT:
            files = _write_result(result, output, alternatives)
            reporter.notes([f"{len(result)} correspondences written to {' and '.join(map(str, files))}"])
    if verbose:
        for name, seconds in result.timings.items():
            say(f"{name}: {seconds:.3f} s")
        for name, value in result.diagnostics.items():
            say(f"{name}: {value:.3g}")
    if json or output == STDOUT:
        write(STDOUT, to_json(result.to_dict(alternatives=alternatives)))
    elif output is None and dense is None:
        print_table(_table(result))
    if result.probability is not None and result.probability < LEAST_ALIGNMENT_PROBABILITY:
        raise SystemExit(NOTHING_FOUND)


def run_match(
    source: Path,
    target: Path,
    reporter: Reporter,
    settings: dict[str, Any],
    *,
    cache: bool = False,
    landmarks: list[Path] | None = None,
) -> Correspondence:
    """Match two files, with progress and the notes and warnings of the result on standard error."""
    from ..matching.match import match as match_surfaces

    with reporter.compiling():
        result = match_surfaces(
            source, target, landmarks=landmarks, cache=cache, progress=reporter.progress, **settings
        )
    reporter.notes(result.warnings)
    return result


def write_map(result: Correspondence, path: Path) -> str:
    """Write the dense map; the line that reports it and its quality."""
    from ..evaluation.quality import quality

    surface_map = result.dense()
    write(path, surface_map.to_npz() if path.suffix.lower() == ".npz" else surface_map.text().encode())
    return f"dense map written to {path}: {quality(surface_map)}"


def _check_format(output: Path | None, alternatives: bool, inputs: tuple[Path, ...]) -> None:
    """Check a file of another format than JSON, which cannot hold alternatives."""
    from ..errors import SettingsError
    from ..results.actions import is_result_file

    if output is None or output == STDOUT or is_result_file(output):
        return
    from ..exporting.formats import outputs_of

    if alternatives:
        raise SettingsError(f"--alternatives: {output} cannot hold them; name a .json file, or print them with --json.")
    for path in outputs_of(output, None, None):
        check_output("--output", path, inputs)


def _write_result(result: Correspondence, output: Path, alternatives: bool) -> list[Path]:
    """Write the result in the format of the file's ending; the files that were written."""
    from ..results.actions import is_result_file

    if not is_result_file(output):
        return result.export(output)
    write(output, to_json(result.to_dict(alternatives=alternatives)))
    return [output]


def _table(result: Correspondence) -> Table:
    from rich.table import Table

    omitted = number_omitted(len(result))
    caption = omitted and f"{omitted}: -o FILE writes all, --json prints them"
    table = Table(title=f"{len(result)} correspondences", caption=caption, title_justify="left", caption_justify="left")
    names = (Path(info["path"] or "array").name for info in (result.source_info, result.target_info))
    for heading in ("", *(f"{role} vertex\n{name}" for role, name in zip(("source", "target"), names, strict=True))):
        table.add_column(heading, justify="right")
    table.add_column("confidence", justify="right")
    table.add_column("kind")
    rows = zip(result.pairs.tolist(), result.confidence.tolist(), result.kind.tolist(), strict=True)
    given = 0 if result.given is None else int(result.given.sum())
    for number, ((i, j), confidence, kind) in enumerate(islice(rows, ROWS), start=1):
        table.add_row(str(number), str(i), str(j), f"{confidence:.3f}", "given" if number <= given else kind)
    return table
