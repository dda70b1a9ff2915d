"""Small results to look at, and a browser."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mobius_match import match
from mobius_match.evaluation import Truth
from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import as_mesh, repair
from mobius_match.mesh.handles import cut_along, handle_loops
from mobius_match.results.correspondence import Correspondence
from mobius_match.results.matches import Alternative
from mobius_match.results.surface_map import SurfaceMap
from mobius_match.viewer import page
from tests import shapes
from tests.viewer.chromium import Chromium, find
from tests.viewer.pages import Prepared, info


@pytest.fixture(scope="session")
def mesh():
    return repair(as_mesh(shapes.lump()))


@pytest.fixture(scope="session")
def result(mesh):
    """A lump matched to itself: 24 matches, every third recovered; an alternative has 5 wrong ones."""
    numbers = np.arange(0, len(mesh.vertices), len(mesh.vertices) // 24)[:24]
    pairs = np.stack([numbers, numbers], axis=1)
    kind = np.where(np.arange(24) % 3 == 2, "recovered", "voted")
    confidence = np.linspace(1, 0.54, 24)
    other = Alternative(
        np.c_[numbers[:5], numbers[5:10]], confidence[:5], kind[:5], margin=0.125, share=0.25, probability=0.125
    )
    return Correspondence(
        pairs=pairs,
        confidence=confidence,
        kind=kind,
        source_info=info(mesh, "shapes/one.off"),
        target_info=info(mesh, "shapes/two.off"),
        settings={},
        warnings=("two.off: a <b>note</b>",),
        source=Prepared(mesh),
        target=Prepared(mesh),
        _make_alternatives=lambda: (other,),
    )


@pytest.fixture(scope="session")
def dense(mesh):
    """Every vertex to itself, but for the 30 first of the target, which correspond to nothing."""
    n = len(mesh.vertices)
    corner = np.unique(mesh.faces.ravel(), return_index=True)[1]
    points = SurfacePoints(corner // 3, mesh.faces[corner // 3], np.eye(3)[corner % 3])
    return SurfaceMap(mesh, mesh, points, points, np.full(n, True), np.arange(n) >= 30)


@pytest.fixture(scope="session")
def matched():
    """A real match of two small shapes, with its votes."""
    shape = shapes.lump()
    return match(shape, shape, samples=30, votes=4000, seed=0)


@pytest.fixture(scope="session")
def ring(result):
    """The result on a torus, cut open along a loop, and the loop; the target is the lump."""
    whole = repair(as_mesh(shapes.torus()))
    (loop,) = handle_loops(whole)
    cut, _ = cut_along(whole, [loop])
    return replace(result, source=Prepared(cut, [loop]), source_info=info(cut, "shapes/ring.off")), loop


@pytest.fixture(scope="session")
def truth(result):
    """The first 8 matches are known: all right but the first, whose true position is that of the second."""
    return Truth(result.pairs[:8, 0], result.pairs[[1, *range(1, 8)], 1], landmarks=True)


@pytest.fixture(scope="session")
def everything(result, dense, truth, matched, tmp_path_factory):
    """A page with all that there is to show; the votes are of another match, on 30 samples."""
    path = tmp_path_factory.mktemp("everything") / "page.html"
    shown = replace(result, source=matched.source, target=matched.target, votes=matched.votes)
    path.write_text(page(shown, dense=dense, truth=truth), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def textured(result, dense, mesh, tmp_path_factory):
    """The page of a source with a texture: red below, blue above."""
    folder = tmp_path_factory.mktemp("textured")
    image = np.zeros((1024, 2048, 3), np.uint8)
    image[:512, :, 2] = image[512:, :, 0] = 230
    Image.fromarray(image).save(folder / "t.png")
    (folder / "m.mtl").write_text("newmtl m\nmap_Kd t.png\n")
    low, size = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0)
    uv = (mesh.vertices - low)[:, :2] / size[:2]
    lines = ["mtllib m.mtl", *("v " + " ".join(map(repr, row)) for row in mesh.vertices.tolist())]
    lines += [*(f"vt {u!r} {v!r}" for u, v in uv.tolist()), "usemtl m"]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}" for i in row) for row in mesh.faces.tolist()]
    path = folder / "textured.obj"
    path.write_text("\n".join(lines) + "\n")
    source = repair(as_mesh(path))
    seen = replace(result, source=Prepared(source), source_info=info(source, str(path)))
    return page(seen, dense=replace(dense, source=source))


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    if find() is None:
        pytest.skip("no Chromium was found; install it to test the page in a browser")
    started = Chromium(tmp_path_factory.mktemp("chromium"))
    yield started
    started.close()


@pytest.fixture(scope="session")
def file(result, dense, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(page(result, dense=dense), encoding="utf-8")
    return path


@pytest.fixture
def opened(browser, file):
    """The page, freshly loaded; nothing may complain nor go to the network by the end of the test."""
    browser.open(file)
    yield browser
    assert browser.complaints() == []
    assert [url for url in browser.requests() if not url.startswith(("data:", "blob:"))] == []
