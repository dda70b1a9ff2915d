"""The page in a real browser: what is drawn, and what its controls do."""

from __future__ import annotations

import csv
import json
import re
import time
from dataclasses import replace
from html import unescape
from itertools import pairwise

import numpy as np
from matplotlib.image import imread

from mobius_match import Correspondence
from mobius_match.viewer import View, page
from tests.viewer.pages import (
    ROWS,
    STATUS,
    Prepared,
    choose,
    downloaded,
    ends,
    halves,
    info,
    picture,
    saturated,
    select,
    slide,
)


def test_both_shapes_are_drawn_alike(opened):
    one, other = halves(opened)
    surface = (np.ptp(one, axis=2) < 0.05) & (one.max(axis=2) < 0.97)
    assert surface.mean() > 0.05
    assert saturated(one).mean() > 0.01
    # A shape matched to itself: the same picture twice, but for the edges of pixels.
    assert (np.abs(one - other).max(axis=2) > 0.1).mean() < 0.01


def test_both_turn_together(opened):
    before = halves(opened)
    x, y = 300, 300
    opened.mouse("mousePressed", x, y, "left", 1)
    opened.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + 120, y=y + 30, button="left", buttons=1)
    opened.mouse("mouseReleased", x + 120, y + 30, "left", 1)
    opened.settle()
    one, other = halves(opened)
    assert (np.abs(one - before[0]).max(axis=2) > 0.1).mean() > 0.02
    assert (np.abs(one - other).max(axis=2) > 0.1).mean() < 0.01
    assert opened.run(STATUS) == "No match selected"
    opened.run("reset.click()")
    opened.settle()
    assert (np.abs(halves(opened)[0] - before[0]).max(axis=2) > 0.1).mean() < 0.001


def test_the_table_lists_the_matches(opened, result):
    rows = opened.run(ROWS)
    assert [[int(cell) for cell in row[:3]] for row in rows] == [
        [number, *pair] for number, pair in enumerate(result.pairs.tolist(), start=1)
    ]
    assert [row[3] for row in rows] == [f"{value:.3f}" for value in result.confidence]
    assert [row[4] for row in rows] == result.kind.tolist()
    assert opened.run("notes.innerText + notes.querySelector('li').textContent").endswith("two.off: a <b>note</b>")


def test_the_slider_hides_matches_of_less_confidence(opened, result):
    before = saturated(halves(opened)[0]).sum()
    slide(opened, 0.9)
    kept = int((result.confidence >= 0.9).sum())
    assert len(opened.run(ROWS)) == kept < 24
    assert opened.run("count.textContent") == f"{kept} of 24 matches"
    assert 0 < saturated(halves(opened)[0]).sum() < 0.6 * before


def test_keys_step_through_the_matches(opened, result):
    seen = []
    for _ in range(3):
        opened.key("ArrowRight")
        seen.append([text for _, text in ends(opened)])
    assert seen == [[str(i), str(j)] for i, j in result.pairs[:3].tolist()]
    assert opened.run(STATUS) == "Match 3"
    facts = opened.run("facts.innerText")
    assert all(str(part) in facts for part in ("one.off", "two.off", result.pairs[2, 0], "0.960", "recovered"))
    opened.key("ArrowLeft")
    assert opened.run(STATUS) == "Match 2"
    opened.key("Escape")
    assert opened.run(STATUS) == "No match selected"
    slide(opened, 0.9)
    opened.key("ArrowLeft")  # the last of those that are shown
    assert opened.run(STATUS) == f"Match {(result.confidence >= 0.9).sum()}"


def test_a_click_and_a_hover_select_what_is_in_front(opened):
    hit, hidden = [], []
    for number in range(1, 9):
        select(opened, number)
        (place, _), (mirrored, _) = ends(opened)
        opened.click(20, 540)
        opened.mouse("mouseMoved", *place)
        hovered = opened.run(STATUS)
        opened.click(*mirrored)
        assert opened.run(STATUS) == hovered  # on both sides the same is in front
        (hit if hovered == f"Match {number}" else hidden).append(number)
    assert len(hit) >= 3
    assert hidden  # what is behind the surface is not selected
    opened.click(20, 540)
    assert opened.run(STATUS) == "No match selected"


