"""Fit the probability of a match of a partial shape: logistic regression on cuts that docs/partial.md does not show.

    python benchmarks/fit_partial.py DATA [--cuts N] [--seeds S ...]

DATA is the folder that holds the evaluation sets tosca and faust. The features of each match, whether it is reported or
not, are those of the program; it is right within 5 % of the diameter. Takes five minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from changes import cases
from partial import SETS, fresh_cuts, judged, prepared_cut

import mobius_match as mm
from mobius_match.matching.partial.locate import locate
from mobius_match.matching.partial.matches import (
    covered_by_part,
    features,
    points_on_part,
    points_on_whole,
    probability,
)
from mobius_match.matching.partial.pair import PartPair
from mobius_match.matching.partial.parameters import PartialParameters
from mobius_match.matching.partial.part import best_size
from mobius_match.registration.parameters import RegistrationParameters

MISSING = 20
"""Additional weight of a match on what is missing."""

REPORTED = 0.7
"""Fitted probability at which the program reports a match, which it does from 0.5: the offset is lowered."""

NAMES = ("distance_slope", "residual_slope", "boundary_slope", "stretch_slope", "cost_slope", "offset")
"""Constants, the slopes in the order of :func:`features`."""

Table = tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]
"""Features, which matches are right, and which are on the missing part."""


def matches_of(pair: PartPair, part: mm.Surface, case_and_cut: tuple, seed: int = 0) -> list[Table]:
    """The matches of both directions where the part is located at all."""
    case, cut_part, other = case_and_cut
    with ThreadPoolExecutor() as pool:
        size, _ = best_size(pair, seed, pool)
        pair = pair.scaled(size)
        placement = locate(pair, np.random.default_rng(seed), pool)
    if placement is None:
        return []
    found, tables = features(pair, placement), []
    inside = found["boundary"] >= pair.parameters.boundary_margin
    vertex, covered = covered_by_part(pair, placement)
    for reverse, rows, kept, points in (
        (False, pair.samples1, inside[pair.samples1], points_on_whole(pair, placement)[0]),
        (True, vertex, covered & inside[vertex], points_on_part(pair, placement)[0]),
    ):
        samples = other.samples if reverse else part.samples
        pairs = np.stack([samples, points.nearest], axis=1)[kept]
        right, missing = judged(cut_part, other, case, pairs, reverse)
        tables.append(({kind: values[rows[kept]] for kind, values in found.items()}, right, missing))
    return tables


def collect(data: Path, seeds: Sequence[int], count: int, parameters: PartialParameters) -> Table:
    """The matches of all cuts of these seeds."""
    known = {case.name: case for case in cases(data) if case.source.parent.name in SETS}
    prepared: dict[Path, mm.Surface] = {}
    tables: list[Table] = []
    for seed in seeds:
        for name, _, normal, offset in fresh_cuts(list(known), count, seed):
            part, _, other = prepared_cut(known[name], normal, offset, prepared, 1.0)
            pair = PartPair(part.surface, other, parameters, RegistrationParameters())
            tables += matches_of(pair, part.surface, (known[name], part, other))
            print(f"{name}: {sum(len(right) for _, right, _ in tables[-2:])} matches", flush=True)
    kinds = tables[0][0]
    columns = {kind: np.concatenate([table[0][kind] for table in tables]) for kind in kinds}
    return columns, *(np.concatenate([table[k] for table in tables]) for k in (1, 2))


def logistic_regression(columns: np.ndarray, right: np.ndarray, weight: np.ndarray, steps: int = 50) -> np.ndarray:
    """Weights of the columns (q, k) that maximise the likelihood, by Newton's method."""
    found = np.zeros(columns.shape[1])
    for _ in range(steps):
        chance = 1 / (1 + np.exp(-columns @ found))
        hessian = columns.T @ (columns * (weight * chance * (1 - chance))[:, None])
        found += np.linalg.solve(hessian, columns.T @ (weight * (right - chance)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--cuts", type=int, default=24, help="fresh cuts of each seed (default: 24)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 3], help="of the cuts (default: 1 3)")
    options = parser.parse_args()
    parameters, floor = PartialParameters(), RegistrationParameters().confidence.floor
    found, right, missing = collect(options.data, options.seeds, options.cuts, parameters)
    columns = np.stack([np.log(values + floor) for values in found.values()] + [np.ones(len(right))], axis=1)
    fitted = logistic_regression(columns, right, 1.0 + MISSING * (missing & ~right))
    fitted[-1] -= np.log(REPORTED / (1 - REPORTED))
    print(f"\n{len(right)} matches, {right.mean():.1%} right, {missing.sum()} on missing parts")
    for name, value in zip(NAMES, fitted.tolist(), strict=True):
        print(f"{name}: {value:.2f} (now {getattr(parameters, name)})")
    for what, chance in (
        ("now", probability(found, parameters, floor)),
        ("fitted", 1 / (1 + np.exp(-columns @ fitted))),
    ):
        some = chance >= 0.5
        print(f"{what}: {some.mean():.1%} reported, {right[some].mean():.2%} right, {missing[some].sum()} missing")


if __name__ == "__main__":
    main()
