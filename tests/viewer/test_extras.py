"""Errors, textures, the morph and the votes, in a real browser."""

from __future__ import annotations

import csv
import time
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread

from mobius_match.results.surface_map import SurfaceMap
from mobius_match.viewer import packing, page
from tests.viewer.pages import ROWS, STATUS, Prepared, choose, downloaded, halves, info, move, saturated, select


@pytest.fixture
def full(browser, everything):
    """The page with all there is; nothing may complain nor go to the network by the end of the test."""
    browser.open(everything)
    yield browser
    assert browser.complaints() == []
    assert [url for url in browser.requests() if not url.startswith(("data:", "blob:"))] == []


def colour(browser, name):
    names = browser.run("[...surface.options].map((option) => option.text)")
    choose(browser, "surface", names.index(name))


def rgb(text):
    return np.array([int(text[k : k + 2], 16) for k in (1, 3, 5)])


def test_errors_are_in_the_table_and_the_facts(full, tmp_path):
    rows = full.run(ROWS)
    assert full.run("[...document.querySelectorAll('th')].map((cell) => cell.textContent)")[4] == "Error %"
    assert float(rows[0][4]) > 5
    assert [row[4] for row in rows[1:]] == ["0.0"] * 7 + [""] * 16
    select(full, 1)
    assert f"{rows[0][4]} % of the diameter" in full.run("facts.innerText")
    select(full, 9)
    assert "unknown" in full.run("facts.innerText")
    room = "aside.clientLeft + aside.getBoundingClientRect().left + aside.clientWidth"
    right = "document.querySelector('table').getBoundingClientRect().right"
    assert full.run(f"((aside) => {room} - {right})(document.querySelector('aside'))") >= 0  # nothing is cut off
    mean = float(rows[0][4]) / 8
    assert full.run("document.getElementById('spheres-note').textContent") == (
        f"Mean error {mean:.1f} % of the target's diameter; 87.5 % of the matches within 5 %."
    )
    saved = list(csv.reader(downloaded(full, tmp_path, "csv").read_text().splitlines()))
    assert saved[0] == ["source", "target", "confidence", "kind", "given", "index_base", "error"]
    assert 100 * float(saved[1][6]) == pytest.approx(float(rows[0][4]), abs=0.05)
    assert [row[6] for row in saved[2:]] == ["0"] * 7 + [""] * 16


def test_errors_as_colours_of_the_spheres(full):
    before = halves(full)[0]
    choose(full, "spheres", 1)
    spots = full.run("[...document.querySelectorAll('tbody i')].map((spot) => getComputedStyle(spot).backgroundColor)")
    low, high = (f"rgb({', '.join(map(str, rgb(packing.RISING[k])))})" for k in (0, -1))
    assert spots[1:8] == [low] * 7
    assert spots[8:] == ["rgb(115, 115, 120)"] * 16
    assert spots[0] == high  # nearly half way around
    assert full.run("document.querySelector('#spheres-scale p').innerText.split(/\\n+/)") == [
        "0 %", "10 %", "20 % or more",
    ]  # fmt: skip
    assert saturated(halves(full)[0]).sum() < 0.2 * saturated(before).sum()
    choose(full, "spheres", 0)
    assert full.run("document.getElementById('spheres-scale').hidden")
    assert (np.abs(halves(full)[0] - before).max(axis=2) > 0.1).mean() < 0.001


def test_errors_as_colours_of_the_surface(browser, result, dense, tmp_path):
    """The truth turned half round the upright axis: dark on both sides."""
    from mobius_match.evaluation import Truth

    path = tmp_path / "page.html"
    for darker, target in ((False, np.arange(642)), (True, np.arange(642)[::-1])):
        path.write_text(page(result, dense=dense, truth=Truth(np.arange(642), target)), encoding="utf-8")
        browser.open(path)
        colour(browser, "Error")
        for half in halves(browser):
            lit = half[half.min(axis=2) < 0.97]
            assert (np.median(lit.max(axis=1)) < 0.5) == darker
        assert browser.run("document.querySelectorAll('#surface-scale span').length") == 3


def test_distortions_have_a_legend_with_their_units(full):
    for name, words in (("Area distortion", "half"), ("Angle distortion", "1 : 2"), ("Distance distortion", "0.05")):
        colour(full, name)
        assert words in full.run("document.querySelector('#surface-scale p').innerText")
        assert len(full.run("document.getElementById('surface-note').textContent")) > 30
        assert "gradient" in full.run("document.querySelector('#surface-scale i').style.background")
    assert full.run("matches.checked") is False
    colour(full, "Plain")
    assert full.run("[matches.checked, document.getElementById('surface-scale').hidden]") == [True, True]


