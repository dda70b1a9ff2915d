"""Fit the logistic model of confidence, and say how well it does on classes that it was not fitted on.

    python benchmarks/fit_confidence.py DATA [--sets NAME ...] [--every K] [--seeds N]

DATA is a folder of evaluation sets. Every place of the source's proxy, under the chosen alignment of each pair, is an
observation: its confidence terms, and whether it lies within 5 % of the diameter of its true place. Each pair has the
same weight. Prints the slopes and the offset, which stand in `ConfidenceParameters`, and for each class the log loss
of a model fitted on the others. Takes two to four seconds a pair.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.special import expit

import mobius_match as mm
from mobius_match.errors import FormatError
from mobius_match.evaluation import Case, find_dataset
from mobius_match.evaluation.scoring import Scorer, cached_diameter
from mobius_match.matching.outcome import align
from mobius_match.matching.parameters import Parameters
from mobius_match.registration.confidence import confidence_terms, distances_to_images
from mobius_match.settings import MatchSettings
from mobius_match.voting.votes import cast_votes

SETS = ("tosca", "faust", "tosca_nonisometric", "smal")
RIGHT = 0.05
"""Error per diameter up to which a match is right."""

RIDGE = 1e-3
"""Keeps the slopes finite where the terms separate right from wrong."""


def observations(case: Case, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms of the confidence terms (q, 4), and which places are right (q,), of one pair."""
    parameters, settings = Parameters(), MatchSettings(seed=seed)
    confidence = parameters.alignment.registration.confidence
    source, target = mm.prepare(case.source, cache=True), mm.prepare(case.target, cache=True)
    votes = cast_votes(source, target, settings)
    alignment = align(source, target, votes, settings, parameters).alignments[0]
    registration = alignment.registered(source, target, parameters.alignment)
    distances = distances_to_images(source, target, registration)
    terms = confidence_terms(source, target, registration, distances, confidence)
    columns = [np.log(getattr(terms, name) + confidence.floor) for name in vars(confidence.slopes)]
    pairs = np.stack([source.mesh.vertex_ids[source.proxy], target.mesh.vertex_ids[registration.image]], axis=1)
    scorer = Scorer(case, source.whole_mesh, target.whole_mesh, "heat", cached_diameter(target.whole_mesh, "heat"))
    errors = scorer.score(pairs, np.ones(len(pairs)))["direct"]
    known = np.isfinite(errors)
    return np.stack(columns, axis=1)[known], errors[known] <= RIGHT


def fitted(columns: np.ndarray, right: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Slopes (4,) and offset of a logistic model, by Newton's method, of observations with weights (q,)."""
    design = np.hstack([columns, np.ones((len(columns), 1))])
    model = np.zeros(design.shape[1])
    for _ in range(50):
        probability = expit(design @ model)
        gradient = design.T @ (weights * (right - probability)) - RIDGE * model
        curvature = design.T @ (design * (weights * probability * (1 - probability))[:, None])
        step = np.linalg.solve(curvature + RIDGE * np.eye(len(model)), gradient)
        model += step
        if np.abs(step).max() < 1e-8:
            break
    return model


def log_loss(model: np.ndarray, columns: np.ndarray, right: np.ndarray, weights: np.ndarray) -> float:
    """Mean negative logarithm of the probability of what is the case."""
    probability = np.clip(expit(columns @ model[:-1] + model[-1]), 1e-9, 1 - 1e-9)
    return float(-(weights * np.log(np.where(right, probability, 1 - probability))).sum() / weights.sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--sets", nargs="+", default=SETS)
    parser.add_argument("--every", type=int, default=1, help="only every K-th pair of each set (1)")
    parser.add_argument("--seeds", type=int, default=1, help="how many seeds, from 0 (1)")
    options = parser.parse_args()
    found: list[tuple[str, np.ndarray, np.ndarray]] = []
    for name in options.sets:
        try:
            cases = list(find_dataset(options.data / name).cases)[:: options.every]
        except FormatError as error:
            parser.error(str(error))
        for case in cases:
            for seed in range(options.seeds):
                columns, right = observations(case, seed)
                kind = name if name != "tosca" else f"tosca {case.source.stem.rstrip('0123456789')}"
                found.append((kind, columns, right))
                print(f"{kind} {case.name}: {right.mean():.0%} of {len(right)} right", flush=True)
    kinds = np.concatenate([[kind] * len(right) for kind, _, right in found])
    columns, right = (np.concatenate([one[k] for one in found]) for k in (1, 2))
    weights = np.concatenate([np.full(len(one[2]), 1 / len(one[2])) for one in found])
    current = Parameters().alignment.registration.confidence
    used = np.array([*vars(current.slopes).values(), current.offset])
    print(
        "\n| class left out | pairs | log loss, fitted on the others | log loss of the values in use |\n|---|---|---|---|"
    )
    for kind in dict.fromkeys(kinds.tolist()):
        out = kinds == kind
        model = fitted(columns[~out], right[~out], weights[~out])
        losses = [log_loss(one, columns[out], right[out], weights[out]) for one in (model, used)]
        number = sum(one[0] == kind for one in found)
        print(f"| {kind} | {number} | {losses[0]:.4f} | {losses[1]:.4f} |")
    model = fitted(columns, right, weights)
    names = [*vars(current.slopes), "offset"]
    print("\nall:", ", ".join(f"{name} {value:.2f}" for name, value in zip(names, model, strict=True)))
    print(f"log loss {log_loss(model, columns, right, weights):.4f}, of the values in use", end=" ")
    print(f"{log_loss(used, columns, right, weights):.4f}")


if __name__ == "__main__":
    main()
