"""Errors of the mirror symmetry of single shapes against known left and right.

    python benchmarks/symmetry.py DATA [--scoring heat] [--seed N] [--output FILE.md]

DATA holds folders with meshes NAME.off, corres/NAME.vts and corres/NAME.sym.vts: line i of the second is the mirror
image of line i of the first, numbers from 1. A pair is right if its target lies within 5 % of the geodesic diameter of
the mirror image of its source.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import mobius_match as mm
from mobius_match.evaluation import metrics
from mobius_match.evaluation.datasets import Case, Truth
from mobius_match.evaluation.scoring import Scorer
from mobius_match.evaluation.vertexlists import read_vertices

RADIUS, SHARE = 0.05, 0.8
HEADING = """| set | shapes | with 80 % right | with 90 % right | pairs | right | mean error | score |
|---|---|---|---|---|---|---|---|
"""


class Measured(NamedTuple):
    """What is known of one shape."""

    name: str
    errors: np.ndarray
    confidence: np.ndarray
    score: float

    @property
    def right(self) -> float:
        """The part of the pairs that are right, 0 if there are none."""
        return float(np.mean(self.errors < RADIUS)) if len(self.errors) else 0.0


def measure(path: Path, scoring: str, seed: int) -> Measured:
    """Find the symmetry of one shape, and how far its pairs are off."""
    try:
        result = mm.symmetry(path, seed=seed, jobs=1)
    except mm.NothingFoundError:
        return Measured(path.stem, np.empty(0), np.empty(0), 0.0)
    lists = [read_vertices(path.parent / "corres" / f"{path.stem}{ending}.vts", base=1) for ending in ("", ".sym")]
    mesh = result.source.mesh
    case = Case(path.stem, "", path, path, Truth(*lists))
    scorer = Scorer(case, mesh, mesh, scoring, metrics.diameter(mesh, scoring))
    errors = scorer.score(result.pairs, result.confidence)["direct"]
    return Measured(path.stem, errors, result.confidence, result.score)


def row(name: str, shapes: list[Measured]) -> str:
    """A line of the table."""
    rights = np.array([shape.right for shape in shapes])
    scores = [shape.score for shape in shapes]
    return (
        f"| {name} | {len(shapes)} | {np.mean(rights >= SHARE):.0%} | {np.mean(rights >= 0.9):.0%} "
        f"| {np.mean([len(shape.errors) for shape in shapes]):.0f} | {rights.mean():.1%} "
        f"| {np.nanmean([shape.errors.mean() for shape in shapes if len(shape.errors)]):.4f} "
        f"| {min(scores):.2f} to {max(scores):.2f} |\n"
    )


def ranks(shapes: list[Measured]) -> str:
    """How often pairs of about one confidence are right."""
    errors, confidence = (np.concatenate([getattr(shape, name) for shape in shapes]) for name in Measured._fields[1:3])
    steps = np.arange(0.4, 1.0, 0.1)
    lines = []
    for low in steps:
        some = (confidence >= low) & (confidence < low + 0.1 + 1e-9 * (low > 0.85))
        if some.any():
            lines.append(f"| {low:.1f} to {low + 0.1:.1f} | {some.sum()} | {np.mean(errors[some] < RADIUS):.1%} |\n")
    return "| confidence | pairs | right |\n|---|---|---|\n" + "".join(lines)


def main() -> None:
    """Measure all sets and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, metavar="DATA", help="folder of sets")
    parser.add_argument("--scoring", choices=("exact", "heat"), default="exact", help="geodesics of the errors")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--output", type=Path, help="write the tables to this file too")
    options = parser.parse_args()
    tables, everything = HEADING, []
    with ProcessPoolExecutor(options.jobs) as pool:
        for folder in sorted(path for path in options.data.iterdir() if path.is_dir()):
            files = [
                path for path in sorted(folder.glob("*.off")) if (folder / f"corres/{path.stem}.sym.vts").is_file()
            ]
            if not files:
                continue
            shapes = list(pool.map(partial(measure, scoring=options.scoring, seed=options.seed), files))
            for shape in shapes:
                if shape.right < SHARE:
                    print(f"{folder.name} {shape.name}: {shape.right:.0%} of {len(shape.errors)} pairs are right")
            tables += row(folder.name, shapes)
            everything += shapes
    if not everything:
        parser.error(f"{options.data} has no folder with corres/NAME.sym.vts")
    tables += row("all", everything) + "\n" + ranks(everything)
    print(tables)
    if options.output is not None:
        options.output.write_text(tables, encoding="utf-8")


if __name__ == "__main__":
    main()
