"""How fast a page opens in a headless Chromium that draws without a GPU, and how fast pictures are drawn.

    python benchmarks/viewer.py [--vertices 5000 100000] [--pair quadruped]

For each size a pair that ships with the package, cut finer and simplified to so many vertices, is matched with its
dense map, and everything that a page can show is put into one. Then: the size of the page; the time from opening to the
first picture of both shapes, and from a drag to the next picture; the time of `mobius_match.figures.draw_matches`.
"""

from __future__ import annotations

import argparse
import io
import statistics
import sys
import tempfile
import time
from pathlib import Path

import trimesh

import mobius_match as mm
from mobius_match import viewer
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_matches
from mobius_match.mesh.measure import unit_box
from mobius_match.mesh.simplify import simplify

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.viewer.chromium import Chromium


def finer(path, number):
    """A mesh of about so many vertices."""
    mesh = mm.read_mesh(path)
    vertices, faces = mesh.vertices, mesh.faces
    if number <= 1.2 * len(vertices):
        return vertices, faces
    while len(vertices) < 1.3 * number:
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    kept, faces, _ = simplify(unit_box(vertices), faces, number)
    return vertices[kept], faces


def opened(page, repeats):
    """Milliseconds, least of several: to the first picture, and from a drag to the next."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        path.write_text(page, encoding="utf-8")
        browser = Chromium(Path(folder) / "profile")
        try:
            first, drags = [], []
            for _ in range(repeats):
                browser.open(path, 1200, 800)
                first.append(browser.run("performance.now()"))
                browser.mouse("mousePressed", 300, 300, "left", 1)
                for k in range(8):
                    start = time.perf_counter()
                    browser.call(
                        "Input.dispatchMouseEvent", type="mouseMoved", x=310 + 15 * k, y=300, button="left", buttons=1
                    )
                    browser.settle()
                    drags.append(1000 * (time.perf_counter() - start))
                browser.mouse("mouseReleased", 430, 300, "left", 1)
            return min(first), statistics.median(drags)
        finally:
            browser.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vertices", type=int, nargs="+", default=[5000, 100_000])
    parser.add_argument("--pair", choices=examples.names(), default="quadruped")
    options = parser.parse_args()
    print("| vertices | page made, s | page, MB | first picture, s | drag to picture, ms | PNG, s |")
    print("|---|---|---|---|---|---|")
    for number in options.vertices:
        result = mm.match(*(finer(path, number) for path in examples.paths(options.pair)), seed=0)
        dense = result.dense()
        start = time.perf_counter()
        page = viewer.page(result, dense=dense)
        made = time.perf_counter() - start
        first, drag = opened(page, 3)
        draw_matches(result, io.BytesIO())  # compiles, or loads what is compiled
        start = time.perf_counter()
        draw_matches(result, io.BytesIO())
        drawn = time.perf_counter() - start
        print(
            f"| {result.source_info['vertices']:,} | {made:.1f} | {len(page) / 1e6:.2f} | {first / 1000:.2f} "
            f"| {drag:.0f} | {drawn:.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
