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
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

import mobius_match as mm
from mobius_match._core.files import write_atomically
from mobius_match._core.processes import Died, Workers
from mobius_match.alignments import coarse_map as spreading
from mobius_match.alignments import cost as evidence
from mobius_match.alignments import explanation as hypotheses
from mobius_match.errors import FormatError
from mobius_match.evaluation import Case, Truth, find_dataset, summary
from mobius_match.evaluation.work import match_pair, prepare_one, record_of, surface_path
from mobius_match.geometry.optimal_transport import Transport
from mobius_match.registration import confidence
from mobius_match.registration import register as registration
from mobius_match.registration.register import Registration
from mobius_match.settings import make_settings
from mobius_match.surface.surface import Surface
from mobius_match.voting import votes as tally

HEADING = """# Ablation{where}

What each ingredient of the default settings is worth: one is left out at a time, everything else stays. For each set:
mean error of the first 15 / mean error of the first 45 / share of pairs whose first 15 are all within 3 % / wrong pairs
(mean of the first 45 above 0.10, or no match). Errors are geodesic distances (heat method) per diameter of the target;
where a set has landmarks, that of the match nearest to each landmark.
"""

PAGES = {
    "ablation.md": (
        "",
        """
What finds and chooses the right explanation decides few pairs only, and a selection may have none of them: it is
measured once more [where shapes differ](ablation-differing.md), on many runs.
""",
    ),
    "ablation-differing.md": (
        " where shapes differ",
        """
Here each pair of shapes that differ is matched both ways round and with several seeds. The rows are those ingredients
whose worth [fewer runs of all sets](ablation.md) show badly or not at all: they keep the program from a wrong
explanation, so the number of wrong pairs, the last of each cell, tells most.
""",
    ),
}
"""How the title of the page of that name goes on, and what it says besides."""


def alike(signatures1: np.ndarray, signatures2: np.ndarray) -> np.ndarray:
    """Stands for the similarity of descriptors: all samples are equally similar."""
    return np.ones((len(signatures1), len(signatures2)))


def unbent(source: Surface, target: Surface, image: np.ndarray, *_: Any, **__: Any) -> Registration:
    """Stands for the registration: the map of the explanation as it is."""
    nothing, turns = np.zeros(len(image)), np.tile(np.eye(3), (len(image), 1, 1))
    return Registration(image, target.mesh.vertices[image], nothing, turns, nothing)


def finer(source: Surface, target: Surface, image: np.ndarray) -> np.ndarray:
    """Stands for targets of which nothing is left over: the finer ones."""
    return spreading.refined_targets(source, target, image, source.proxy)


def not_bent() -> AbstractContextManager[Any]:
    return patch.multiple(hypotheses, register=unbent, register_coarsely=unbent)


Patches = Callable[[], AbstractContextManager[Any]]


def weights(**changed: float) -> Patches:
    names = {name.replace("_", " "): value for name, value in changed.items()}
    return lambda: patch.dict(evidence.WEIGHTS, names)


def constant(module: Any, name: str, value: Any) -> Patches:
    return lambda: patch.object(module, name, value)


def unseen(kind: int) -> Patches:
    """Descriptors (0) or curvatures (1) count nothing in the registration."""
    seen = registration._seen

    def without(surface: Any, weights: tuple[float, float]) -> Any:
        return seen(surface, (0.0, weights[1]) if kind == 0 else (weights[0], 0.0))

    return lambda: patch.object(registration, "_seen", without)


WITHOUT: dict[str, tuple[dict[str, Any], Patches]] = {
    "nothing left out": ({}, nullcontext),
    "guided triplets and all that follows (300,000 uniform ones, the paper's K)": (
        {"proposal": "uniform", "votes": 300_000},
        nullcontext,
    ),
    "intrinsic Delaunay triangulation": ({"triangulation": "mesh"}, nullcontext),
    "heat geodesics (edge paths)": ({"geodesics": "dijkstra"}, nullcontext),
    "descriptors in the votes": ({}, constant(tally, "signature_similarity", alike)),
    "choice between explanations (votes, and strain)": (
        {},
        weights(distances=0.0, laplacian=0.0, mean_curvature=0.0, gauss_curvature=0.0),
    ),
    **{
        f"choice: {kind}": ({}, weights(**{kind.replace(" ", "_"): 0.0}))
        for kind in evidence.WEIGHTS
        if kind != "landmarks"
    },
    "choice: strain of close ones": ({}, constant(hypotheses, "CONTENDERS", 1)),
    "choice: strain when bent with care (in haste alone)": ({}, constant(hypotheses, "HOPELESS", 0.0)),
    "ends of limbs, where nothing fits well": ({}, constant(hypotheses, "UNSURE", np.inf)),
    "other starts, weights and settling, where shapes differ": ({}, constant(hypotheses, "HARD", np.inf)),
    "settling, where shapes differ": ({}, constant(hypotheses, "AGAIN", 0)),
    "bending from where nothing is left over, where shapes differ": ({}, constant(hypotheses, "even_targets", finer)),
    "descriptors in the spread": ({}, constant(spreading, "DESCRIPTORS", 0.0)),
    "transport (nearest points)": ({}, constant(spreading, "Transport", partial(Transport, balance=0.0))),
    "upsampling (20 eigenfunctions alone)": ({}, constant(spreading, "UPSAMPLING", (20,))),
    "registration": ({"threshold": 0.0}, not_bent),
    "registration: normals": ({}, constant(registration, "NORMAL", 0.0)),
    "registration: eigenfunctions": ({}, constant(registration, "SPECTRAL", 0.0)),
    "registration: descriptors": ({}, unseen(0)),
    "registration: curvatures": ({}, unseen(1)),
    "registration: torn pieces set free": ({}, constant(registration, "TEAR", np.inf)),
    "registration: rising trust (the first alone)": ({}, constant(registration, "TRUST", registration.TRUST[:2])),
    "confidence (all alike)": (
        {"threshold": 0.0},
        lambda: patch.dict(confidence.SLOPES, dict.fromkeys(confidence.SLOPES, 0.0)),
    ),
    **{
        f"confidence: {kind}": ({"threshold": 0.0}, partial(patch.dict, confidence.SLOPES, {kind: 0.0}))
        for kind in confidence.SLOPES
    },
}


def records_without(case: Case, folder: Path, names: list[str], seed: int) -> dict[str, dict[str, Any]]:
    """The records of one pair, by what was left out."""
    return {name: record_without(case, folder, name, seed) for name in names}


def record_without(case: Case, folder: Path, name: str, seed: int = 0) -> dict[str, Any]:
    settings, patches = WITHOUT[name]
    chosen = make_settings(**settings, jobs=1, seed=seed)
    # A preparation of its own for settings that change it.
    place = folder / "-".join(str(value) for value in vars(chosen.preparation()).values())
    for mesh in (case.source, case.target):
        path = surface_path(place, mesh)
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            prepare_one(str(mesh), path, chosen)
    with patches():
        return record_of(match_pair, case, "heat", place, chosen, False)


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
    where, more = PAGES.get(page_name, ("", ""))
    return HEADING.format(where=where) + more + "\n" + "\n".join(lines) + f"\n\nMade by one command:\n\n    {command}\n"


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
    nothing, *others = WITHOUT
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
