"""Make the pictures of the viewer's page in docs/images, in a headless Chromium.

python benchmarks/screens.py [--folder docs/images]
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
from pathlib import Path

from PIL import Image

import mobius_match as mm
from mobius_match import viewer
from mobius_match.evaluation import examples

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.viewer.chromium import Chromium
from tests.viewer.pages import choose, move, select

WIDTH, HEIGHT = 1200, 720


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=Path("docs/images"))
    folder = parser.parse_args().folder
    result = mm.match(*examples.paths("quadruped"), seed=0)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "page.html"
        path.write_text(viewer.page(result, dense=result.dense()), encoding="utf-8")
        browser = Chromium(Path(place) / "profile")

        def save(name):
            browser.settle()
            picture = Image.open(io.BytesIO(browser.screenshot())).convert("RGB")
            picture.quantize(255, dither=Image.Dither.NONE).save(folder / name, optimize=True)

        try:
            browser.open(path, WIDTH, HEIGHT)
            select(browser, 2)
            save("viewer.png")
            browser.open(path, WIDTH, HEIGHT, dark=True)
            choose(browser, "surface", 2)
            move(browser, "morph", 0.5)
            save("viewer-map.png")
            browser.open(path, WIDTH, HEIGHT)
            select(browser, 2)
            browser.run("votes.click()")
            save("viewer-votes.png")
        finally:
            browser.close()


if __name__ == "__main__":
    main()
