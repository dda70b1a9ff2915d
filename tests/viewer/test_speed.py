"""A usual pair can be used at once, and a large one opens, drawn without a GPU. Measured: benchmarks/viewer.py."""

import numpy as np

from mobius_match.evaluation import examples
from mobius_match.mesh import as_mesh, repair
from mobius_match.results.correspondence import Correspondence
from mobius_match.viewer import page
from tests import shapes
from tests.viewer.pages import ROWS, STATUS, Prepared, halves, info, saturated

OPENINGS = 5
"""So often it may be tried, for the machine may be busy with other work."""


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


def test_a_pair_of_5000_vertices_can_be_used_within_two_seconds(browser, tmp_path):
    path = written(tmp_path, [repair(as_mesh(one)) for one in examples.paths("quadruped")])
    taken = []
    while len(taken) < OPENINGS and min(taken, default=np.inf) >= 2000:
        browser.open(path, 1200, 800)
        browser.key("ArrowRight")
        taken.append(browser.run("performance.now()"))
        assert browser.run(STATUS) == "Match 1"
    assert min(taken) < 2000


def test_a_pair_of_100000_vertices_opens(browser, tmp_path):
    mesh = repair(as_mesh(shapes.lump(7)))
    assert len(mesh.vertices) > 100_000
    path = written(tmp_path, [mesh, mesh])
    assert path.stat().st_size < 3_000_000
    browser.open(path, 1200, 800)
    assert f"{len(mesh.vertices):,} vertices, drawn with fewer" in browser.run("stage.innerText")
    for half in halves(browser):
        assert ((np.ptp(half, axis=2) < 0.05) & (half.max(axis=2) < 0.97)).mean() > 0.05
        assert saturated(half).mean() > 0.01
    browser.key("ArrowRight")
    assert browser.run(STATUS) == "Match 1"
    assert len(browser.run(ROWS)) == 100
    assert browser.complaints() == []
