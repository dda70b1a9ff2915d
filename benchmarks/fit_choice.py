"""Fit the model of the choice between alignments, and say how well it does on kinds that it was not fitted on.

    python benchmarks/fit_choice.py record TABLE.npz FOLDER ... [--every K] [--unrelated PAIRS]
    python benchmarks/fit_choice.py fit TABLE.npz ...

``record`` matches the pairs of evaluation sets, registers the source along each candidate alignment, and writes the
evidence for each and its true error. With --unrelated, PAIRS is a file of two meshes a line that do not belong
together: of those every alignment is wrong. It takes about five seconds a pair.

``fit`` prints the weights and the offset, which stand in `ChoiceParameters`, and for each kind how a model does that
was fitted on the others: pairs whose most probable alignment is wrong, those among them for which a right one was
there, those that were given a probability above the one that warns, and the mean negative logarithm of the probability
of what is the case. An alignment is right where its mean error is at most 0.15 sqrt(area) and at most 0.03 more than that of another one. Pairs of a kind share a
weight of the square root of their number.
"""

from __future__ import annotations

import argparse
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment
from mobius_match.alignments.candidates import Candidates
from mobius_match.alignments.evidence import evidence
from mobius_match.alignments.parameters import Evidence
from mobius_match.alignments.selection import probabilities
from mobius_match.errors import MobiusError
from mobius_match.evaluation import Case, Truth, find_dataset
from mobius_match.evaluation.scoring import repaired_vertices
from mobius_match.evaluation.vertexlists import read_vertices
from mobius_match.matching.parameters import Parameters
from mobius_match.settings import MatchSettings
from mobius_match.surface.surface import Surface
from mobius_match.voting.votes import cast_votes

RIGHT = 0.15
"""Mean error per sqrt(area) up to which an alignment is right as a whole."""

AS_GOOD = 0.03
"""An alignment is wrong, too, if another one of the pair has a mean error smaller by this: two limbs are exchanged."""

RIDGE = 3e-3
"""Penalty of the squared weights of standardised terms, per pair."""

MOST = 5
"""Candidates of a pair that are registered: of votes, and of extremities and rigid motions."""

TERMS = tuple(one.name for one in fields(Evidence))


def candidates_of(source: Surface, target: Surface, parameters: Parameters) -> list[Alignment]:
    """Candidates of a pair, also those that a match leaves out to save time."""
    settings, of_alignment = MatchSettings(seed=0, jobs=1), parameters.alignment
    votes = cast_votes(source, target, settings)
    candidates = Candidates(source, target, of_alignment)
    found = candidates.voted(votes)[:MOST]
    differ = bool(found) and found[0].cost > of_alignment.selection.different_above
    found += candidates.further(found)[:MOST]
    return [replace(one, shapes_differ=differ) for one in found]


def mean_error(source: Surface, target: Surface, image: np.ndarray, truth: Truth) -> float:
    """Mean distance per sqrt(area) of images (P1,) of the proxy from the true places of the points nearest to it."""
    here, there = (
        repaired_vertices(one.whole_mesh, vertices)
        for one, vertices in ((source, truth.source), (target, truth.target))
    )
    known = (here >= 0) & (there >= 0)
    tree = scipy.spatial.cKDTree(source.mesh.vertices[source.proxy])
    nearest = tree.query(source.whole_mesh.vertices[here[known]])[1]
    gaps = target.mesh.vertices[image[nearest]] - target.whole_mesh.vertices[there[known]]
    return float(np.linalg.norm(gaps, axis=1).mean() / target.scale)


def truths_of(case: Case) -> list[Truth]:
    """The known correspondence of a pair, and others that are as right: by turns that nearly are symmetries.

    The lists of a family of shapes with such turns are ``corres/NAME.turnK.vts`` (see tools/README.md).
    """
    names = sorted((case.target.parent / "corres").glob(f"{case.target.stem}.turn*.vts"))
    return [case.truth, *(replace(case.truth, target=read_vertices(name, 1)) for name in names)]


