"""How much of the errors is how far the known points lie apart.

    python benchmarks/coarse_truth.py DATA [--geodesics heat]

DATA is an evaluation set whose corres/ has NAME.vts and NAME.sym.vts, or a folder of such sets. `mobius bench` compares
a match with the known point nearest to its source, and counts how far that lies away as error. Here the truth is
carried on to the match's own source as well: from the nearest known points around it, by the similarity that fits them
best. Takes a few seconds a pair.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from changes import cases
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.evaluation import Case
from mobius_match.evaluation.metrics import geodesic_distances
from mobius_match.evaluation.scoring import Scorer, cached_diameter, mesh_area, repaired_vertices
from mobius_match.evaluation.summary import CLOSE, FEW, MANY
from mobius_match.geometry.geodesics import edge_graph
from mobius_match.geometry.rotations import nearest_rotations

AROUND, CLOSEST = 7, 0.01
"""Known points that the truth is carried on from, and the distance per sqrt(area) below which all weigh the same."""


def carried(source: mm.Mesh, target: mm.Mesh, known: np.ndarray, images: np.ndarray, vertices: np.ndarray) -> tuple:
    """True places of the source's vertices (q,) as vertices of the target (q,), and how far the nearest known point is.

    Known points (p,) of the source have images (p,), vertices of the target.
    """
    graph = edge_graph(source.vertices, source.faces)
    apart = dijkstra(graph, directed=False, indices=vertices)[:, known]
    nearest = np.argsort(apart, axis=1, kind="stable")[:, :AROUND]
    close = CLOSEST * np.sqrt(mesh_area(source))
    places = np.empty((len(vertices), 3))
    for i, some in enumerate(nearest):
        weights = 1 / (apart[i, some] + close)
        here = source.vertices[known[some]] - source.vertices[vertices[i]]
        places[i] = _origin_after(here, target.vertices[images[some]], weights / weights.sum())
    least = apart.min(axis=1)
    places[least == 0] = target.vertices[images[nearest[least == 0, 0]]]
    return cKDTree(target.vertices).query(places)[1], least


def _origin_after(here: np.ndarray, there: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Where the similarity that takes points to points (k, 3) takes the origin (Umeyama 1991)."""
    middle, goal = weights @ here, weights @ there
    first, second = here - middle, there - goal
    product = (weights[:, None] * first).T @ second
    turn = nearest_rotations(product[None])[0]
    scale = (turn * product).sum() / (weights @ (first**2).sum(axis=1))
    return goal - scale * middle @ turn


def errors_of(case: Case, method: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of the matches per diameter by either truth, in order of confidence, and how far the known points are."""
    result = mm.match(case.source, case.target)
    source, target = result.source.whole_mesh, result.target.whole_mesh
    scorer = Scorer(case, source, target, method, cached_diameter(target, method))
    plain = scorer.score(result.pairs, result.confidence)["direct"]
    truth = scorer.truth
    known, first = np.unique(truth.source, return_index=True)
    here, there = repaired_vertices(source, result.pairs[:, 0]), repaired_vertices(target, result.pairs[:, 1])
    places, apart = carried(source, target, known, truth.target[first], here)
    errors = geodesic_distances(target, there, places, method) / scorer.diameter
    return plain, errors, apart / cached_diameter(source, method)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--geodesics", choices=("exact", "heat"), default="heat")
    args = parser.parse_args()
    found = [errors_of(case, args.geodesics) for case in cases(args.data)]
    apart = np.concatenate([one[2] for one in found])
    print(
        f"{len(found)} pairs; nearest known point: {np.median(apart):.4f} away, {np.quantile(apart, 0.9):.4f} a tenth"
    )
    for number, name in enumerate(("the nearest known point", "carried on")):
        lists = [one[number] for one in found]
        first15 = np.mean([len(one) >= FEW and (one[:FEW] <= CLOSE).all() for one in lists])
        means = [np.mean([one[:count].mean() for one in lists]) for count in (FEW, MANY)]
        print(f"{name}: first 15 {means[0]:.4f}, first 45 {means[1]:.4f}, first 15 within 3 %: {first15:.0%}")


if __name__ == "__main__":
    main()
