"""Make docs/ablation.md: what each ingredient of the default settings is worth, by leaving it out alone.

    python benchmarks/ablation.py DATA... [-o docs/ablation.md] [--every K] [--both-ways] [--seeds N] [--rows TEXT...]

DATA is an evaluation set, or a folder of such sets. Takes one to three seconds a run and row on each processor.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

import mobius_match as mm
from mobius_match._core.files import write_atomically
from mobius_match._core.parameters import varied
from mobius_match._core.processes import Died, Workers
from mobius_match.alignments.parameters import CostWeights, Evidence
from mobius_match.errors import FormatError
from mobius_match.evaluation import Case, Truth, find_dataset, summary
from mobius_match.evaluation.work import match_pair, prepare_one, record_of, surface_path
from mobius_match.matching.parameters import Parameters
from mobius_match.registration.parameters import ConfidenceTerms
from mobius_match.settings import make_settings

HEADING = """# Ablation{where}

What each ingredient of the default settings contributes: one is left out at a time, everything else stays. For each
set: mean error of the first 15 / mean error of the first 45 / share of pairs whose first 15 are all within 3 % / wrong
pairs (mean of the first 45 above 0.10, or no match). Errors are geodesic distances (heat method) as fractions of the
target's diameter; where a set has landmarks, the error is that of the match nearest to each landmark.
"""

PAGES = {
    "ablation.md": (
        "",
        """
The ingredients that find and choose the right alignment matter for few pairs, and a selection of pairs may have none of
these. They are measured again [where shapes differ](ablation-differing.md), on many runs.

The table is from before the choice was made by [evidence](choice.md), which has taken the place of strain; the terms of
the evidence are not among its rows, and extremities were matched in fewer cases.
""",
        """
## Constants that were merged

The method once had about 200 constants; 120 were left, to which discs, pieces, envelopes, rigid motions and the model of
the choice have added others ([parameters](parameters.md)). Of these groups, the ablation showed no difference between several constants and one:

- **Schedules of registration.** Sparse and dense registration had separate data weights, rounds and steps. There is one
  geometric sequence of weights, and the weight and the steps of the initial placement follow from it.
- **Surroundings in the confidence.** Its features had radii and floors of their own. There is one radius and one floor,
  which the confidence of parts uses as well.
- **Margins of the choice.** Candidates were selected for the coarse and for the full registration by different margins,
  and extremities were matched above another cost than the one above which shapes differ. There is one margin and one
  threshold.
- **Repeated registrations.** The positions of the last ones were averaged, except those farther than a radius from the
  best. The median of all is used now, which needs neither a number nor a radius.
- **Floors before logarithms and divisions.** Stretch and normal deviation had floors of their own in the strain; they
  share one, far below what good matches have. The least standard deviation of curvatures is 1 and no parameter.

Three ingredients that contribute little in the table were left in, since some sets are worse without them. Mean
Euclidean errors in units of sqrt(area), on 27 pairs of TOSCA, gorillas with people, FAUST and SMAL:

| left out | figure | with | without |
|---|---|---|---|
| registration: eigenfunctions | dense maps, gorillas with people | 0.0421 | 0.0530 |
| | all matches, TOSCA | 0.0142 | 0.0152 |
| registration: descriptors | first 45 matches, gorillas with people | 0.0309 | 0.0327 |
| | first 45 matches, FAUST | 0.0101 | 0.0111 |
| choice: mean curvature | SMAL | 0.0279 | 0.0300 |
""",
    ),
    "ablation-differing.md": (
        " where shapes differ",
        """
