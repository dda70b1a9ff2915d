"""The page of a typical pair opens hardly later than that of a small one, and a large pair opens too, without a GPU.

Seconds are measured by benchmarks/viewer.py.
"""

import numpy as np

from mobius_match.evaluation import examples
from mobius_match.mesh import as_mesh, repair
from mobius_match.results.correspondence import Correspondence
from mobius_match.viewer import page
from tests import shapes
from tests.viewer.pages import ROWS, STATUS, Prepared, halves, info, saturated

OPENINGS = 5
"""Times that each page may be opened: the fastest counts, as the machine may be busy with other work."""


def written(folder, meshes):
    """A page of 100 matches between two meshes."""
    rng = np.random.default_rng(0)
    result = Correspondence(
        pairs=np.stack([rng.choice(len(mesh.vertices), 100, replace=False) for mesh in meshes], axis=1),
        confidence=np.linspace(1, 0.5, 100), kind=np.full(100, "voted"), settings={},
        source=Prepared(meshes[0]), target=Prepared(meshes[1]),
        source_info=info(meshes[0], "one.off"), target_info=info(meshes[1], "two.off"),
    )  # fmt: skip
    path = folder / "page.html"
    path.write_text(page(result), encoding="utf-8")
    return path


def test_a_pair_of_5000_vertices_opens_almost_as_fast_as_one_of_642(browser, tmp_path):
    """Most of the time goes into the script itself; twice that time leaves room for noise."""
    meshes = {
        "small": [repair(as_mesh(shapes.lump(3)))] * 2,
        "typical": [repair(as_mesh(path)) for path in examples.paths("quadruped")],
    }
    fastest = dict.fromkeys(meshes, np.inf)
    for name in meshes:
        (tmp_path / name).mkdir()
    paths = {name: written(tmp_path / name, pair) for name, pair in meshes.items()}
    for _ in range(OPENINGS):
        for name, path in paths.items():
            browser.open(path, 1200, 800)
            browser.key("ArrowRight")
            fastest[name] = min(fastest[name], browser.run("performance.now()"))
            assert browser.run(STATUS) == "Match 1"
        if fastest["typical"] < 2 * fastest["small"]:
            break
    assert fastest["typical"] < 2 * fastest["small"]


def test_a_pair_of_100000_vertices_opens(browser, tmp_path):
    mesh = repair(as_mesh(shapes.lump(7)))
    assert len(mesh.vertices) > 100_000
    path = written(tmp_path, [mesh, mesh])
    assert path.stat().st_size < 3_000_000
    browser.open(path, 1200, 800)
    assert f"{len(mesh.vertices):,} vertices, drawn simplified" in browser.run("stage.innerText")
    for half in halves(browser):
        assert ((np.ptp(half, axis=2) < 0.05) & (half.max(axis=2) < 0.97)).mean() > 0.05
        assert saturated(half).mean() > 0.01
    browser.key("ArrowRight")
    assert browser.run(STATUS) == "Match 1"
    assert len(browser.run(ROWS)) == 100
    assert browser.complaints() == []
