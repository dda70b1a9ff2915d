"""The figures of an evaluation, checked by what is drawn."""

from __future__ import annotations

import io
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

from mobius_match.evaluation import figures

SVG = "{http://www.w3.org/2000/svg}"


def png(drawn):
    return imread(io.BytesIO(drawn[1]))[:, :, :3]


def luminance(colour):
    """Linear, so that grey print has the same order."""
    linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def matrix_of(table, names=None, categories=None, **options):
    names = names or [f"pair{k}" for k in range(len(table))]
    return figures.error_matrix(names, categories or ["a"] * len(names), {"direct": np.array(table)}, **options)


def shown_text(figure):
    return [text.get_text() for axes in figure.axes for text in [*axes.get_yticklabels(), axes.title]]


def test_every_figure_is_a_valid_svg_and_png_with_equal_bytes_each_time():
    table = np.random.default_rng(0).random((3, 60)) / 5
    line = figures.Line("one", np.linspace(0, 1, 11), figures.run_style(0))
    for make, arguments in (
        (figures.error_matrix, (["a", "b", "c"], ["x", "x", "y"], {"direct": table}, (15,))),
        (figures.first_matches, ({"direct": table}, ["direct"])),
        (figures.curves, ({"sparse": [line]}, np.linspace(0, 1, 11), "x", "y")),
        (figures.calibration, (np.linspace(0, 1, 11), np.arange(10), {"direct": np.linspace(0, 1, 10)})),
    ):
        first = figures.draw(make, *arguments)
        assert first == figures.draw(make, *arguments)
        root = ElementTree.fromstring(first[0])
        assert root.tag == f"{SVG}svg"
        assert root.findall(f".//{SVG}path")
        assert b"http" not in first[0].replace(b"http://www.w3.org/", b"").replace(b"http://purl.org/", b"").replace(
            b"http://creativecommons.org/", b""
        )
        height, width = png(first).shape[:2]
        points = [float(root.get(k).removesuffix("pt")) for k in ("width", "height")]
        assert (width, height) == pytest.approx([x / 72 * 150 for x in points], abs=2)


def test_figures_do_not_depend_on_the_users_matplotlib_settings():
    make = figures.calibration, np.linspace(0, 1, 11), np.arange(10), {"direct": np.linspace(0, 1, 10)}
    plain = figures.draw(*make)
    changed = {"font.size": 30, "axes.facecolor": "red", "svg.hashsalt": "mine", "savefig.dpi": 10}
    with matplotlib.rc_context(changed):
        assert figures.draw(*make) == plain
        assert matplotlib.rcParams["svg.hashsalt"] == "mine"


def test_the_matrix_has_a_cell_a_match_whose_colour_darkens_with_the_error():
    errors = np.linspace(0, figures.MATRIX_TOP, 9)
    figure = matrix_of([errors, errors[::-1]])
    image = figure.axes[0].images[0]
    assert np.array_equal(image.get_array(), [errors, errors[::-1]])
    colours = image.cmap(image.norm(errors))[:, :3]
    assert (np.diff(luminance(colours)) < 0).all()
    picture = png(figures.draw(matrix_of, [errors, errors[::-1]]))
    for colour in colours:
        assert (np.abs(picture - colour).max(axis=2) < 0.02).sum() > 50, "each cell is visible"


def test_a_missing_match_is_not_drawn_as_an_error_of_zero():
    table = np.array([[0.0, np.nan]])
    figure = matrix_of(table)
    assert figure.axes[0].images[0].get_array().mask.tolist() == [[False, True]]
    assert figure.axes[0].patch.get_hatch()


def test_few_rows_are_named_by_pairs_and_many_by_categories():
    few = matrix_of(np.zeros((3, 5)), ["a-b", "a-c", "d-e"], ["a", "a", "d"])
    assert shown_text(few)[:3] == ["a-b", "a-c", "d-e"]
    n = figures.MAX_NAMES + 1
    names, categories = [f"pair{k}" for k in range(n)], ["a"] * (n - 1) + ["b"]
    many = matrix_of(np.zeros((n, 5)), names, categories)
    assert shown_text(many)[:2] == ["a", "b"]
    assert many.get_size_inches()[1] < 14, "fits on a page"
    crowd = matrix_of(np.zeros((900, 5)), [f"pair{k}" for k in range(900)], [f"class{k}" for k in range(900)])
    assert crowd.get_size_inches()[1] < 14
    assert shown_text(crowd)[0] in ("", "direct")


def test_categories_and_numbers_of_matches_are_marked_by_lines():
    figure = matrix_of(np.zeros((4, 20)), list("abcd"), ["x", "x", "y", "z"], marks=(15, 45))
    lines = [line.get_xydata() for line in figure.axes[0].lines]
    assert sorted(line[0, 1] for line in lines if line[0, 1] == line[1, 1]) == [1.5, 2.5]
    assert [line[0, 0] for line in lines if line[0, 0] == line[1, 0]] == [15.5]


@pytest.mark.parametrize("name", ["$x^2$", "$broken", "a\x00b\nc", "a--><script>", "形状", "\udcff"])
def test_names_are_never_parsed(name):
    line = figures.Line(name, np.zeros(3), figures.run_style(0))
    for drawn in (
        figures.draw(matrix_of, np.zeros((1, 3)), [name], [name]),
        figures.draw(figures.curves, {name: [line]}, np.arange(3), "x", "y"),
    ):
        assert not ElementTree.fromstring(drawn[0]).findall(".//script")
    assert "$" not in name or figures.label(name) in shown_text(matrix_of(np.zeros((1, 3)), [name]))


def test_long_names_are_cut():
    assert figures.label("x" * 500) == "x" * 39 + "…"


def test_curves_of_the_first_matches_and_the_histogram_are_those_of_the_table():
    table = np.array([[0.01, 0.5], [0.03, np.nan], [0.11, np.nan]])
    curve, histogram = figures.first_matches({"direct": table}, ["direct"]).axes
    mean, median = (line.get_ydata() for line in curve.lines[:2])
    assert mean == pytest.approx([0.05, 0.5])
    assert median == pytest.approx([0.03, 0.5])
    stairs = histogram.patches[0].get_data()
    filled = {round(float(edge), 2): value for edge, value in zip(stairs.edges, stairs.values, strict=False) if value}
    assert filled == pytest.approx({0.01: 0.25, 0.03: 0.25, 0.11: 0.25, 0.24: 0.25}), "the last one is 0.5"


def test_lines_differ_without_colour():
    styles = [figures.run_style(k) for k in range(8)]
    assert len({style["marker"] for style in styles}) == 8
    assert len({(style["linestyle"], style["marker"]) for style in figures.STYLES.values()}) == 3
    lines = [figures.Line(str(k), np.full(101, 0.5), style) for k, style in enumerate(styles)]
    axes = figures.curves({"all": lines}, np.linspace(0, 1, 101), "x", "y").axes[0]
    places = [set(np.arange(101)[line.get_markevery()[0] :: line.get_markevery()[1]]) for line in axes.lines[:5]]
    assert not any(a & b for k, a in enumerate(places) for b in places[:k]), "markers of equal lines are not hidden"


def test_the_calibration_shows_shares_above_and_counts_below():
    shares, counts = np.linspace(0.1, 1, 10), np.arange(10)
    upper, lower = figures.calibration(np.linspace(0, 1, 11), counts, {"direct": shares}).axes
    assert upper.lines[0].get_ydata() == pytest.approx(shares)
    assert [bar.get_height() for bar in lower.patches] == counts.tolist()