def record(source: Path, target: Path, truths: list[Truth]) -> tuple[np.ndarray, np.ndarray]:
    """The evidence (c, terms) for the candidates of a pair, and their true errors (c,), by the nearest truth; infinite without one."""
    parameters = Parameters()
    first, second = mm.prepare(source, cache=True), mm.prepare(target, cache=True)
    rows, errors = [], []
    with threadpool_limits(limits=1, user_api="blas"):
        for one in candidates_of(first, second, parameters):
            registration = one.registered(first, second, parameters.alignment)
            found = evidence(first, second, registration)
            rows.append([*found.values(), one.cost])
            errors.append(min((mean_error(first, second, registration.image, one) for one in truths), default=np.inf))
    return np.array(rows).reshape(-1, len(TERMS) + 1), np.array(errors)


def record_all(options: argparse.Namespace) -> None:
    """Record the pairs of all folders, and write the table."""
    tasks: list[tuple[str, str, Path, Path, list[Truth]]] = []
    for folder in options.folders:
        for case in list(find_dataset(folder).cases)[:: options.every]:
            kind = f"{folder.name} {case.category}" if options.categories else folder.name
            tasks.append((kind, case.name, case.source, case.target, truths_of(case)))
    if options.unrelated:
        for line in options.unrelated.read_text().split("\n"):
            if line.strip():
                one, two = (options.unrelated.parent / name for name in line.split()[:2])
                tasks.append(("unrelated", f"{one.stem}-{two.stem}", one, two, []))
    table: dict[str, list[np.ndarray]] = {name: [] for name in ("kind", "pair", "terms", "error")}
    for kind, name, source, target, truths in tasks:
        try:
            terms, errors = record(source, target, truths)
        except MobiusError as error:
            print(f"{kind} {name}: {error}", flush=True)
            continue
        for key, values in (
            ("kind", np.full(len(errors), kind)),
            ("pair", np.full(len(errors), f"{kind} {name}")),
            ("terms", terms),
            ("error", errors),
        ):
            table[key].append(values)
        if len(errors):
            print(
                f"{kind} {name}: {len(errors)} alignments, first {errors[0]:.3f}, best {errors.min():.3f}", flush=True
            )
            np.savez(options.table, **{key: np.concatenate(values) for key, values in table.items()})


Observation = tuple[str, str, np.ndarray, np.ndarray]
"""Kind and name of a pair, the terms (c, t) of its alignments and their errors (c,)."""


def observations(tables: list[Path]) -> list[Observation]:
    """The pairs of recorded tables."""
    found = []
    for path in tables:
        table = np.load(path)
        for pair in dict.fromkeys(table["pair"].tolist()):
            rows = table["pair"] == pair
            found.append((str(table["kind"][rows][0]), pair, table["terms"][rows], table["error"][rows]))
    return found


