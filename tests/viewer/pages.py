"""What the tests of the page share: results to show, and what is on the screen."""

import io
import re
import time

import numpy as np
from matplotlib.image import imread

STATUS = "document.getElementById('status').textContent"
ROWS = (
    "[...document.querySelectorAll('tbody tr')].filter((row) => !row.hidden).map((row) => row.innerText.split('\\t'))"
)


class Prepared:
    """As much of a prepared surface as a page needs."""

    def __init__(self, mesh, loops=()):
        self.mesh = self.whole_mesh = mesh
        self.detail = None
        self.loops = np.array([vertex for loop in loops for vertex in loop], np.int64)
        self.loop_sizes = np.array([len(loop) for loop in loops], np.int64)


def info(mesh, path=None):
    return {"path": path, "sha256": mesh.sha256, "vertices": mesh.n_file_vertices, "faces": mesh.n_file_faces}


def write_ply(path, mesh, colours):
    """A PLY file of text with colours from 0 to 255."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(mesh.vertices)}"]
    head += [f"property double {axis}" for axis in "xyz"]
    head += [f"property uchar {name}" for name in ("red", "green", "blue")]
    head += [f"element face {len(mesh.faces)}", "property list uchar int vertex_indices", "end_header"]
    both = np.concatenate([mesh.vertices, colours], axis=1).tolist()
    rows = [" ".join(map(repr, row[:3])) + " " + " ".join(f"{value:.0f}" for value in row[3:]) for row in both]
    path.write_text("\n".join([*head, *rows, *(f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist())]) + "\n")


def picture(browser):
    """The screen as (h, w, 3) numbers from 0 to 1."""
    return imread(io.BytesIO(browser.screenshot()))[:, :, :3]


def halves(browser):
    """The two parts of the stage that hold the shapes, without the names above."""
    box = browser.run("(({x, y, width, height}) => [x, y, width, height])(view.getBoundingClientRect())")
    x, y, width, height = np.round(box).astype(int)
    stage = picture(browser)[y : y + height, x : x + width]
    parts = np.array_split(stage, 2, axis=browser.run("+(document.querySelectorAll('.name')[1].offsetTop < 20)"))
    height, width = np.min([part.shape[:2] for part in parts], axis=0)
    return [part[40:height, :width] for part in parts]


def saturated(half):
    return half.max(axis=2) - half.min(axis=2) > 0.25


def choose(browser, name, value):
    browser.run(f"{name}.value = {value}; {name}.dispatchEvent(new Event('change'))")
    browser.settle()


def select(browser, number):
    """Select a match in the table."""
    browser.run(f"document.querySelectorAll('tbody button')[{number - 1}].click()")
    browser.settle()


def move(browser, name, value):
    """Move a slider."""
    browser.run(f"{name}.value = {value}; {name}.dispatchEvent(new Event('input'))")
    browser.settle()


def slide(browser, value):
    move(browser, "minimum", value)


def ends(browser):
    """The positions of both ends of the selected match on the screen, and their labels."""
    found = browser.run(
        "[...document.querySelectorAll('.end')].map((label) => [label.style.transform, label.textContent])"
    )
    corner = browser.run("(({x, y}) => [x, y])(view.getBoundingClientRect())")
    return [
        (np.array(re.findall(r"-?[\d.]+(?=px)", transform), float) + corner + [-14, 26], text)
        for transform, text in found
    ]


def downloaded(browser, folder, button):
    session, browser.session = browser.session, None
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
    browser.session = session
    browser.run(f"document.getElementById('{button}').click()")
    end = time.monotonic() + 30
    while not (found := [path for path in folder.iterdir() if path.suffix in (".json", ".csv", ".png")]):
        assert time.monotonic() < end
        time.sleep(0.02)
    return found[0]
