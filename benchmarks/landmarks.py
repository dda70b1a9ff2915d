"""What known pairs are worth: errors of dense maps at other points, without landmarks and with some.

    python benchmarks/landmarks.py DATA [SET ...]

DATA is a folder with sets that `mobius bench` reads. Of the points of known correspondence of each pair, 60 are drawn
at most; the first of them are given as landmarks, and errors are measured at those that are never given: geodesic
distances on the target (heat method) per root of its area.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import mobius_match as mm
from mobius_match.evaluation.datasets import find_dataset
from mobius_match.evaluation.metrics import geodesic_distances
from mobius_match.exporting.result_meshes import vertices_numbered

GIVEN = (0, 1, 3, 5)
POINTS, WRONG = 60, 0.3


def main() -> None:
    """Measure all pairs of the sets and print a line for each, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("sets", nargs="*", default=["shrec07_fourleg", "tosca_nonisometric"])
    chosen = parser.parse_args()
    for name in chosen.sets:
        table = []
        for case in find_dataset(chosen.data / name).cases:
            source, target = (mm.prepare(path, cache=True) for path in (case.source, case.target))
            known = np.stack([case.truth.source, case.truth.target], axis=1)
            known = known[np.random.default_rng(0).permutation(len(known))[:POINTS]]
            mesh, rest = target.whole_mesh, known[max(GIVEN) :]
            errors = []
            for number in GIVEN:
                result = mm.match(source, target, landmarks=known[:number] if number else None)
                images = result.dense().vertex_map[rest[:, 0]]
                ends = (vertices_numbered(mesh, vertices) for vertices in (rest[images >= 0, 1], images[images >= 0]))
                apart = geodesic_distances(mesh, *ends, "heat")
                errors.append(apart.mean() / np.sqrt(target.area))
            table.append(errors)
            print(f"{case.name}: {' '.join(f'{error:.3f}' for error in errors)}", flush=True)
        means, wrong = np.mean(table, axis=0), np.sum(np.array(table) > WRONG, axis=0)
        for number, mean, bad in zip(GIVEN, means, wrong, strict=True):
            print(f"{name}, {len(table)} pairs, {number} landmarks: mean {mean:.3f}, {bad} above {WRONG}")


if __name__ == "__main__":
    main()