def fitted(terms: list[np.ndarray], right: list[np.ndarray], weights: list[float]) -> np.ndarray:
    """Weights (t,) and offset that maximise the weighted likelihood of what is the case for each pair."""
    stacked = np.concatenate(terms)
    middle, spread = stacked.mean(axis=0), stacked.std(axis=0) + 1e-9
    designs = [np.hstack([(one - middle) / spread, np.ones((len(one), 1))]) for one in terms]
    penalty = RIDGE * sum(weights) * np.append(np.ones(len(middle)), 0.0)

    def loss(model: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient = float(penalty @ model**2), 2 * penalty * model
        for design, good, weight in zip(designs, right, weights, strict=True):
            chances = probabilities(design @ model)
            share = chances * good if good.any() else np.zeros(len(chances))
            total = share.sum() if good.any() else 1 - chances.sum()
            value -= weight * np.log(max(total, 1e-12))
            gradient += weight * (design.T @ (chances - share / max(total, 1e-12)))
        return value, gradient

    bounds = [(None, 0.0)] * len(middle) + [(None, None)]  # no term speaks for an alignment by being large
    found = scipy.optimize.minimize(loss, np.zeros(len(bounds)), jac=True, method="L-BFGS-B", bounds=bounds).x
    slopes = found[:-1] / spread
    return np.append(slopes, found[-1] - slopes @ middle)


def is_right(errors: np.ndarray) -> np.ndarray:
    """Which alignments (c,) of a pair are right, from their errors."""
    return (errors <= RIGHT) & (errors <= errors.min(initial=np.inf) + AS_GOOD)


def summary(found: list[tuple[np.ndarray, np.ndarray]], warned_below: float) -> str:
    """Cells of a table for pairs: the chances of their alignments and their errors."""
    best = np.array([errors[chances.argmax()] for chances, errors in found])
    least = np.array([errors.min() for _, errors in found])
    sure = np.array([chances.max() >= warned_below for chances, _ in found])
    truths = [
        chances[is_right(errors)].sum() if is_right(errors).any() else 1 - chances.sum() for chances, errors in found
    ]
    wrong, related = best > RIGHT, np.isfinite(least)
    mean = f"{best[related].mean():.3f}" if related.any() else ""
    cells = [
        len(found),
        int((wrong & related).sum()),
        int((wrong & related & (least <= RIGHT)).sum()),
        int((wrong & sure).sum()),
        int((~wrong & ~sure).sum()),
        mean,
        f"{-np.log(np.maximum(truths, 1e-6)).mean():.3f}",
    ]
    return " | ".join(map(str, cells))


def fit(options: argparse.Namespace) -> None:
    """Print the model, and how well models do on kinds that they were not fitted on."""
    pairs = observations(options.tables)
    chosen = [TERMS.index(name) for name in TERMS if name not in options.without]
    columns = [one[2][:, chosen] for one in pairs]
    kinds = np.array([one[0] for one in pairs])
    right = [is_right(one[3]) for one in pairs]
    weights = [float((kinds == one[0]).sum()) ** -0.5 for one in pairs]
    warned = Parameters().alignment.selection.doubted_below
    everything: list[tuple[np.ndarray, np.ndarray]] = []
    print(
        "| kind left out | pairs | wrong | of these avoidable | wrong, no warning | right, warning | mean | log loss |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for kind in dict.fromkeys(kinds.tolist()):
        kept = np.flatnonzero(kinds != kind)
        model = fitted([columns[i] for i in kept], [right[i] for i in kept], [weights[i] for i in kept])
        of_kind = [
            (probabilities(columns[i] @ model[:-1] + model[-1]), pairs[i][3]) for i in np.flatnonzero(kinds == kind)
        ]
        everything += of_kind
        print(f"| {kind} | {summary(of_kind, warned)} |")
        for i, (chances, errors) in zip(np.flatnonzero(kinds == kind), of_kind, strict=True):
            if options.verbose and errors[chances.argmax()] > RIGHT and np.isfinite(errors).any():
                print(
                    f"    {pairs[i][1]}: error {errors[chances.argmax()]:.3f}, probability {chances.max():.2f}, best {errors.min():.3f}"
                )
    print(f"| all | {summary(everything, warned)} |")
    by_cost = [(np.exp(-one[2][:, -1]), one[3]) for one in pairs]
    print(f"by cost alone: {summary(by_cost, warned)}")
    model = fitted(columns, right, weights)
    for name, value in zip([*(TERMS[i] for i in chosen), "offset"], model, strict=True):
        print(f"{name} {value:.3g}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    recording = commands.add_parser("record")
    recording.add_argument("table", type=Path)
    recording.add_argument("folders", type=Path, nargs="*")
    recording.add_argument("--every", type=int, default=1, help="only every K-th pair of each set (1)")
    recording.add_argument("--categories", action="store_true", help="each category of a set is a kind of its own")
    recording.add_argument("--unrelated", type=Path, help="file of pairs that do not belong together")
    recording.set_defaults(run=record_all)
    fitting = commands.add_parser("fit")
    fitting.add_argument("tables", type=Path, nargs="+")
    fitting.add_argument("--without", nargs="*", default=[], choices=TERMS, help="terms to leave out")
    fitting.add_argument("--verbose", action="store_true", help="name the pairs that are wrong")
    fitting.set_defaults(run=fit)
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
