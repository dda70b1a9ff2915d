"""Error of the sparse matches on pairs with ground truth, per geodesic diameter of the target.

    python benchmarks/accuracy.py DIR                     # every pair of DIR/pairs.txt, default settings
    python benchmarks/accuracy.py DIR --pair wolf0 wolf1 --preset paper

DIR holds NAME.off, pairs.txt with two names a line, and corres/NAME.vts: line i of two such lists, counted from 1, is
the same surface point (corres/NAME.sym.vts: with left and right exchanged).
"""

from __future__ import annotations

import argparse
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.settings import make_settings


def errors(result: mm.Correspondence, folder: Path, mirrored: bool = False) -> np.ndarray:
    """Error of each match in order of confidence: geodesic distance to the listed point nearest to its source."""
    source, target = (Path(info["path"]).stem for info in (result.source_info, result.target_info))
    first = np.loadtxt(folder / "corres" / f"{source}.vts", dtype=int) - 1
    second = np.loadtxt(folder / "corres" / f"{target}{'.sym' if mirrored else ''}.vts", dtype=int) - 1
    vertices = mm.read_mesh(folder / f"{source}.off").vertices
    line = cKDTree(vertices[first]).query(vertices[result.pairs[:, 0]])[1]
    mesh = mm.read_mesh(folder / f"{target}.off")
    distances_from = geodesic_solver(mesh.vertices, mesh.faces)
    found = [
        0.0 if truth == match else distances_from(int(match))[truth]
        for truth, match in zip(second[line], result.pairs[:, 1], strict=True)
    ]
    return np.array(found) / result.target_info["diameter"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pair", nargs=2, metavar=("SOURCE", "TARGET"))
    parser.add_argument("--preset")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    lines = (options.folder / "pairs.txt").read_text().split("\n")
    pairs = [tuple(options.pair)] if options.pair else [tuple(line.split()) for line in lines if line.strip()]
    preparation = make_settings(options.preset).preparation()

    @lru_cache
    def surface(name: str) -> mm.Surface:
        return mm.prepare(options.folder / f"{name}.off", preparation)

    means = []
    print(f"{'pair':32}  first 15  first 45   largest of 45  matches  mirrored 45")
    for source, target in pairs:
        result = mm.match(surface(source), surface(target), preset=options.preset, seed=options.seed)
        direct = errors(result, options.folder)
        mirrored = errors(result, options.folder, mirrored=True)[:45].mean()
        means.append((direct[:15].mean(), direct[:45].mean()))
        print(
            f"{source + ' ' + target:32}  {means[-1][0]:8.4f}  {means[-1][1]:8.4f}  {direct[:45].max():14.4f}"
            f"  {len(direct):7}  {mirrored:11.4f}"
        )
    first, second = np.mean(means, axis=0)
    above = sum(mean > 0.10 for _, mean in means)
    print(f"{f'mean of {len(means)} pairs':32}  {first:8.4f}  {second:8.4f}  above 0.10: {above}")


if __name__ == "__main__":
    main()