def test_directions_of_view(opened):
    """The shape is longest upward: from above it is small, and round."""
    first = halves(opened)[0]
    for place, name in enumerate(("Front", "Back", "Left", "Right", "Top", "Bottom")):
        assert opened.run(f"document.querySelectorAll('[data-direction]')[{place}].textContent") == name
    seen = []
    for place in range(6):
        opened.run(f"document.querySelectorAll('[data-direction]')[{place}].click()")
        opened.settle()
        one, other = halves(opened)
        seen.append(one)
        assert (np.abs(one - other).max(axis=2) > 0.1).mean() < 0.01
    assert all((np.abs(one - two).max(axis=2) > 0.1).mean() > 0.01 for one, two in pairwise(seen))
    # What is left from the front is right from the back.
    dark = [(one.max(axis=2) < 0.97)[:-30] for one in seen]
    assert (dark[0] ^ dark[1][:, ::-1]).mean() < 0.02
    opened.run("reset.click()")
    opened.settle()
    assert (np.abs(halves(opened)[0] - first).max(axis=2) > 0.1).mean() < 0.001


def test_a_match_on_the_far_side_is_rotated_to_the_front(opened):
    assert opened.run("turn.disabled")
    for number in range(1, 25):
        select(opened, number)
        opened.run("turn.click()")
        opened.settle()
        places = ends(opened)
        opened.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")
        opened.click(*places[number % 2][0])
        assert opened.run(STATUS) == f"Match {number}"


def test_matches_are_found_by_their_numbers(opened, result):
    name = "document.getElementById('find')"

    def typed(text):
        opened.run(f"{name}.value = '{text}'; {name}.dispatchEvent(new Event('input'))")
        return [int(row[0]) for row in opened.run(ROWS)]

    vertex = int(result.pairs[16, 0])
    assert typed(vertex)[-1] == 17
    opened.run(f"{name}.dispatchEvent(new KeyboardEvent('keydown', {{key: 'Enter'}}))")
    assert opened.run(STATUS) == "Match 17"
    assert {2, 20, 21, 22, 23, 24} <= set(typed(" 2"))
    assert typed("99999") == []
    assert opened.run("unfound.textContent") == "No match or vertex has this number."
    assert len(typed("")) == 24


def test_given_pairs_are_marked(opened, result, tmp_path):
    assert opened.run("given.hidden")
    voted = halves(opened)[0]
    path = tmp_path / "given.html"
    path.write_text(page(replace(result, given=np.arange(24) < 2)), encoding="utf-8")
    opened.open(path)
    assert [row[4] for row in opened.run(ROWS)] == ["given"] * 2 + result.kind[2:].tolist()
    assert not opened.run("given.hidden")
    assert (np.abs(halves(opened)[0] - voted).max(axis=2) > 0.1).any()
    rows = list(csv.reader(downloaded(opened, tmp_path, "csv").read_text().splitlines()))
    assert [row[3:5] for row in rows[1:3]] == [["voted", "1"]] * 2


def test_rulers_show_the_units_of_each_file(opened, mesh, result, tmp_path):
    """The same shape in metres and in millimetres."""
    texts = "(() => { const texts = []; const draw = CanvasRenderingContext2D.prototype.fillText;" + (
        "CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {texts.push(text); draw.call(this, text,"
        " ...at)}; reset.click(); return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>"
        " done(texts)))); })()"
    )
    source, target = opened.run(texts)
    assert source == target
    large = replace(mesh, vertices=1000 * mesh.vertices, sha256="large")
    path = tmp_path / "units.html"
    path.write_text(page(replace(result, target=Prepared(large), target_info=info(large))), encoding="utf-8")
    opened.open(path)
    source, target = opened.run(texts)
    assert float(target.removesuffix(" units")) == 1000 * float(source.removesuffix(" units"))


def test_lines_join_both_ends_on_demand(opened):
    pixels = "lines.getContext('2d').getImageData(0, 0, lines.width, lines.height).data"
    drawn = f"{pixels}.filter((value, i) => i % 4 == 3 && value).length"
    rulers = opened.run(drawn)
    opened.key("ArrowRight")
    one = opened.run(drawn) - rulers
    opened.run("document.getElementById('all-lines').click()")
    opened.settle()
    assert 0 < 5 * one < opened.run(drawn) - rulers


