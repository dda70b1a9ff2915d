"""Make docs/benchmark.md: every data set in a folder, default settings beside the paper's.

    python benchmarks/page.py DATA [--runs DIR] [--scoring exact|heat] [--paper-votes N]

DATA holds the sets, a folder each, in any layout that `mobius bench` reads. Runs are kept in DIR (default:
benchmark-runs) with their full reports, and are resumed if they are there. The paper's settings take a minute a pair
for their ten million triplets, so their number can be cut down, which the page then says.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mobius_match.evaluation import Run, find_dataset, run, summary, write_comparison, write_report

HEADING = """# Benchmark

Errors of the sparse matches against known correspondence, in order of confidence: the geodesic distance on the target
between the match and the true point, divided by the geodesic diameter of the target (the paper's measure). "Wrong" is
the number of pairs with a mean error of the first 45 matches above 0.10. For sets with 21 landmarks per shape, each
landmark is compared with the match nearest to it on the source, so the error includes the distance between the two;
other matches are ignored. Each pair has the same weight. Pairs with fewer than 45 matches contribute all they have.

By default the matches are the samples and the most confident points between them, about 600 in total. The first of them
often cluster on a face or a hand.

The data sets are published academic ones, remeshed to about 5,000 vertices (`tosca`, `tosca_nonisometric`, `faust`;
each shape independently) or as published (`shrec07_fourleg`, `tosca_original`). They are not part of the project.

| set | pairs | settings | mean of first 15 | mean of first 45 | first 15 within 3 % | wrong | matches | within 5 % |
|---|---|---|---|---|---|---|---|---|
"""


def row(found: Run, name: str, settings: str) -> str:
    done = summary.done(found.records)
    failed = len(found.records) - len(done)
    pairs = f"{len(found.records)} ({failed} without a match)" if failed else str(len(found.records))
    if not done:
        return f"| {name} | {pairs} | {settings} | | | | | | |\n"
    numbers = summary.headline(found.records, "direct")
    matches = summary.surface_numbers(found.records)["matches"]
    lists = [errors for record in done if (errors := summary.errors(record, "direct")) is not None]
    close = np.mean([np.mean(errors[~np.isnan(errors)] <= 0.05) for errors in lists])
    return (
        f"| {name} | {pairs} | {settings} | {numbers['mean15']:.4f} | {numbers['mean45']:.4f} "
        f"| {numbers['first15_close']:.0%} | {numbers['wrong']} | {matches:.0f} | {close:.0%} |\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--runs", type=Path, default=Path("benchmark-runs"))
    parser.add_argument("--scoring", choices=("exact", "heat"), default="exact")
    parser.add_argument("--paper-votes", type=int)
    parser.add_argument("--output", type=Path, default=Path("docs/benchmark.md"))
    options = parser.parse_args()
    rows = []
    variants = {"default": {}, "paper": {"preset": "paper"}}
    if options.paper_votes:
        variants["paper"]["votes"] = options.paper_votes
    for folder in sorted(path for path in options.data.iterdir() if path.is_dir()):
        runs = []
        for name, settings in variants.items():
            out = options.runs / f"{folder.name}-{name}"
            found = run(
                find_dataset(folder), out, scoring=options.scoring, resume=(out / "run.json").exists(), **settings
            )
            write_report(found, out)
            runs.append(found)
            rows.append(row(found, folder.name, name))
            print(rows[-1], end="", flush=True)
        write_comparison(runs, options.runs / f"{folder.name}-compared")
    votes = f" with {options.paper_votes:,} triplets per pair instead of ten million" if options.paper_votes else ""
    command = f"python benchmarks/page.py DATA --scoring {options.scoring}" + (
        f" --paper-votes {options.paper_votes}" if options.paper_votes else ""
    )
    options.output.write_text(
        HEADING
        + "".join(rows)
        + f"\n`paper` is `--preset paper`{votes}. Errors are measured with {options.scoring} geodesics.\n\n"
        + f"This command makes the table, and a full report of each run:\n\n    {command}\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