def test_a_saved_picture_has_the_scale_of_its_colours(full, tmp_path):
    def corner(name):
        (tmp_path / name).mkdir()
        drawn = imread(downloaded(full, tmp_path / name, "picture"))[:, :, :3]
        return drawn[-58, [-400, -40]]  # both ends of the scale

    assert np.ptp(corner("plain")) < 0.02
    colour(full, "Area distortion")
    assert np.abs(255 * corner("area") - [rgb(packing.DIVERGING[k]) for k in (0, -1)]).max() < 60
    colour(full, "Plain")
    choose(full, "spheres", 1)
    good, bad = corner("error")
    assert good.max() > bad.max() + 0.2


def wait_for_texture(browser):
    """Until the picture is decoded and drawn, which a page does in the background."""
    end = time.monotonic() + browser.patience
    while min(saturated(half).mean() for half in halves(browser)) < 0.05:
        assert time.monotonic() < end
        browser.settle()


def test_the_texture_is_on_both_and_follows_the_morph(browser, textured, tmp_path):
    path = tmp_path / "textured.html"
    path.write_text(textured, encoding="utf-8")
    browser.open(path)
    colour(browser, "Texture")
    wait_for_texture(browser)
    for half in halves(browser):
        red, blue = ((half[:, :, k] - half[:, :, 2 - k] > 0.3) for k in (0, 2))
        assert min(red.mean(), blue.mean()) > 0.05
        assert np.nonzero(blue)[0].mean() < np.nonzero(red)[0].mean()  # blue is above
    one, other = halves(browser)
    assert (np.abs(one - other).max(axis=2) > 0.15).mean() < 0.1
    move(browser, "morph", 1)
    assert (np.abs(halves(browser)[0] - one).max(axis=2) > 0.15).mean() < 0.1  # the identity
    assert browser.complaints() == []
    assert [url for url in browser.requests() if not url.startswith(("data:", "blob:"))] == []


def test_the_source_becomes_the_target_with_its_spheres(browser, result, mesh, dense, tmp_path):
    longer = replace(mesh, vertices=mesh.vertices * [1, 1.6, 1], sha256="longer")
    across = SurfaceMap(
        mesh, longer, dense.target_points, dense.target_points, dense.source_mapped, dense.source_mapped
    )
    path = tmp_path / "page.html"
    target = replace(result, target=Prepared(longer), target_info=info(longer))
    path.write_text(page(target, dense=across), encoding="utf-8")
    browser.open(path)
    apart = []
    for moment in (0, 0.5, 1):
        move(browser, "morph", moment)
        one, other = halves(browser)
        apart.append((np.abs(one - other).max(axis=2) > 0.15).mean())
        assert browser.run("document.getElementById('morph-value').textContent") == f"{100 * moment:.0f} %"
    assert apart[0] > apart[1] > 5 * apart[2]
    assert apart[2] < 0.01
    assert saturated(one).mean() > 0.01
    move(browser, "morph", 0)
    assert (np.abs(halves(browser)[1] - other).max(axis=2) > 0.15).mean() < 0.02
    assert browser.complaints() == []


def test_the_morph_of_a_mirror_image_is_never_flat(browser, result, mesh, dense, tmp_path):
    """The target is the mirror image of the source: the morph has it from its first moment to its last."""
    image = replace(mesh.reflected(), sha256="other")
    points = dense.source_points.in_flipped_faces
    across = replace(dense, target=image, target_points=points, target_mapped=dense.source_mapped, reflected=True)
    path = tmp_path / "page.html"
    other = replace(result, target=Prepared(image), target_info=info(image), reflected=True)
    path.write_text(page(other, dense=across), encoding="utf-8")
    browser.open(path)
    apart = []
    for moment in (0, 0.01, 0.06, 0.5, 1):
        move(browser, "morph", moment)
        one, two = halves(browser)
        apart.append((np.abs(one - two).max(axis=2) > 0.15).mean())
    assert apart[0] > 0.05 and max(apart[1:]) < 0.02
    assert browser.complaints() == []


def canvas(browser, number):
    """Left, top, width and height of one of the pictures of the votes."""
    return browser.run(
        f"(({{x, y, width, height}}) => [x, y, width, height])"
        f"(document.querySelectorAll('#insight canvas')[{number}].getBoundingClientRect())"
    )


