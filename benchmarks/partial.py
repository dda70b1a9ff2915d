"""Make docs/partial.md: shapes of which a part is missing, matched with whole ones.

    python benchmarks/partial.py DATA [-o docs/partial.md] [--cuts N] [--fresh N] [--seeds S ...] [--units N]

DATA is the folder that holds the evaluation sets tosca and faust, with their pairs and corres/. Takes half an hour.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from changes import cases, cut, errors
from scipy.sparse.csgraph import dijkstra

import mobius_match as mm
from mobius_match._core.files import write_atomically
from mobius_match.evaluation import Case, Truth
from mobius_match.evaluation.scoring import cached_diameter
from mobius_match.geometry.geodesics import edge_graph

NEAR = 0.05
"""Per diameter of the whole shape: a match is right, or a place still belongs to the part."""

CLOSE = 0.01
"""Per diameter of the other shape: known points that cannot be distinguished."""

FRONT, HIND, UP, DOWN = (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)
"""In the set tosca; the people of faust stand along the second axis."""

Cut = tuple[str, str, tuple[float, float, float], float]
"""See `CUTS`."""

CUTS: tuple[Cut, ...] = (
    ("cat0-cat6", "front half", FRONT, 0.0),
    ("cat0-cat6", "hind half", HIND, 0.0),
    ("cat0-cat6", "without its tail", FRONT, -0.25),
    ("dog0-dog1", "front half", FRONT, 0.0),
    ("dog0-dog6", "hind half", HIND, 0.0),
    ("wolf0-wolf1", "front half", FRONT, 0.0),
    ("horse0-horse7", "front half", FRONT, 0.0),
    ("horse0-horse7", "hind half", HIND, 0.0),
    ("horse0-horse10", "without its head", HIND, -0.28),
    ("centaur0-centaur2", "front half", FRONT, 0.0),
    ("michael0-michael2", "upper half", UP, 0.0),
    ("michael0-michael2", "lower half", DOWN, 0.0),
    ("michael0-michael2", "without an arm", (1, 0, 0), -0.14),
    ("tr_reg_000-tr_reg_001", "upper half", HIND, 0.0),
    ("tr_reg_000-tr_reg_001", "lower half", FRONT, 0.0),
    ("tr_reg_000-tr_reg_004", "without an arm", (1, 0, 0), -0.25),
    ("tr_reg_010-tr_reg_012", "without the head", FRONT, -0.33),
)
"""Pair, what is left of its first shape, the side of the plane that is kept, and where the plane is (see `cut`)."""

SETS = ("tosca", "faust")

TASKS = ("part to another pose", "another pose to part", "part to its own shape")

HEADING = """# Partial shapes

Shapes are cut by a plane, and the largest piece on one side is kept. This part is matched, with default settings, to
whole shapes: in another pose, in both directions, and to the shape that it was cut from. A part consists of whole faces
of the original shape, so its true correspondences are known.

Each task has three figures: the number of reported **matches**; the share of them that is **right**, within 5 % of the
diameter of the whole target (geodesic distance, heat method); and the number of matches on the **missing** part, which
should be 0. A match is on the missing part if its true place on the shape that was cut is farther than 5 % of the
diameter from what was kept. (The lists of true correspondences give one vertex to a hand and to the hip that it
touches. So a place counts as kept if any known point within 1 % of the diameter is.)
For matches to a part, the true place and the error are measured on the shape that it was cut from. In the last line of
a table, matches and right are means over the tasks that have matches, and missing is the sum.

The units of the files are not given to the program: it searches for the size at which the part fits best.
No match is reported within 3.5 % of sqrt(area) of the cut, because a small error there already leads beyond it.
"""

CHOSEN = """
## Chosen cuts

The constants that select a placement were chosen by hand on these cuts.

"""

FRESH = """
## Random cuts, seed {seed}

{count} pairs are drawn at random from those not above. The first shape of each is cut in half by a plane through the
mean of its vertices, in a random direction. "No match" means that the program ends with the message that no match is
likely enough to be right.{more}

