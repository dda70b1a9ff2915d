"""``mobius bench DIR``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, BadParameter, Option

from ..errors import FormatError, SettingsError
from .common import SOME_FAILED, UNUSABLE, Reporter, say
from .config import merge, read_config
from .match import Quiet, Verbose
from .output import STDOUT, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..evaluation.runs import Run

COLUMNS = {"mean15": "mean of\nfirst 15", "mean45": "mean of\nfirst 45", "wrong": "pairs with\nfirst 45\nabove 10"}
DENSE_COLUMNS = {
    "dense_mean": "mean of\nall points",
    "dense_within": "within 5",
    "dense_within_far": "within 10",
    "dense_wrong": "pairs\nabove 10",
}


def bench(
    paths: Annotated[
        list[Path],
        Argument(
            metavar="DIR",
            help="Folder of meshes with known correspondence, or a CSV manifest; with --compare folders of runs.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="OUT", help="Folder of the run and its report.  [default: mobius-bench]"),
    ] = None,
    pairs: Annotated[
        Path | None,
        Option(
            metavar="FILE", help="Pairs to match, two names a line.  [default: DIR/pairs.txt, or all of a category]"
        ),
    ] = None,
    scoring: Annotated[
        str,
        Option(
            "--geodesics",
            metavar="exact|heat",
            help="How errors are measured; heat is quicker, small errors a tenth too small.",
        ),
    ] = "exact",
    resume: Annotated[bool, Option("--resume", help="Go on with the run that OUT holds.")] = False,
    compare: Annotated[
        bool, Option("--compare", help="Compare runs: mobius bench --compare RUN_A RUN_B [...] [-o OUT].")
    ] = False,
    maps: Annotated[
        Path | None,
        Option(
            metavar="FOLDER",
            help="Score dense maps made by another program instead of matching: FOLDER/SOURCE-TARGET.txt has a "
            "target vertex a line, one for each source vertex, -1 for none.",
        ),
    ] = None,
    index_base: Annotated[
        int | None, Option(metavar="0|1", help="Number of the first vertex in these maps; needed with --maps.")
    ] = None,
    dense: Annotated[bool, Option("--dense", help="Make and score dense maps too.")] = False,
    preset: Annotated[str | None, Option(metavar="paper", help="The paper's published settings.")] = None,
    samples: Annotated[int | None, Option(metavar="N", help="Sample points on each surface.  [default: 100]")] = None,
    votes: Annotated[
        int | None, Option(metavar="N", help="Triplets to evaluate.  [default: the program's choice]")
    ] = None,
    seed: Annotated[int | None, Option(metavar="N", help="Same seed, same result.  [default: 0]")] = None,
    config: Annotated[
        Path | None, Option(metavar="FILE", help="TOML file with any settings of 'mobius match'; options here win.")
    ] = None,
    jobs: Annotated[int | None, Option(metavar="N", help="Processes.  [default: one for each processor]")] = None,
    json: Annotated[bool, Option("--json", help="Print the figures as JSON instead of a table.")] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Match all pairs of a data set with known correspondence, and report the errors.

    DIR is one of: meshes with corres/NAME.vts (vertex numbers from 1; NAME.sym.vts with left and right
    exchanged); meshes with NAME.vts beside them (lines 'vertex x y z', numbers from 0); meshes of a category that
    share their vertex numbering (cat0.off, cat1.off, ...); or a CSV file with the columns source, target,
    source_landmarks, target_landmarks and, if wanted, mirrored_landmarks, category and base (0 or 1).
    """
    if compare:
        _compare(paths, output or Path("mobius-comparison"), quiet)
        return
    if len(paths) != 1:
        raise BadParameter(f"give one DIR, not {len(paths)}; runs are compared with --compare")
    options = {"preset": preset, "samples": samples, "votes": votes, "seed": seed, "jobs": jobs}
    given = {name: value for name, value in options.items() if value is not None}
    settings = merge(read_config(config) if config else {}, given)
    out = output or Path("mobius-bench")
    with Reporter(quiet) as reporter:
        from ..evaluation import find_dataset, run, write_report

        dataset = find_dataset(paths[0], pairs)
        reporter.notes([f"{len(dataset.cases)} pairs ({dataset.layout}) in {dataset.path}"])
        found = run(
            dataset,
            out,
            scoring=scoring,
            resume=resume,
            maps=maps,
            index_base=index_base,
            dense=dense,
            progress=reporter.progress,
            **settings,
        )
        reporter.progress("report", 0, 1)
        report = write_report(found, out)
    failed = [record for record in found.records if record["status"] != "done"]
    for record in failed:
        say(f"error: {record['name']}: {record['error']}")
    if not quiet:
        say(f"report: {report.resolve()}")
    if json:
        write(STDOUT, to_json(_figures(found)))
    else:
        kinds = ([False] if maps is None else []) + ([True] if dense or maps is not None else [])
        for kind in kinds:
            print_table(_table(found, kind))
    if failed:
        raise SystemExit(UNUSABLE if len(failed) == len(found.records) else SOME_FAILED)


def _compare(folders: list[Path], output: Path, quiet: bool) -> None:
    from ..evaluation import load_run, write_comparison

    if len(folders) < 2:
        raise SettingsError("--compare: one run is given; name two or more")
    runs = []
    for folder in folders:
        runs.append(load_run(folder))
        missing = len(runs[-1].info["cases"]) - len(runs[-1].records)
        if missing:
            raise FormatError(f"{folder}: {missing} pairs of this run are not done yet; finish it with --resume")
    path = write_comparison(runs, output)
    if not quiet:
        say(f"comparison: {path.resolve()}")


def _figures(run: Run) -> dict[str, Any]:
    """Per category and for all: number of pairs and mean errors."""
    from ..evaluation import summary

    variants = summary.variants(run.records)
    groups = summary.by_category(run.records)
    if len(groups) > 1:
        groups = {**groups, "all": run.records}
    return {
        name: {
            "pairs": len(records),
            "failed": len(records) - len(summary.done(records)),
            **{
                variant: {k: None if v != v else v for k, v in summary.headline(records, variant).items()}
                for variant in variants
            },
        }
        for name, records in groups.items()
    }


def _table(run: Run, dense: bool) -> Table:
    from rich.table import Table

    from ..evaluation import summary

    figures = _figures(run)
    columns = DENSE_COLUMNS if dense else COLUMNS
    unit = "the square root of the target's area" if dense else "the target's diameter"
    table = Table(title=f"Errors, % of {unit}", title_justify="left")
    variants = [name for name in summary.variants(run.records) if name != "mirrored"]
    table.add_column("")
    table.add_column("pairs", justify="right")
    for variant in variants:
        note = "\n(better truth)" if variant == "better" else ""
        for heading in columns.values():
            table.add_column(heading + note, justify="right")
    for name, entry in figures.items():
        cells = [_cell(entry[variant].get(column)) for variant in variants for column in columns]
        table.add_row(name, str(entry["pairs"]), *cells)
    return table


def _cell(value: float | None) -> str:
    """A mean as percentage, a count as it is."""
    return "-" if value is None else f"{100 * value:.2f}" if isinstance(value, float) else str(value)