def test_recovered_matches_have_another_shape(opened, file, result, tmp_path):
    before = halves(opened)[0]
    path = tmp_path / "voted.html"
    path.write_text(page(replace(result, kind=np.full(24, "voted"))), encoding="utf-8")
    opened.open(path)
    assert (np.abs(halves(opened)[0] - before).max(axis=2) > 0.1).mean() > 0.001
    assert "recovered" in opened.run("legend.innerText")


def test_other_alignments_can_be_selected(opened, result):
    before = halves(opened)[1]
    choose(opened, "alignment", 1)
    (other,) = result.alternatives
    assert [[int(cell) for cell in row[1:3]] for row in opened.run(ROWS)] == other.pairs.tolist()
    note = "It is the right alignment with a probability of 0.12. 25% of the best triplets support it."
    assert opened.run("document.getElementById('alignment-note').textContent") == note
    assert (np.abs(halves(opened)[1] - before).max(axis=2) > 0.1).mean() > 0.005
    choose(opened, "alignment", 0)
    assert len(opened.run(ROWS)) == 24


def test_surfaces_have_colours_and_a_checkerboard(opened):
    seen = []
    for k in range(1, 5):
        choose(opened, "surface", k)
        one, other = halves(opened)
        seen.append(one)
        # The identity: alike but for the 30 vertices that correspond to nothing.
        assert (np.abs(one - other).max(axis=2) > 0.15).mean() < 0.1
        assert opened.run("document.getElementById('surface-scale').hidden") == (k < 3)
    colours, squares = seen[:2]
    assert saturated(colours).mean() > 0.1
    darker = colours.max(axis=2) - squares.max(axis=2) > 0.1
    assert 0.3 < darker.sum() / saturated(colours).sum() < 0.7
    choose(opened, "surface", 0)
    assert np.ptp(halves(opened)[0], axis=2).mean() < np.ptp(colours, axis=2).mean()


def test_download_of_the_result(opened, tmp_path, result):
    path = downloaded(opened, tmp_path, "json")
    loaded = Correspondence.load(path)
    assert loaded.to_dict(alternatives=True) == json.loads(json.dumps(result.to_dict(alternatives=True)))


def test_download_of_the_table(opened, tmp_path, result):
    rows = list(csv.reader(downloaded(opened, tmp_path, "csv").read_text().splitlines()))
    assert rows[0] == ["source", "target", "confidence", "kind", "given", "index_base"]
    assert {(*row[4:],) for row in rows[1:]} == {("0", "0")}
    assert [[int(i), int(j)] for i, j, *_ in rows[1:]] == result.pairs.tolist()
    assert [float(row[2]) for row in rows[1:]] == result.confidence.tolist()
    assert [row[3] for row in rows[1:]] == result.kind.tolist()


def test_download_of_a_picture(opened, tmp_path):
    drawn = imread(downloaded(opened, tmp_path, "picture"))
    assert drawn.shape[:2] == tuple(opened.run("[2 * view.height, 2 * view.width]"))  # finer than the screen
    assert (drawn[:, :, 3] == 1).all()
    assert saturated(drawn[:, :, :3]).mean() > 0.01


def test_dark_where_the_system_is_and_by_the_switch(browser, file):
    browser.open(file, dark=True)
    assert halves(browser)[0][-1, 0].max() < 0.2
    browser.run("theme.click()")
    browser.settle()
    assert halves(browser)[0][-1, 0].min() > 0.9
    assert browser.complaints() == []


def test_a_phone_shows_the_page_and_a_tap_selects(browser, file):
    browser.open(file, 390, 844, phone=True)
    assert browser.run("document.documentElement.scrollWidth") <= 390
    assert browser.run(
        "[...document.querySelectorAll('header button, aside button, select')].filter((b) => b.offsetParent && "
        "!b.closest('td')).every((b) => b.getBoundingClientRect().right <= 390 && b.offsetHeight >= 40)"
    )
    tapped = 0
    for number in range(1, 6):
        select(browser, number)
        (x, y), _ = ends(browser)[0]
        browser.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")
        browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        tapped += browser.run(STATUS) == f"Match {number}"
    assert tapped >= 2
    assert browser.complaints() == []


