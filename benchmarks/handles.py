"""Seconds to find the handles of a mesh and to cut them open, warm.

    python benchmarks/handles.py [MESH ...]

By default a chain of four tori with 15,000 vertices, by marching cubes. Lengths of loops are per sqrt(area); the least
time of five runs counts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator

import numpy as np

from mobius_match.mesh import Mesh, read_mesh, repair
from mobius_match.mesh.handles import cut_along, handle_loops, loop_lengths, number_of_handles
from mobius_match.mesh.measure import areas, unit_box
from mobius_match.mesh.pieces import main_piece

RUNS = 5


def chain(links: int = 4, step: float = 0.075) -> Mesh:
    """Tori of different thickness in a row, each joined to the next."""
    import igl

    low, high = np.array([-2.0, -2.0, -1.0]), np.array([2.6 * links, 2.0, 1.0])
    axes = [np.arange(start, end, step) for start, end in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    distances = [
        np.hypot(np.hypot(points[:, 0] - 2.6 * k, points[:, 1]) - 1.1, points[:, 2]) - 0.3 - 0.05 * k
        for k in range(links)
    ]
    vertices, faces = igl.marching_cubes(np.min(distances, axis=0), points, *map(len, axes), 0.0)[:2]
    return Mesh(vertices, faces, name=f"chain of {links} tori")


def meshes() -> Iterator[Mesh]:
    if len(sys.argv) < 2:
        yield chain()
    for path in sys.argv[1:]:
        yield read_mesh(path)


def main() -> None:
    handle_loops(main_piece(repair(chain(1, 0.2))))  # compiles
    print(f"{'mesh':24} {'vertices':>8} {'handles':>7} {'seconds':>8}  lengths of the loops")
    for given in meshes():
        mesh = main_piece(repair(given))
        runs = []
        for _ in range(RUNS):
            start = time.perf_counter()
            loops = handle_loops(mesh)
            cut = cut_along(mesh, loops)[0] if loops else mesh
            runs.append(time.perf_counter() - start)
        lengths = loop_lengths(unit_box(mesh.vertices), loops) / np.sqrt(areas(mesh.vertices, mesh.faces).sum())
        listed = " ".join(f"{length:.3f}" for length in lengths[:8])
        print(f"{mesh.name:24} {len(mesh.vertices):8} {len(loops):7} {min(runs):8.3f}  {listed}")
        if number_of_handles(cut.faces):
            sys.exit("the surface that was cut open has handles")


if __name__ == "__main__":
    main()
