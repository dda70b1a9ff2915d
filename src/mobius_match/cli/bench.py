"""``mobius bench DIR``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, BadParameter, Option

from ..errors import FormatError, SettingsError
from .common import SOME_FAILED, UNUSABLE, Reporter, say
from .config import given_settings
from .options import Config, Preset, Processes, Quiet, Samples, Seed, Verbose, Votes
from .output import STDOUT, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

    from ..evaluation.runs import Run

COLUMNS = {"mean15": "mean of\nfirst 15", "mean45": "mean of\nfirst 45", "wrong": "pairs with\nmean of 45\nabove 10"}
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
            help="Folder of meshes with known correspondence, or a CSV manifest; with --compare, folders of runs.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="OUT", help="Folder for the run and its report.  [default: mobius-bench]"),
    ] = None,
    pairs: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            help="Pairs to match, two names per line.  [default: DIR/pairs.txt, or all pairs within a category]",
        ),
    ] = None,
    scoring: Annotated[
        str,
        Option(
            "--geodesics",
            metavar="exact|heat",
            help="How errors are measured. The heat method is faster and underestimates small errors by about 10 %.",
        ),
    ] = "exact",
    resume: Annotated[bool, Option("--resume", help="Continue the run in OUT.")] = False,
    compare: Annotated[
        bool, Option("--compare", help="Compare runs: mobius bench --compare RUN_A RUN_B [...] [-o OUT].")
    ] = False,
    maps: Annotated[
        Path | None,
        Option(
            metavar="FOLDER",
            help="Score the dense maps of another program instead of matching. FOLDER/SOURCE-TARGET.txt has one line "
            "per source vertex with its target vertex, or -1 for none.",
        ),
    ] = None,
    index_base: Annotated[
        int | None, Option(metavar="0|1", help="Number of the first vertex in these maps; required with --maps.")
    ] = None,
    dense: Annotated[bool, Option("--dense", help="Compute and score dense maps too.")] = False,
    preset: Preset = None,
    samples: Samples = None,
    votes: Votes = None,
    seed: Seed = None,
    config: Config = None,
    jobs: Processes = None,
    json: Annotated[bool, Option("--json", help="Print the figures as JSON instead of a table.")] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Match all pairs of a data set with known correspondence, and report the errors.

    DIR is one of: meshes with corres/NAME.vts (vertex numbers from 1; NAME.sym.vts with left and right
    swapped); meshes with NAME.vts next to them (lines 'vertex x y z', numbers from 0); meshes of a category that
    share their vertex numbering (cat0.off, cat1.off, ...); or a CSV file with the columns source, target,
    source_landmarks, target_landmarks and, optionally, mirrored_landmarks, category and base (0 or 1).
    """
    if compare:
        _compare(paths, output or Path("mobius-comparison"), quiet)
        return
    if len(paths) != 1:
        raise BadParameter(f"give one DIR, not {len(paths)}; to compare runs, add --compare")
    settings = given_settings(config, preset=preset, samples=samples, votes=votes, seed=seed, jobs=jobs)
    out = output or Path("mobius-bench")
    with Reporter(quiet) as reporter:
        from ..evaluation import find_dataset, run, write_report

        dataset = find_dataset(paths[0], pairs)
        reporter.notes([f"{len(dataset.cases)} pairs ({dataset.layout}) in {dataset.path}"])
        result = run(
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
        report = write_report(result, out)
    failed = [record for record in result.records if record["status"] != "done"]
    for record in failed:
        say(f"error: {record['name']}: {record['error']}")
    if not quiet:
        say(f"report: {report.resolve()}")
    if json:
        write(STDOUT, to_json(_figures(result)))
    else:
        if maps is None:
            print_table(_table(result, dense=False))
        if dense or maps is not None:
            print_table(_table(result, dense=True))
    if failed:
        raise SystemExit(UNUSABLE if len(failed) == len(result.records) else SOME_FAILED)


def _compare(folders: list[Path], output: Path, quiet: bool) -> None:
    from ..evaluation import load_run, write_comparison

    if len(folders) < 2:
        raise SettingsError("--compare: only one run is given; give two or more")
    runs = []
    for folder in folders:
        run = load_run(folder)
        missing = len(run.info["cases"]) - len(run.records)
        if missing:
            raise FormatError(f"{folder}: {missing} pairs of this run are not done yet; finish it with --resume")
        runs.append(run)
    path = write_comparison(runs, output)
    if not quiet:
        say(f"comparison: {path.resolve()}")


def _figures(run: Run) -> dict[str, Any]:
    """The number of pairs and the mean errors of each category, and of all."""
    from ..evaluation import summary

    variants = summary.variants(run.records)
    groups = summary.by_category(run.records)
    if len(groups) > 1:
        groups = {**groups, "all": run.records}
    return {
        name: {
            "pairs": len(records),
            "failed": len(records) - len(summary.done(records)),
            **{variant: _without_nan(summary.headline(records, variant)) for variant in variants},
        }
        for name, records in groups.items()
    }


def _without_nan(figures: dict[str, Any]) -> dict[str, Any]:
    return {name: None if value != value else value for name, value in figures.items()}


def _table(run: Run, *, dense: bool) -> Table:
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
        note = "\n(better of\nboth truths)" if variant == "better" else ""
        for heading in columns.values():
            table.add_column(heading + note, justify="right")
    for name, entry in figures.items():
        cells = [_cell(entry[variant].get(column)) for variant in variants for column in columns]
        table.add_row(name, str(entry["pairs"]), *cells)
    return table


def _cell(value: float | None) -> str:
    """A mean error in per cent, or a count."""
    if value is None:
        return "-"
    return f"{100 * value:.2f}" if isinstance(value, float) else str(value)