def test_names_and_notes_of_files_stay_text(browser, tmp_path, mesh, result):
    script = "<script>window.hit = 1</script>"
    name = '<img src=x onerror="window.hit=1"><svg onload=window.hit=1>&lt;b&gt;\u2028\'"`${window.hit=1}.off'
    hostile = replace(
        result,
        source_info=info(mesh, name),
        target_info={**info(mesh, "<script>alert(1)<\\script>"), "more": "</script>" + script + "<!--<script>"},
        warnings=(script, "]]>--></script>" + script),
        kind=np.array(["voted", script, "constructor"] * 8),
        source=Prepared(mesh),
        target=Prepared(mesh),
    )
    path = tmp_path / "hostile.html"
    for text in (page(hostile), unescape(re.search(r'srcdoc="([^"]*)"', View(page(hostile))._repr_html_())[1])):
        path.write_text(text, encoding="utf-8")
        browser.open(path)
        browser.key("ArrowRight")
        browser.key("ArrowRight")
        assert browser.run("window.hit") is None
        assert browser.run("document.querySelectorAll('script').length") == 3
        assert browser.run("document.querySelectorAll('img, svg').length") == 0
        assert browser.run("document.querySelector('h1').textContent").startswith(name)
        assert browser.run("document.querySelector('#notes li').textContent") == script
        assert script in browser.run("facts.innerText")
        assert browser.complaints() == []
        assert [url for url in browser.requests() if not url.startswith("data:")] == []


def test_a_name_written_from_the_right_turns_nothing_else(browser, tmp_path, mesh, result):
    path = tmp_path / "turned.html"
    path.write_text(page(replace(result, source_info=info(mesh, "\u202eabc.off"))), encoding="utf-8")
    browser.open(path)
    one, other = browser.run(
        "[...document.querySelectorAll('h1 bdi')].map((name) => name.getBoundingClientRect().left)"
    )
    assert one < other
    assert browser.run("document.querySelector('h1').textContent") == "\u202eabc.off \u2194 two.off"


def test_no_matches_at_all(browser, tmp_path, result):
    path = tmp_path / "none.html"
    nothing = replace(
        result,
        pairs=result.pairs[:0],
        confidence=result.confidence[:0],
        kind=result.kind[:0],
        _make_alternatives=lambda: (),
    )
    path.write_text(page(nothing), encoding="utf-8")
    browser.open(path)
    assert browser.run(STATUS) == "There are no matches"
    for name in ("ArrowRight", "Escape"):
        browser.key(name)
    assert browser.run(ROWS) == []
    assert browser.complaints() == []


def test_without_webgl_the_table_remains(browser, file, result):
    cut = browser.call(
        "Page.addScriptToEvaluateOnNewDocument", source="HTMLCanvasElement.prototype.getContext = () => null"
    )
    try:
        browser.open(file)
        assert "WebGL" in browser.run("failure.innerText")
        assert len(browser.run(ROWS)) == 24
        browser.key("ArrowRight")
        assert browser.run(STATUS) == "Match 1"
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=cut["identifier"])


def test_in_a_notebook(browser, tmp_path, result):
    """In its frame, where it may not touch what is around."""
    path = tmp_path / "notebook.html"
    path.write_text(
        f"<!doctype html><table><tbody></tbody></table>{View(page(result))._repr_html_()}", encoding="utf-8"
    )
    browser.open(path)
    end = time.monotonic() + 30
    while saturated(picture(browser)).mean() < 0.005:
        assert time.monotonic() < end
        time.sleep(0.1)
    assert browser.complaints() == []


def test_no_name_is_used_twice(opened):
    names = opened.run("[...document.querySelectorAll('[id]')].map((element) => element.id)")
    assert len(names) == len(set(names)) > 20


def test_loops_around_handles_are_drawn(browser, tmp_path, ring):
    path = tmp_path / "page.html"
    path.write_text(page(ring[0]), encoding="utf-8")
    browser.open(path)
    browser.run("matches.click()")
    browser.settle()
    magenta = [(half[:, :, 0] - half[:, :, 1] > 0.4) & (half[:, :, 2] > 0.3) for half in halves(browser)]
    assert magenta[0].mean() > 1e-4 and not magenta[1].any()
    assert browser.run("!loops.hidden")
    assert browser.complaints() == []


def test_without_handles_the_legend_has_no_loop(opened):
    assert opened.run("loops.hidden")
