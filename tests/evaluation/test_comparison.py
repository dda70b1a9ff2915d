"""Comparisons of runs: signs, names, common pairs."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from mobius_match import SettingsError
from mobius_match.evaluation import figures
from mobius_match.evaluation.comparison import run_names, write_comparison
from mobius_match.evaluation.summary import THRESHOLDS

from .records import failed, record, run
from .test_report import Page


@pytest.fixture
def drawn(monkeypatch):
    """The panels of lines that were drawn, instead of drawing them."""
    panels = []

    def draw(make, *arguments):
        panels.append(arguments[0])
        return b"<svg/>", b"PNG"

    monkeypatch.setattr(figures, "draw", draw)
    return panels


def compared(runs, folder):
    path = write_comparison(runs, folder)
    with (folder / "comparison.csv").open(newline="", encoding="utf-8") as stream:
        return Page(path.read_text(encoding="utf-8")), list(csv.DictReader(stream))


def flat(name, error, n=50, **others):
    return record(name, direct=[error] * n, **others)


BEFORE = [
    flat("p-a", 0.05),
    flat("p-b", 0.05),
    flat("p-c", 0.05),
    failed("p-d", "no"),
    flat("p-e", 0.05),
    flat("p-f", 0.1),
]
AFTER = [
    flat("p-f", 0.091),
    flat("p-e", 0.07),
    failed("p-c", "no"),
    flat("p-d", 0.05),
    flat("p-b", 0.02),
    flat("p-x", 0),
]


def test_what_became_better_or_worse_is_listed_worst_first(tmp_path, drawn):
    page, rows = compared([run(BEFORE, "one"), run(AFTER, "two")], tmp_path)
    assert [(row["pair"], row["verdict"]) for row in rows] == [
        ("p-c", "worse"),
        ("p-e", "worse"),
        ("p-f", "same"),
        ("p-b", "better"),
        ("p-d", "better"),
    ]
    changes = {row["pair"]: row["change"] for row in rows}
    assert float(changes["p-e"]) == pytest.approx(0.02)
    assert float(changes["p-b"]) == pytest.approx(-0.03)
    assert (changes["p-c"], changes["p-d"]) == ("", "")
    caption = "one to two: mean of the first 45, per diameter, direct: 2 better, 1 same, 2 worse"
    header, *table = page.tables[caption]
    assert header == ["pair", "one", "two", "change", "verdict"]
    assert table[0] == ["p-c", "0.050", "failed", "–", "worse"]
    assert table[1] == ["p-e", "0.050", "0.070", "+0.020", "worse"]
    assert table[3] == ["p-b", "0.050", "0.020", "−0.030", "better"]
    assert "5 pairs are in all runs; 3 of them are done in all" in page.text


def test_numbers_and_curves_are_over_the_pairs_that_are_done_in_all(tmp_path, drawn):
    page, _ = compared([run(BEFORE, "one"), run(AFTER, "two")], tmp_path)
    table = page.values("Against the ground truth: direct")
    means = {"one": (0.05 + 0.05 + 0.1) / 3, "two": (0.02 + 0.07 + 0.091) / 3}
    assert table["mean of the first 45, per diameter"] == {name: f"{value:.3f}" for name, value in means.items()}
    cumulative, first = drawn
    assert [line.label for line in cumulative["sparse, direct"]] == ["one", "two"]
    place = np.flatnonzero(np.isclose(THRESHOLDS, 0.1))[0]
    shares = [line.values[place] for line in cumulative["sparse, direct"]]
    assert shares == pytest.approx([2 / 3, 1 / 3]), "0.1 sqrt(area) is 0.0667 of the diameter"
    for line in first["direct"]:
        assert line.values[:50] == pytest.approx(np.full(50, means[line.label]))
        assert np.isnan(line.values[50:]).all()


def test_three_runs_are_compared_with_the_first(tmp_path, drawn):
    runs = [run([flat("p-a", error)], name) for error, name in ((0.05, "x"), (0.09, "y"), (0.01, "z"))]
    _, rows = compared(runs, tmp_path)
    assert [(row["first"], row["run"], row["verdict"]) for row in rows] == [("x", "y", "worse"), ("x", "z", "better")]


def test_mirrored_pairs_and_dense_maps_are_compared_by_themselves(tmp_path, drawn):
    dense = [{"direct": [error] * 9, "mirrored": [0.01] * 9} for error in (0.1, 0.2)]
    runs = [
        run([flat("p-a", 0.02, mirrored=[0.3] * 50, dense=dense[0])], "x"),
        run([flat("p-a", 0.3, mirrored=[0.02] * 50, dense=dense[1])], "y"),
    ]
    page, rows = compared(runs, tmp_path)
    verdicts = {(row["measure"], row["truth"]): row["verdict"] for row in rows}
    assert verdicts == {
        ("mean45", "direct"): "worse",
        ("mean45", "better"): "same",
        ("dense_mean", "direct"): "worse",
        ("dense_mean", "better"): "same",
    }
    change = next(float(row["change"]) for row in rows if row["measure"] == "dense_mean")
    assert change == pytest.approx(0.1 * 3 / 2), "per square root of the area"
    assert page.values("Against the ground truth: mirrored")["mean of the first 45, per diameter"] == {
        "x": "0.300",
        "y": "0.020",
    }


def test_settings_that_differ_are_listed(tmp_path, drawn):
    runs = [
        run([flat("p-a", 0.02)], "x"),
        run(
            [flat("p-a", 0.02)], "y", settings={"samples": 50, "votes": None, "seed": 0}, scoring={"geodesics": "heat"}
        ),
    ]
    page, _ = compared(runs, tmp_path)
    assert page.values("Settings that differ") == {
        "settings: samples": {"x": "100", "y": "50"},
        "scoring: geodesics": {"x": "exact", "y": "heat"},
    }
    assert "The runs measure errors with different geodesics" in page.text


@pytest.mark.parametrize(
    ("folders", "names"),
    [
        (["/a/one", "/a/two"], ["one", "two"]),
        (["/a/run", "/b/run"], ["a/run", "b/run"]),
        (["/a/x/run", "/b/x/run", "/b/y"], ["a/x/run", "b/x/run", "y"]),
        (["/a/run", "/a/run"], ["run (1)", "run (2)"]),
    ],
)
def test_names_of_runs_are_distinct(folders, names):
    assert run_names([Path(folder) for folder in folders]) == names


def test_figures_and_bytes_are_the_same_each_time(tmp_path):
    runs = [run(BEFORE, "<b>one"), run(AFTER, "two")]
    files = []
    for name in ("first", "second"):
        compared(runs, tmp_path / name)
        files.append({path.name: path.read_bytes() for path in (tmp_path / name).rglob("*") if path.is_file()})
    assert files[0] == files[1]
    assert set(files[0]) == {"comparison.html", "comparison.csv"} | {
        f"comparison-{name}.{kind}" for name in ("cumulative-sparse", "first-60") for kind in ("svg", "png")
    }
    assert b"<b>one" not in files[0]["comparison.html"]


def test_pairs_that_failed_in_one_run_alone_leave_a_page(tmp_path):
    page, rows = compared([run([flat("p-a", 0.1)], "x"), run([failed("p-a", "no")], "y")], tmp_path)
    assert [(row["pair"], row["verdict"]) for row in rows] == [("p-a", "worse")]
    assert page.images == []


@pytest.mark.parametrize(
    ("others", "message"), [([], "nothing to compare"), ([[flat("q-q", 0.1)]], "no pair in common")]
)
def test_runs_that_cannot_be_compared_are_refused(tmp_path, others, message):
    with pytest.raises(SettingsError, match=message):
        write_comparison([run([flat("p-a", 0.1)], "x"), *(run(records, "y") for records in others)], tmp_path / "out")
    assert not (tmp_path / "out").exists()
