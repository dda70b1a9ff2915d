"""Make docs/images/distances.png: how far shapes are from isometric, in poses, individuals and kinds.

    python benchmarks/distances.py DATA [-o docs/images/distances.png]

DATA is a folder with the sets tosca, faust and tosca_nonisometric (OFF files). Prints the means in each relation.
"""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

import mobius_match as mm

SHAPES = {
    "person 1": ("faust", "tr_reg_000", "tr_reg_003"),
    "person 2": ("faust", "tr_reg_010", "tr_reg_014"),
    "woman": ("tosca_nonisometric", "8_woman_01", "8_woman_04"),
    "gorilla": ("tosca_nonisometric", "8_gorilla_01", "8_gorilla_03"),
    "cat": ("tosca", "cat0", "cat6"),
    "dog": ("tosca", "dog0", "dog6"),
    "horse": ("tosca", "horse0", "horse7"),
}
CLASS = {"person 1": "people", "person 2": "people", "woman": "people"}


def main() -> None:
    """Match all pairs, draw and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images/distances.png"))
    chosen = parser.parse_args()
    labels, surfaces = [], []
    for name, (folder, *poses) in SHAPES.items():
        for pose in poses:
            labels.append(name)
            surfaces.append(mm.prepare(chosen.data / folder / f"{pose}.off"))
    matrix = np.zeros((len(labels), len(labels)))
    relations: dict[str, list[float]] = {"two poses of one body": [], "two bodies of a class": [], "two classes": []}
    for i, j in itertools.combinations(range(len(labels)), 2):
        try:
            matrix[i, j] = matrix[j, i] = mm.isometric_distance(mm.match(surfaces[i], surfaces[j], threshold=0).dense())
        except mm.NothingFoundError:
            matrix[i, j] = matrix[j, i] = np.nan
        first, second = labels[i], labels[j]
        same = CLASS.get(first, first) == CLASS.get(second, second)
        relation = list(relations)[0 if first == second else 1 if same else 2]
        relations[relation].append(matrix[i, j])
    for relation, values in relations.items():
        print(f"{relation}: {np.nanmean(values):.3f}, from {np.nanmin(values):.3f} to {np.nanmax(values):.3f}")
    figure, axes = plt.subplots(figsize=(6.4, 5.4), layout="constrained")
    image = axes.imshow(matrix, cmap="cividis")
    for i, j in itertools.product(range(len(labels)), repeat=2):
        if i != j:
            light = matrix[i, j] < np.nanmax(matrix) * 0.6
            axes.text(j, i, f"{100 * matrix[i, j]:.0f}", ha="center", va="center", color="w" if light else "k", size=8)
    middles = np.arange(len(SHAPES)) * 2 + 0.5
    axes.set_xticks(middles, SHAPES, rotation=45, ha="right")
    axes.set_yticks(middles, SHAPES)
    for edge in np.arange(1, len(SHAPES)) * 2 - 0.5:
        axes.axhline(edge, color="w", lw=0.8)
        axes.axvline(edge, color="w", lw=0.8)
    axes.set_title("Distance from isometry, hundredths of sqrt(area); two poses each", size=10)
    figure.colorbar(image, shrink=0.8)
    figure.savefig(chosen.output, dpi=110)


if __name__ == "__main__":
    main()
