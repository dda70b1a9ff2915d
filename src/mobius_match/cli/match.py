"""``mobius match SOURCE TARGET``."""

from __future__ import annotations

import io
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from .common import Reporter, say
from .config import merge, read_config
from .output import ROWS, STDOUT, check_output, others_of, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..results.correspondence import Correspondence

Quiet = Annotated[bool, Option("--quiet", "-q", help="Show results and errors only.")]
Verbose = Annotated[bool, Option("--verbose", "-v", help="Show timings, and the traceback of an error.")]
NoCache = Annotated[
    bool, Option("--no-cache", help="Prepare meshes anew; neither look for prepared ones nor keep them.")
]


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
            help="Write the result: .json, or .csv and the other formats of 'mobius convert'; "
            "'-' is standard output, as JSON.",
        ),
    ] = None,
    dense: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            help="Write the target vertex of every source vertex, a line each, -1 for none; as .npz all of the map.",
        ),
    ] = None,
    picture: Annotated[Path | None, Option(metavar="FILE.png", help="Draw the matches on both surfaces.")] = None,
    html: Annotated[
        Path | None,
        Option(metavar="FILE.html", help="Write a page that shows both shapes and their matches, and --dense too."),
    ] = None,
    json: Annotated[bool, Option("--json", help="Print the result as JSON instead of a table.")] = False,
    landmarks: Annotated[
        list[Path] | None,
        Option(
            metavar="FILE",
            help="Pairs that you know: a table with columns source and target (vertices from 0), or given twice, the "
            "source's and the target's landmarks (.mrk.json, .fcsv, .tps, .pts, .pp, .csv ...), paired by name.",
        ),
    ] = None,
    samples: Annotated[int | None, Option(metavar="N", help="Sample points on each surface.  [default: 100]")] = None,
    votes: Annotated[
        int | None, Option(metavar="N", help="Triplets to evaluate.  [default: the program's choice]")
    ] = None,
    proposal: Annotated[
        str | None,
        Option(
            metavar="guided|uniform",
            help="How triplets are drawn; 'uniform' is the paper's.  [default: guided]",
        ),
    ] = None,
    preset: Annotated[
        str | None,
        Option(metavar="paper", help="The paper's published settings, all at once; options given besides it win."),
    ] = None,
    distance: Annotated[
        str | None,
        Option(metavar="euclidean|spherical", help="Distance between mapped points.  [default: euclidean]"),
    ] = None,
    min_fraction: Annotated[
        float | None,
        Option(
            metavar="F",
            help="The paper's K as a fraction of the samples: a triplet with fewer mutually nearest pairs "
            "does not vote.  [default: 0.4 for uniform proposals, 0 for guided]",
        ),
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
    assignment: Annotated[
        str | None,
        Option(metavar="greedy|linear", help="How matches are read off the votes.  [default: greedy]"),
    ] = None,
    threshold: Annotated[
        float | None,
        Option(
            metavar="S",
            help="Least confidence (0 to 1): with guided proposals matches below are left out, with uniform ones "
            "they need the support of others.  [default: 0.5, and 0.1]",
        ),
    ] = None,
    spacing: Annotated[
        float | None,
        Option(
            metavar="S",
            help="Distance per sqrt(area) that matches beyond the samples keep from these and from each other "
            "(0 to 0.2); 0.2 leaves the samples alone.  [default: 0.025]",
        ),
    ] = None,
    seed: Annotated[
        int | None, Option(metavar="N", help="Same seed, same result, whatever --jobs.  [default: 0]")
    ] = None,
    jobs: Annotated[int | None, Option(metavar="N", help="Threads.  [default: every processor]")] = None,
    config: Annotated[
        Path | None,
        Option(metavar="FILE", help="TOML file with settings by the names above; options here win over it."),
    ] = None,
    alternatives: Annotated[
        bool, Option("--alternatives", help="Write the other explanations into the JSON, with their matches.")
    ] = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Find corresponding vertices of two meshes.

    The first matches are printed as a table (with --json or '-o -' all as JSON), highest confidence first.
    Vertices are numbered from 0, as in the files.
    """
    options = {
        "samples": samples,
        "votes": votes,
        "proposal": proposal,
        "preset": preset,
        "distance": distance,
        "min_fraction": min_fraction,
        "geodesics": geodesics,
        "triangulation": triangulation,
        "assignment": assignment,
        "threshold": threshold,
        "spacing": spacing,
        "seed": seed,
        "jobs": jobs,
    }
    given = {name: value for name, value in options.items() if value is not None}
    settings = merge(read_config(config) if config else {}, given)
    outputs = {"--output": output, "--dense": dense, "--picture": picture, "--html": html}
    _check(settings, outputs, (source, target, *(landmarks or ())))
    as_json = _check_format(output, alternatives and not json, (source, target, *(landmarks or ())))

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
            files = [output]
            if as_json:
                write(output, to_json(result.to_dict(alternatives=alternatives)))
            else:
                files = result.export(output)
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


def run_match(
    source: Path,
    target: Path,
    reporter: Reporter,
    settings: dict[str, Any],
    *,
    cache: bool = False,
    landmarks: list[Path] | None = None,
) -> Correspondence:
    """Match two files with progress, and with what was noted on the way shown."""
    from ..matching.match import match as match_surfaces

    with reporter.compiling():
        result = match_surfaces(
            source, target, landmarks=landmarks, cache=cache, progress=reporter.progress, **settings
        )
    reporter.notes(result.warnings)
    return result


def draw(result: Correspondence, **options: Any) -> bytes:
    """The picture of the matches, as the bytes of a PNG file."""
    from ..exporting.figures import draw_matches

    picture = io.BytesIO()
    draw_matches(result, picture, **options)
    return picture.getvalue()


def write_map(result: Correspondence, path: Path) -> str:
    """Write the dense map; the line that says so, and how good it looks."""
    from ..evaluation.quality import quality

    found = result.dense()
    write(path, found.to_npz() if path.suffix.lower() == ".npz" else found.text().encode())
    return f"dense map written to {path}: {quality(found)}"


def _check(settings: dict[str, Any], outputs: dict[str, Path | None], inputs: tuple[Path, ...]) -> None:
    from ..errors import SettingsError
    from ..settings import make_settings

    make_settings(**settings)
    seen: dict[Path, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        ending = {"--picture": ".png", "--html": ".html"}.get(option, "")
        if ending and path.suffix.lower() != ending:
            raise SettingsError(f"{option}: {path} is not a {ending} file; name it so.")
        check_output(option, path, inputs)
        other = seen.setdefault(path.resolve(), option)
        if other != option:
            raise SettingsError(f"{option}: {path} is the {other} too; name another file.")


def _check_format(output: Path | None, alternatives: bool, inputs: tuple[Path, ...]) -> bool:
    """Whether the output is JSON; other formats, and alternatives that no file would hold, are checked."""
    from ..errors import SettingsError
    from ..results.actions import is_result_file

    if output is None or output == STDOUT or is_result_file(output):
        return True
    from ..exporting.formats import outputs_of

    if alternatives:
        raise SettingsError(f"--alternatives: {output} cannot hold them; name a .json file, or print them with --json.")
    for path in outputs_of(output, None, None):
        check_output("--output", path, inputs)
    return False


def _table(result: Correspondence) -> Table:
    from rich.table import Table

    others = others_of(len(result))
    caption = others and f"{others}: -o FILE writes all, --json prints them"
    table = Table(title=f"{len(result)} correspondences", caption=caption, title_justify="left", caption_justify="left")
    names = (Path(info["path"] or "array").name for info in (result.source_info, result.target_info))
    for heading in (
        "",
        *(f"{role} vertex\n{name}" for role, name in zip(("source", "target"), names, strict=True)),
    ):
        table.add_column(heading, justify="right")
    table.add_column("confidence", justify="right")
    table.add_column("kind")
    rows = zip(result.pairs.tolist(), result.confidence.tolist(), result.kind.tolist(), strict=True)
    given = 0 if result.given is None else int(result.given.sum())
    for number, ((i, j), confidence, kind) in enumerate(islice(rows, ROWS), start=1):
        table.add_row(str(number), str(i), str(j), f"{confidence:.3f}", "given" if number <= given else kind)
    return table
