"""Make docs/robustness.md: what a change of the target mesh does to the matches.

    python benchmarks/robustness.py DATA [-o docs/robustness.md] [--pairs N]

DATA is an evaluation set whose corres/ has NAME.vts and NAME.sym.vts, or a folder of such sets. Takes 20 to 40
seconds a pair on one processor, and uses all there are.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from changes import CHANGES, cases, errors

import mobius_match as mm
from mobius_match._core.files import write_atomically
from mobius_match._core.processes import Died, Workers
from mobius_match.evaluation import Case, summary
from mobius_match.evaluation.scoring import cached_diameter, mesh_area

HEADING = """# Robustness

How the matches at default settings change when the target mesh is changed and the source is not: {pairs}.

Errors are geodesic distances (heat method) on the changed target from the match to the true point, as fractions of the
diameter of the changed target, in order of confidence. If the change keeps no vertex of the original, a true point
becomes the nearest vertex of the changed target with a similar normal. The last column is the mean distance, as a
fraction of the diameter, by which true points are moved for that: errors below it say nothing. "Wrong" are pairs whose
first 45 matches have a mean error above 0.10, and pairs without any match.

Decimation collapses edges by least quadric error. "Remeshed" is refined, then decimated by edge length to as many faces
as before. Noise is Gaussian in each coordinate, its standard deviation given in mean edge lengths.

A surface is matched by its orientation: left stays left as seen from outside. In the mirror image of an animal that is
nearly symmetric itself, the left paw looks like a right one. So a mirrored target should be matched like the animal
that it looks like: to the list of points with left and right swapped, and not to the points that were mirrored. The
table has both. Closed surfaces are turned outwards before anything else, so reversed faces make no difference.

| change of the target | mean of first 15 | mean of first 45 | first 15 within 3 % | wrong | matches | points moved |
|---|---|---|---|---|---|---|
"""


def match_changes(case: Case) -> list[dict[str, Any]]:
    """The record of one pair under each change, in the form that :mod:`mobius_match.evaluation.summary` reads."""
    source, original = mm.prepare(case.source), mm.read_mesh(case.target)
    return [match_change(case, source, original, name) for name in CHANGES]


def match_change(case: Case, source: mm.Surface, original: mm.Mesh, name: str) -> dict[str, Any]:
    changed = CHANGES[name](original.vertices, original.faces, np.random.default_rng(0))
    truth = changed.carry(case.truth)
    try:
        target = mm.prepare((changed.vertices, changed.faces))
        pairs = mm.match(source, target, jobs=1).pairs
    except mm.MobiusError as error:
        return {"name": case.name, "status": "failed", "error": str(error)}
    diameter = cached_diameter(target.whole_mesh, "heat")
    return {
        "name": case.name,
        "status": "done",
        "pairs": pairs,
        **errors(replace(case, truth=truth), source.whole_mesh, target.whole_mesh, pairs),
        "dense": None,
        "diameter": diameter,
        "area": mesh_area(target.whole_mesh),
        "apart": changed.apart[case.truth.target].mean() / diameter,
    }


def row(change: str, records: list[dict[str, Any]], variant: str) -> tuple[str, list[str]]:
    """A line of the table, and the names of the wrong pairs."""
    done = summary.done(records)
    each = [summary.measures(record, variant) for record in done]
    wrong = [record["name"] for record, found in zip(done, each, strict=True) if found["wrong"]]
    wrong += [record["name"] for record in records if record["status"] != "done"]
    if not done:
        return f"| {change} | | | 0% | {len(wrong)} | | |\n", wrong
    mean15, mean45 = (np.mean([found[name] for found in each]) for name in ("mean15", "mean45"))
    close = sum(found["first15_close"] for found in each) / len(records)
    matches, apart = np.mean([(len(record["pairs"]), record["apart"]) for record in done], axis=0)
    line = f"| {change} | {mean15:.4f} | {mean45:.4f} | {close:.0%} | {len(wrong)} | {matches:.0f} | {apart:.4f} |\n"
    return line, wrong


def page(chosen: list[Case], found: list[list[dict[str, Any]]], command: str) -> str:
    """The whole page, from the records of each pair under each change."""
    sets = Counter(case.source.parent.name for case in chosen)
    text = HEADING.format(pairs=", ".join(f"{number} pairs of `{name}`" for name, number in sets.items()))
    wrongs, failures = [], []
    for change, records in zip(CHANGES, zip(*found, strict=True), strict=True):
        lists = {"direct": "the same points", "mirrored": "left and right swapped"}
        for variant in lists if change.startswith("mirrored") else ("direct",):
            name = f"{change}, to {lists[variant]}" if change.startswith("mirrored") else change
            line, wrong = row(name, list(records), variant)
            text += line
            if wrong and not (change.startswith("mirrored") and variant == "direct"):
                wrongs.append(f"- {name}: {', '.join(wrong)}\n")
        failures += [f"- {change}, {r['name']}: {r['error']}\n" for r in records if r["status"] != "done"]
    if wrongs:
        text += "\nThe wrong pairs (those of a mirrored target against the same points left out):\n\n" + "".join(wrongs)
    if failures:
        text += "\nPairs without a match:\n\n" + "".join(failures)
    return text + f"\nMade by one command:\n\n    {command}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/robustness.md"))
    parser.add_argument("--pairs", type=int, default=24, help="how many, spread evenly over the sets' lists (24)")
    options = parser.parse_args()
    if options.pairs < 1:
        parser.error("--pairs: give 1 or more")
    if not options.output.parent.is_dir():
        parser.error(f"--output: there is no folder {options.output.parent}")
    every = cases(options.data)
    places = np.linspace(0, len(every), min(options.pairs, len(every)), endpoint=False).astype(int)
    chosen = {str(place): every[place] for place in places}
    found = {}
    with Workers(min(os.cpu_count() or 1, len(chosen))) as workers:
        for name, records in workers.results(match_changes, {name: (case,) for name, case in chosen.items()}):
            if records is Died:
                sys.exit(f"{chosen[name].name}: its process ended; most often there is not enough memory")
            found[name] = records
            print(f"{len(found)} of {len(chosen)}: {chosen[name].name}", flush=True)
    command = f"python benchmarks/robustness.py DATA --pairs {options.pairs}"
    text = page(list(chosen.values()), [found[name] for name in chosen], command)
    write_atomically(options.output, text.encode())
    print(text)


if __name__ == "__main__":
    try:
        main()
    except mm.MobiusError as problem:
        sys.exit(str(problem))
