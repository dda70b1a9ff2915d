"""Time and memory of each stage from two files to matches, by size, and how preparation grows; docs/performance.md.

    python benchmarks/stages.py [THOUSANDS ...] [--runs R] [--markdown] [--plot FILE]

The pair is the shipped person, subdivided (Loop) and simplified to so many thousand vertices, each mesh on its own.
Every size is measured in a process of its own, after a small pair has had everything compiled and loaded; the
least time of R runs counts. Seconds of the two meshes overlap where they are prepared at once, so "wall" is less than
the sum.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.mesh import read_mesh, repair
from mobius_match.mesh.measure import unit_box
from mobius_match.mesh.simplify import simplify

SIZES = (5, 20, 100, 500, 1000)
STAGES = ("reading", "simplifying", "sampling", "flattening", "descriptors", "preparation")
REST = ("voting", "alignments", "matches", "total")


def make(thousands: int, folder: Path) -> None:
    """Two poses with so many thousand vertices, as OFF."""
    import trimesh

    for pose, path in enumerate(examples.paths("person")):
        mesh = repair(read_mesh(path))
        vertices, faces = mesh.vertices, mesh.faces
        if thousands > 5:
            while len(vertices) < 1300 * thousands:
                vertices, faces = trimesh.remesh.subdivide_loop(vertices, faces, iterations=1)
            kept, faces, _ = simplify(unit_box(vertices), np.asarray(faces), 1000 * thousands)
            vertices = vertices[kept]
        with (folder / f"{pose}.off").open("w") as stream:
            stream.write(f"OFF\n{len(vertices)} {len(faces)} 0\n")
            np.savetxt(stream, vertices, "%.9g")
            np.savetxt(stream, np.column_stack([np.full(len(faces), 3), faces]), "%d")


def measure(folder: Path, runs: int) -> dict[str, float]:
    """Seconds by stage (of one mesh, the mean of the two) and megabytes."""
    before = mm.match(*examples.paths("person"))
    best: dict[str, float] = {}
    for _ in range(runs):
        start = time.perf_counter()
        result = mm.match(folder / "0.off", folder / "1.off")
        found = {name: result.timings[name] for name in ("reading", "preparation", *REST)}
        for name in STAGES[1:-1]:
            found[name] = np.mean([result.timings.get(f"{side} {name}", 0.0) for side in ("source", "target")])
        found["wall"] = time.perf_counter() - start
        start, cpu = time.perf_counter(), time.process_time()
        surface = mm.prepare(folder / "0.off")
        found["one mesh"], found["one mesh, processor"] = time.perf_counter() - start, time.process_time() - cpu
        mm.match(before.source, before.target)
        start = time.perf_counter()
        mm.match(result.source, result.target)
        found["prepared pair"] = time.perf_counter() - start
        best = {name: min(best.get(name, np.inf), float(value)) for name, value in found.items()}
    best["vertices"] = len(surface.whole_mesh.vertices)
    best["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    return best


def exponent(sizes: np.ndarray, seconds: np.ndarray) -> float:
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def table(rows: list[dict[str, float]], markdown: bool) -> str:
    columns = ["vertices", *STAGES, *REST, "wall", "one mesh", "one mesh, processor", "prepared pair", "memory"]
    lines = []
    for name in columns:
        cells = [f"{row[name]:,.0f}" if name in ("vertices", "memory") else f"{row[name]:.2f}" for row in rows]
        if markdown:
            lines.append(f"| {name} | {' | '.join(cells)} |")
        else:
            lines.append(f"{name:22}" + "".join(f"{cell:>12}" for cell in cells))
    if markdown:
        lines.insert(1, "|---" * (len(rows) + 1) + "|")
    large = [row for row in rows if row["vertices"] >= 15_000]
    if len(large) > 1:
        sizes = np.array([row["vertices"] for row in large])
        for name in ("one mesh", "one mesh, processor"):
            power = exponent(sizes, np.array([row[name] for row in large]))
            lines.append(f"\nseconds of {name} grow as vertices to the power {power:.2f}, from {sizes[0]:,.0f} on")
    return "\n".join(lines)


def plot(rows: list[dict[str, float]], path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3.6), dpi=100, layout="constrained")
    axes = figure.subplots()
    sizes = [row["vertices"] for row in rows]
    for name, label in (("total", "pair, files to matches"), ("one mesh", "one mesh"), ("reading", "reading both")):
        axes.loglog(sizes, [row[name] for row in rows], marker="o", label=label)
    axes.loglog(sizes, [rows[-1]["one mesh"] * size / sizes[-1] for size in sizes], ":", color="grey", label="linear")
    axes.set(xlabel="vertices of a mesh", ylabel="seconds")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="THOUSANDS")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.measure:
        print(json.dumps(measure(chosen.measure, chosen.runs)))
        return
    rows = []
    for size in chosen.sizes:
        with tempfile.TemporaryDirectory() as name:
            make(size, Path(name))
            command = [sys.executable, __file__, "--measure", name, "--runs", str(chosen.runs)]
            rows.append(json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout))
        print(f"{size} thousand: {rows[-1]['wall']:.2f} s, {rows[-1]['memory']:.0f} MB", file=sys.stderr)
    print(table(rows, chosen.markdown))
    if chosen.plot:
        plot(rows, chosen.plot)


if __name__ == "__main__":
    main()