Here each pair of shapes that differ is matched in both directions and with several seeds. The rows are those
ingredients whose contribution [fewer runs of all sets](ablation.md) hardly show. They keep the program from choosing a
wrong alignment, so the number of wrong pairs, the last in each cell, matters most.
""",
        "",
    ),
}
"""By name of the page: the end of its title, and the texts before and after the table."""


Changes = dict[str, Any]
"""Values of parameters by name, or of a setting by its own."""

SELECTION = "alignment.selection."
COST = "alignment.cost.weights."
EVIDENCE = "alignment.choice.weights."
REGISTRATION = "alignment.registration."
CONFIDENCE = f"{REGISTRATION}confidence.slopes."
COARSE = "alignment.coarse_map."


COSTS = [one.name for one in fields(CostWeights) if one.name != "landmarks"]
TERMS = [one.name for one in fields(Evidence)]
SLOPES = [one.name for one in fields(ConfidenceTerms)]

SETTINGS: dict[str, Changes] = {
    "guided triplets and all that follows (300,000 uniform ones, the paper's K)": {
        "proposal": "uniform",
        "votes": 300_000,
    },
    "intrinsic Delaunay triangulation": {"triangulation": "mesh"},
    "heat geodesics (edge paths)": {"geodesics": "dijkstra"},
    "registration beyond the initial placement": {"threshold": 0.0},
    "confidence (all alike)": {"threshold": 0.0},
    **{f"confidence: {name}": {"threshold": 0.0} for name in SLOPES},
}
"""Settings of rows that change any."""

PARAMETERS: dict[str, Changes] = {
    "descriptors in the votes": {"alignment.voting.similarity_width": np.inf},
    "cost of alignments (votes, and evidence)": {f"{COST}{name}": 0.0 for name in COSTS},
    **{f"cost: {name.replace('_', ' ')}": {f"{COST}{name}": 0.0} for name in COSTS},
    "choice by evidence (least cost)": {f"{SELECTION}most_contenders": 1, f"{SELECTION}sure_above": 0.0},
    **{f"evidence: {name.replace('_', ' ')}": {f"{EVIDENCE}{name}": 0.0} for name in TERMS},
    "extremities and rigid motions": {f"{SELECTION}sure_above": 0.0},
    "extremities": {"alignment.extremities.most": 0},
    "rigid motions": {"alignment.poses.tried": 0},
    "other beginnings and repeats, where shapes differ": {f"{SELECTION}different_above": np.inf},
    "repeated registration, where shapes differ": {f"{SELECTION}repeats": 0},
    "descriptors in the coarse map": {f"{COARSE}descriptor_weight": 0.0},
    "transport (nearest points)": {f"{COARSE}transport.balance": 0.0},
    "upsampling in steps (all eigenfunctions at once)": {f"{COARSE}upsampling_step": 1000},
    "registration beyond the initial placement": {f"{REGISTRATION}n_weights": 0},
    "registration: normals": {f"{REGISTRATION}normal": 0.0},
    "registration: eigenfunctions": {f"{REGISTRATION}spectral": 0.0},
    "registration: descriptors": {f"{REGISTRATION}descriptor": (0.0, 0.0)},
    "registration: curvatures": {f"{REGISTRATION}curvature": (0.0, 0.0)},
    "registration: discontinuous pieces ignored": {f"{REGISTRATION}discontinuity": np.inf},
    "registration: rising data weight (the first alone)": {f"{REGISTRATION}n_weights": 1},
    "confidence (all alike)": {f"{CONFIDENCE}{name}": 0.0 for name in SLOPES},
    **{f"confidence: {name}": {f"{CONFIDENCE}{name}": 0.0} for name in SLOPES},
}
"""Parameters of rows that change any."""

ROWS = list(dict.fromkeys(["nothing left out", *SETTINGS, *PARAMETERS]))


def records_without(case: Case, folder: Path, names: list[str], seed: int) -> dict[str, dict[str, Any]]:
    """The records of one pair, by what was left out."""
    return {name: record_without(case, folder, name, seed) for name in names}


def record_without(case: Case, folder: Path, name: str, seed: int = 0) -> dict[str, Any]:
    chosen = make_settings(**SETTINGS.get(name, {}), jobs=1, seed=seed)
    parameters = varied(Parameters(), PARAMETERS.get(name, {}))
    # A preparation of its own for settings that change it.
    place = folder / "-".join(str(value) for value in vars(chosen.preparation()).values())
    for mesh in (case.source, case.target):
        path = surface_path(place, mesh)
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            prepare_one(str(mesh), path, chosen)
    return record_of(match_pair, case, "heat", place, chosen, False, parameters)


def reversed_case(case: Case) -> Case:
    """The same pair the other way round."""
    truth = Truth(case.truth.target, case.truth.source, landmarks=case.truth.landmarks)
    return Case(f"{case.target.stem}-{case.source.stem}", case.category, case.target, case.source, truth)


def cell(records: list[dict[str, Any]]) -> str:
    found = summary.headline(records, "direct")
    wrong = found["wrong"] + sum(record["status"] != "done" for record in records)
    return f"{found['mean15']:.4f} / {found['mean45']:.4f} / {found['first15_close']:.0%} / {wrong:.0f}"


def page(sets: Mapping[str, list[dict[str, dict[str, Any]]]], names: list[str], page_name: str, command: str) -> str:
    titles = [f"{name} ({len(found)})" for name, found in sets.items()]
    lines = [f"| left out | {' | '.join(titles)} |", "|---" * (len(sets) + 1) + "|"]
    for name in names:
        cells = [cell([records[name] for records in found]) for found in sets.values()]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    where, before, after = PAGES.get(page_name, ("", "", ""))
    table = "\n".join(lines)
    return f"{HEADING.format(where=where)}{before}\n{table}\n\nMade by one command:\n\n    {command}\n{after}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/ablation.md"))
    parser.add_argument("--every", type=int, default=1, help="only every K-th pair of each set (1)")
    parser.add_argument("--both-ways", action="store_true", help="each pair the other way round, too")
    parser.add_argument("--seeds", type=int, default=1, help="how many seeds, from 0 (1)")
    parser.add_argument("--rows", nargs="+", default=[""], help="only rows whose names begin with one of these texts")
    options = parser.parse_args()
    if options.every < 1 or options.seeds < 1:
        parser.error("--every, --seeds: give 1 or more")
    if not options.output.parent.is_dir():
        parser.error(f"--output: there is no folder {options.output.parent}")
    nothing, *others = ROWS
    names = [nothing, *(name for name in others if name.startswith(tuple(options.rows)))]
    sets: dict[str, dict[str, tuple[Case, int]]] = {}
    for folder in [path for data in options.data for path in (data, *sorted(data.glob("*/")))]:
        try:
            cases = list(find_dataset(folder).cases)[:: options.every]
        except FormatError as error:
            print(f"left out: {error}", file=sys.stderr)
        else:
            cases += [reversed_case(case) for case in cases] * options.both_ways
            sets[folder.name] = {
                f"{folder.name} {c.name} {seed}": (c, seed) for c in cases for seed in range(options.seeds)
            }
    if not sets:
        sys.exit(f"{options.data[0]}: neither an evaluation set nor a folder of such sets")
    runs = {run: chosen for of_set in sets.values() for run, chosen in of_set.items()}
    found: dict[str, dict[str, dict[str, Any]]] = {}
    with tempfile.TemporaryDirectory() as folder, Workers(min(os.cpu_count() or 1, len(runs))) as workers:
        jobs = {run: (case, Path(folder), names, seed) for run, (case, seed) in runs.items()}
        for run, records in workers.results(records_without, jobs):
            if records is Died:
                sys.exit(f"{run}: its process ended; most often there is not enough memory")
            found[run] = records
            print(f"{len(found)} of {len(runs)}: {run}", file=sys.stderr, flush=True)
    by_set = {name: [found[run] for run in of_set] for name, of_set in sets.items()}
    text = page(by_set, names, options.output.name, command_line(options))
    write_atomically(options.output, text.encode())
    print(text)


def command_line(options: argparse.Namespace) -> str:
    """What makes the page again, whatever folder the data are in."""
    folders = ["DATA"] if len(options.data) == 1 else [f"DATA/{data.name}" for data in options.data]
    words = ["python benchmarks/ablation.py", *folders]
    words += [f"-o {options.output}"] * (options.output != Path("docs/ablation.md"))
    words += [f"--every {options.every}"] * (options.every > 1)
    words += ["--both-ways"] * options.both_ways + [f"--seeds {options.seeds}"] * (options.seeds > 1)
    words += ["--rows " + shlex.join(options.rows)] * (options.rows != [""])
    return " ".join(words)


if __name__ == "__main__":
    try:
        main()
    except mm.MobiusError as problem:
        sys.exit(str(problem))