"""

MORE = {
    0: """ Failures on some of these led to changes of the program. The probability of a match was fitted on cuts of
other seeds (`benchmarks/fit_partial.py`).""",
    2: """
These cuts were only used to check that fewer constants give the same quality.""",
}
"""Which decisions were made on the cuts of a seed."""

UNITS = """
## Other units

The first {count} random cuts of seed {seed} again. The parts are given in millimetres and the wholes in metres.

"""
FACTOR = 1000.0

TABLE = """| shape | what is left | of the area | other pose | {tasks} |
|---|---|---|---|{rules}|
"""


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of a whole mesh, prepared, with the numbers that its vertices have there."""

    surface: mm.Surface
    kept: np.ndarray
    whole: mm.Mesh

    @property
    def gaps(self) -> np.ndarray:
        """Distance (n,) of the whole's vertices from what was kept, along edges, per diameter of the whole."""
        graph = edge_graph(self.whole.vertices, self.whole.faces)
        return dijkstra(graph, directed=False, indices=self.kept, min_only=True) / cached_diameter(self.whole, "heat")


def judged(
    part: Part, other: mm.Surface, case: Case, pairs: np.ndarray, reverse: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs (q, 2) are right, and which are on the missing part, (q,) bool each; on the whole meshes.

    The truth of the case leads from the whole of the part to the other shape.
    """
    mine, theirs = pairs[:, ::-1].T if reverse else pairs.T
    mine = part.kept[mine]
    truth = case.truth
    if reverse:
        back = Case(case.name, case.category, case.target, case.source, Truth(truth.target, truth.source))
        found = errors(back, other.mesh, part.whole, np.stack([theirs, mine], axis=1))
    else:
        found = errors(case, part.whole, other.mesh, np.stack([mine, theirs], axis=1))
    # The lists give one vertex to a hand and to the hip that it touches. So a point is missing if all points of the
    # truth close to it are.
    graph = edge_graph(other.mesh.vertices, other.mesh.faces)
    apart = dijkstra(graph, directed=False, indices=theirs)[:, truth.target]
    close = apart <= np.maximum(apart.min(axis=1, keepdims=True), CLOSE * cached_diameter(other.mesh, "heat"))
    gaps = np.where(close, part.gaps[truth.source], np.inf).min(axis=1)
    return found["direct"] <= NEAR, gaps > NEAR


def measure(part: Part, other: mm.Surface, case: Case, reverse: bool) -> dict[str, float] | None:
    """Match a part with a whole shape and measure; None where nothing is found. See :func:`judged`."""
    try:
        order = (other, part.surface) if reverse else (part.surface, other)
        pairs = mm.match(*order).pairs
    except mm.NothingFoundError:
        return None
    right, missing = judged(part, other, case, pairs, reverse)
    return {"matches": len(pairs), "right": float(right.mean()), "missing": int(missing.sum())}


def prepared_cut(
    case: Case, normal: tuple[float, float, float], offset: float, prepared: dict[Path, mm.Surface], factor: float
) -> tuple[Part, mm.Surface, mm.Surface]:
    """The part, made that many times larger, the whole that it was cut from, and the other shape."""
    for path in (case.source, case.target):
        if path not in prepared:
            prepared[path] = mm.prepare(path)
            if prepared[path].mesh.notes:  # numbers of the file and of the mesh may differ
                raise mm.FormatError(f"{path}: needs repair, and is no shape that these cuts were made for")
    whole, other = prepared[case.source], prepared[case.target]
    vertices, faces, kept = cut(whole.mesh.vertices, whole.mesh.faces, normal, offset)
    return Part(mm.prepare((factor * vertices, faces)), kept, whole.mesh), whole, other


def run_cut(
    case: Case, normal: tuple[float, float, float], offset: float, prepared: dict[Path, mm.Surface], factor: float
) -> Any:
    """The share of the area that is left, and the figures of each task; the part is made that many times larger."""
    part, whole, other = prepared_cut(case, normal, offset, prepared, factor)
    same = np.arange(len(whole.mesh.vertices))
    itself = Case(case.name, case.category, case.source, case.source, Truth(same, same))
    return part.surface.area / whole.area / factor**2, [
        measure(part, other, case, reverse=False),
        measure(part, other, case, reverse=True),
        measure(part, whole, itself, reverse=False),
    ]


def cells(found: dict[str, float] | None) -> str:
    if found is None:
        return "no match | |"
    return f"{found['matches']:.0f} | {found['right']:.0%} | {found['missing']:.0f} |"


def summed(found: list[dict[str, float]]) -> dict[str, float] | None:
    """The last line's figures of a task."""
    if not found:
        return None
    means = {key: float(np.mean([one[key] for one in found])) for key in ("matches", "right")}
    return means | {"missing": sum(one["missing"] for one in found)}


def fresh_cuts(names: list[str], count: int, seed: int) -> list[Cut]:
    """Halves of shapes whose pairs are not in `CUTS`, by planes in any direction."""
    generator, used = np.random.default_rng(seed), {name for name, *_ in CUTS}
    cuts = []
    for name in generator.permutation([name for name in names if name not in used])[:count]:
        normal = generator.normal(size=3)
        cuts.append((str(name), "half", tuple((normal / np.linalg.norm(normal)).tolist()), 0.0))
    return cuts


def table(cuts: Sequence[Cut], known: dict[str, Case], prepared: dict[Path, mm.Surface], factor: float = 1.0) -> str:
    columns = " | ".join(f"{task}: matches | right | missing" for task in TASKS)
    text, everything = TABLE.format(tasks=columns, rules="---|" * 8 + "---"), []
    print(text, end="")
    for name, what, normal, offset in cuts:
        left, found = run_cut(known[name], normal, offset, prepared, factor)
        everything.append(found)
        shape, pose = known[name].source.stem, known[name].target.stem
        line = f"| {shape} | {what} | {left:.0%} | {pose} | {' '.join(map(cells, found))}\n"
        text += line
        print(line, end="", flush=True)
    total = [summed([found for found in column if found is not None]) for column in zip(*everything, strict=True)]
    line = f"| **all** | | | | {' '.join(map(cells, total))}\n"
    print(line)
    return text + line


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/partial.md"))
    parser.add_argument("--cuts", type=int, default=len(CUTS), help="only the first N of the chosen cuts")
    parser.add_argument("--fresh", type=int, default=24, help="how many fresh cuts of each seed (default: 24)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 2], help="of the fresh cuts (default: 0 2)")
    parser.add_argument("--units", type=int, default=8, help="how many of the last ones in other units (default: 8)")
    options = parser.parse_args()
    if min(options.cuts, options.fresh, options.units, *options.seeds) < 0:
        parser.error("give numbers that are 0 or more")
    if not options.output.parent.is_dir():
        parser.error(f"--output: there is no folder {options.output.parent}")
    known = {case.name: case for case in cases(options.data) if case.source.parent.name in SETS}
    chosen = CUTS[: options.cuts]
    lacking = {name for name, *_ in chosen} - set(known)
    if lacking:
        sys.exit(f"{options.data}: has no pair {', '.join(sorted(lacking))}; the sets tosca and faust are needed")
    prepared: dict[Path, mm.Surface] = {}
    text = HEADING
    if chosen:
        text += CHOSEN + table(chosen, known, prepared)
    fresh: list[Cut] = []
    for seed in options.seeds if options.fresh else []:
        fresh = fresh_cuts(list(known), options.fresh, seed)
        text += FRESH.format(count=len(fresh), seed=seed, more=MORE.get(seed, "")) + table(fresh, known, prepared)
    if some := fresh[: options.units]:
        text += UNITS.format(count=len(some), seed=options.seeds[-1]) + table(some, known, prepared, FACTOR)
    text += f"\nMade by one command:\n\n    python benchmarks/partial.py {' '.join(['DATA', *sys.argv[2:]])}\n"
    write_atomically(options.output, text.encode())


if __name__ == "__main__":
    try:
        main()
    except mm.MobiusError as problem:
        sys.exit(str(problem))
