"""Print how whole shapes with small holes, in other units, are matched: as many matches, as good, as without holes.

    python benchmarks/holes.py [DATA] [--pairs N] [--shares S ...] [--units F ...] [--seed N]

DATA is an evaluation set whose corres/ has NAME.vts and NAME.sym.vts, or a folder of such sets; without it the shipped
examples are used. Four holes of equal size are made at random places of the source or of the target. Errors are those
of `mobius bench`, heat distances per diameter of the target. Takes about ten seconds a line.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from changes import cases, errors
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

import mobius_match as mm
from mobius_match.evaluation import Case, Truth, examples
from mobius_match.mesh.topology import edge_table

HOLES = 4
CLEAR = 4
"""A hole is made where this many times as many faces are still there."""

FIRST = 45

Faces = tuple[np.ndarray, np.ndarray]


def punched(vertices: np.ndarray, faces: np.ndarray, share: float, rng: np.random.Generator) -> Faces:
    """A mesh, with all of its vertices, without that share of its faces: round holes apart from each other."""
    table = edge_table(faces)
    one, two = table.edge_faces[table.counts == 2].T
    middles = vertices[faces].mean(axis=1)
    lengths = np.linalg.norm(middles[one] - middles[two], axis=1)
    graph = csr_matrix((lengths, (one, two)), shape=(len(faces), len(faces)))
    kept, size = np.ones(len(faces), bool), round(share * len(faces) / HOLES)
    for centre in rng.permutation(len(faces)):
        nearest = np.argsort(dijkstra(graph, directed=False, indices=centre), kind="stable")
        if kept[nearest[: CLEAR * size]].all():
            kept[nearest[:size]] = False
        if len(faces) - kept.sum() == HOLES * size:
            break
    return vertices, faces[kept]


def shipped() -> list[Case]:
    """The shipped examples: the nearest vertex stands for the true place."""
    found = []
    for name in examples.names():
        source, target = examples.paths(name)
        faces, barycentric = examples.truth(name)
        mesh = mm.read_mesh(target)
        corners = mesh.faces[faces][np.arange(len(faces)), barycentric.argmax(axis=1)]
        found.append(Case(name, "shipped", source, target, Truth(np.arange(len(faces)), corners)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?")
    parser.add_argument("--pairs", type=int, default=6, help="how many, drawn at random (default: 6)")
    parser.add_argument("--shares", type=float, nargs="+", default=[0.004, 0.009, 0.018], help="of the faces, in total")
    parser.add_argument("--units", type=float, nargs="+", default=[0.6, 1000.0], help="of the punched shape")
    parser.add_argument("--seed", type=int, default=0, help="of pairs and places")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    known = shipped() if options.data is None else cases(options.data)
    print(f"| pair | punched | of the faces | times as large | matches | mean of first {FIRST} | mean of all |")
    print("|---|---|---|---|---|---|---|")
    for number in rng.permutation(len(known))[: options.pairs]:
        case = known[number]
        meshes = [mm.read_mesh(path) for path in (case.source, case.target)]
        for side, punched_one in enumerate(("source", "target")):
            for share in options.shares:
                vertices, faces = punched(meshes[side].vertices, meshes[side].faces, share, rng)
                for factor in options.units:
                    given: list[object] = [case.source, case.target]
                    given[side] = (factor * vertices, faces)
                    line = f"| {case.name} | {punched_one} | {share:.1%} | {factor:g} |"
                    try:
                        pairs = mm.match(*given).pairs
                    except mm.NothingFoundError:
                        print(f"{line} no match | | |", flush=True)
                        continue
                    found = errors(case, *meshes, pairs)["direct"]
                    print(f"{line} {len(pairs)} | {found[:FIRST].mean():.4f} | {found.mean():.4f} |", flush=True)


if __name__ == "__main__":
    try:
        main()
    except mm.MobiusError as problem:
        sys.exit(str(problem))