def test_the_votes_name_the_pair_under_the_pointer(full, matched):
    assert full.run("insight.hidden")
    full.run("votes.click()")
    full.settle()
    assert full.run("votes.getAttribute('aria-pressed')") == "true"
    data = full.run("JSON.parse(document.getElementById('shapes').textContent).insight")
    x, y, width, height = canvas(full, 2)
    row, column = 20, 7
    full.mouse("mouseMoved", x + (column + 0.5) / 30 * width, y + (row + 0.5) / 30 * height)
    i, j = data["rows"][row], data["columns"][column]
    share = matched.votes.matrix[i, j] / matched.votes.matrix.max()
    source, target = data["samples"][0][i], data["samples"][1][j]
    assert full.run("pair.textContent") == (
        f"source vertex {source}, target vertex {target}: {100 * share:.1f} % of the maximum"
    )
    x, y, width, _ = canvas(full, 0)
    corner = data["triplet"][0][0]
    # The first corner of the triangle is at exp(2 pi i / 3), half-way to the rim.
    place = x + width / 2 - (width / 2 - 8) / 4, y + width / 2 - (width / 2 - 8) * 3**0.5 / 4
    full.mouse("mouseMoved", *place)
    assert full.run("pair.textContent").startswith(f"source vertex {data['samples'][0][corner]}, target vertex")
    full.mouse("mouseMoved", x + 3, y + 3)
    assert full.run("pair.textContent").startswith("Point at")
    full.run("votes.click()")
    assert full.run("insight.hidden")


def test_the_votes_show_and_select_matches(browser, matched, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(page(matched), encoding="utf-8")
    pixels = "(([c]) => [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data])"
    for dark in (False, True):
        browser.open(path, dark=dark)
        browser.run("votes.click()")
        browser.settle()
        found = [
            np.array(browser.run(f"{pixels}([document.querySelectorAll('#insight canvas')[{k}]])")).reshape(-1, 4)
            for k in range(3)
        ]
        for plane in found[:2]:
            shown = plane[plane[:, 3] == 255][:, :3]
            assert 100 < (np.ptp(shown, axis=1) > 60).sum() < len(plane) / 5
        values, counts = np.unique(found[2][:, :3], axis=0, return_counts=True)
        ground = rgb(packing.RISING[-1 if dark else 0])
        assert np.abs(values[counts.argmax()] - ground).max() <= 1
        assert counts.max() > 0.5 * len(found[2])
        # Matched to itself: of 30 times 30 cells those of the diagonal are at the other end of the scale.
        most = np.abs(found[2][:, :3] - rgb(packing.RISING[0 if dark else -1])).max(axis=1) < 40
        assert 10 < 900 * most.mean() < 40
    data = browser.run("JSON.parse(document.getElementById('shapes').textContent).insight")
    x, y, width, height = canvas(browser, 2)
    # The most confident match of a sample; other points have no row.
    place = int(np.flatnonzero(np.isin(matched.pairs[:, 0], data["samples"][0]))[0])
    row = data["rows"].index(data["samples"][0].index(int(matched.pairs[place, 0])))
    browser.click(x + 3, y + (row + 0.5) / len(data["rows"]) * height)
    assert browser.run(STATUS) == f"Match {place + 1}"
    after = np.array(browser.run(f"{pixels}([document.querySelectorAll('#insight canvas')[2]])")).reshape(-1, 4)
    assert (after != found[2]).any(axis=1).sum() > width
    assert browser.complaints() == []


def test_names_of_files_stay_text_in_all_parts(browser, result, dense, truth, matched, tmp_path):
    script = "</script><script>window.hit = 1</script><img src=x onerror='window.hit=1'>"
    hostile = replace(
        result, source=matched.source, target=matched.target, votes=matched.votes, warnings=(script,),
        source_info={**result.source_info, "path": "a/<script>.off"},
        target_info={**result.target_info, "path": "<img src=x onerror=window.hit=1>"},
    )  # fmt: skip
    path = tmp_path / "hostile.html"
    path.write_text(page(hostile, dense=dense, truth=truth), encoding="utf-8")
    browser.open(path)
    for k in range(browser.run("surface.options.length")):
        choose(browser, "surface", k)
    choose(browser, "spheres", 1)
    choose(browser, "alignment", 1)
    move(browser, "morph", 0.5)
    browser.run("votes.click()")
    browser.key("ArrowRight")
    browser.mouse("mouseMoved", *(np.array(canvas(browser, 2)[:2]) + 5))
    assert browser.run("window.hit") is None
    assert browser.run("document.querySelectorAll('script').length") == 3
    assert browser.run("document.querySelectorAll('img, svg').length") == 0
    assert browser.run("document.querySelector('h1').textContent").startswith("<script>.off")
    assert browser.complaints() == []
    assert [url for url in browser.requests() if not url.startswith(("data:", "blob:"))] == []
