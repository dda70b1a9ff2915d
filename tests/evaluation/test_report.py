"""The report's page, CSV and JSON against numbers computed independently from the records."""

from __future__ import annotations

import base64
import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.image import imread

from mobius_match.evaluation import examples, figures, summary
from mobius_match.evaluation.report import write_report

from .records import failed, record, run, usual

VOID = {"meta", "img"}


class Page(HTMLParser):
    """Tables by caption (header and rows of text), pictures, and whether every element is closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tables, self.images, self.texts, self.elements = [], {}, [], [], []
        self.caption, self.rows, self.cell = None, [], None
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.rows = []
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag == "table":
            self.tables[self.caption] = self.rows

    def handle_data(self, data):
        if self.open and self.open[-1] == "caption":
            self.caption = data
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data
        if not self.open or self.open[-1] != "style":
            self.texts.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.texts).split())

    def values(self, caption):
        """The cells of a table by row heading and column heading."""
        header, *rows = self.tables[caption]
        return {row[0]: dict(zip(header[1:], row[1:], strict=True)) for row in rows}


def written(finished, folder):
    path = write_report(finished, folder)
    assert path == folder / "report.html"
    return Page(path.read_text(encoding="utf-8"))


def rows_of(folder):
    with (folder / "pairs.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture
def undrawn(monkeypatch):
    """No figures, which take most of the time."""
    monkeypatch.setattr(figures, "draw", lambda make, *arguments: (b"<svg/>", b"PNG"))


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return folder, written(run(usual()), folder)


def test_the_headline_is_what_the_records_say(report):
    folder, page = report
    done = [pair for pair in usual() if pair["status"] == "done"]
    better = [min((pair["direct"], pair["mirrored"]), key=lambda e: np.mean(e[:45])) for pair in done]
    table = page.values("Means over pairs")
    content = json.loads((folder / "summary.json").read_text())
    for title, key, lists in (
        ("direct", "direct", [pair["direct"] for pair in done]),
        ("mirrored", "mirrored", [pair["mirrored"] for pair in done]),
        ("better of both", "better", better),
    ):
        expected = {
            "mean15": np.mean([np.mean(e[:15]) for e in lists]),
            "mean45": np.mean([np.mean(e[:45]) for e in lists]),
            "first15_close": np.mean([len(e) >= 15 and max(e[:15]) <= 0.03 for e in lists]),
            "wrong": sum(np.mean(e[:45]) > 0.1 for e in lists),
            "princeton_mean": np.mean([np.mean(e) * 3 / 2 for e in lists]),
            "princeton_within": np.mean([np.mean(np.array(e) * 3 / 2 <= 0.05) for e in lists]),
        }
        assert {name: content["errors"][key][name] for name in expected} == pytest.approx(expected)
        column = {name: cells[title] for name, cells in table.items()}
        assert column["pairs with this ground truth"] == "4"
        assert column["mean of the first 15, per diameter"] == f"{expected['mean15']:.3f}"
        assert column["mean of the first 45, per diameter"] == f"{expected['mean45']:.3f}"
        assert column["pairs with the first 15 all within 3 %"] == f"{100 * expected['first15_close']:.1f} %"
        assert column["pairs with a mean of the first 45 above 0.10"] == str(expected["wrong"])
        assert not any(name.startswith("dense") for name in column)
    assert content["errors"]["direct"]["first15_close"] == 0.25, "few matches, an early error, and a mirrored pair fail"
    assert content["errors"]["direct"]["dense_mean"] is None
    assert "4 of 5" in page.text
    assert content["surface"]["matches"] == np.mean([60, 50, 46, 10])


def test_categories_and_pairs_have_their_own_numbers(report):
    _, page = report
    table = page.values("Errors per diameter (dense: per √area), mean over the pairs of a category")
    assert [(name, row["pairs"], row["failed"]) for name, row in table.items()] == [
        ("cat", "3", "1"),
        ("dog", "2", "0"),
        ("all", "5", "1"),
    ]
    dogs = [pair["direct"] for pair in usual() if pair["category"] == "dog"]
    assert table["dog"]["first 45"] == f"{np.mean([np.mean(e[:45]) for e in dogs]):.3f}"
    every = page.values("Mean errors per diameter (dense: per √area); more columns in pairs.csv")
    for pair in usual():
        if pair["status"] == "done":
            assert every[pair["name"]]["first 45, mirrored"] == f"{np.mean(pair['mirrored'][:45]):.3f}"
    assert "cat0-cat3" not in every


def test_cumulative_curves_weigh_each_pair_the_same(tmp_path, undrawn):
    pairs = [record("a-b", direct=[0.01] * 30), record("a-c", direct=[0.04] * 90 + [0.2] * 10)]
    write_report(run(pairs), tmp_path)
    content = json.loads((tmp_path / "summary.json").read_text())["cumulative"]
    curve = dict(zip(np.round(content["per_sqrt_area"], 4), content["sparse_direct"], strict=True))
    assert curve[0.0125] == 0
    assert curve[0.015] == 0.5, "0.01 of the diameter 3 is 0.015 of the square root of the area 4, and at most that"
    assert curve[0.0575] == 0.5
    assert curve[0.06] == pytest.approx(0.95)
    assert curve[0.25] == pytest.approx(0.95)
    assert set(content) == {"per_sqrt_area", "sparse_direct"}


def test_confidence_bins_count_matches_near_the_truth(tmp_path, undrawn):
    pairs = [record("a-b", direct=[0.01, 0.05, 0.2, 0.051], confidence=[1.0, 0.95, 0.9, 0.0])]
    table = written(run(pairs), tmp_path).values("Within 5 % of the diameter")
    assert table["0.9 to 1.0"] == {"matches": "3", "direct": "66.7 %"}
    assert table["0.0 to 0.1"] == {"matches": "1", "direct": "0.0 %"}
    assert table["0.4 to 0.5"] == {"matches": "0", "direct": "–"}


def test_without_a_mirrored_truth_there_is_no_mirrored_column(tmp_path, undrawn):
    page = written(run([record("a-b", direct=[0.01] * 50)]), tmp_path)
    assert page.tables["Means over pairs"][0] == ["", "direct"]
    headings = [cell for rows in page.tables.values() for cell in rows[0]]
    assert not any("mirrored" in cell or "better" in cell for cell in headings)
    assert "mirrored" not in json.loads((tmp_path / "summary.json").read_text())["errors"]


def test_matches_without_a_known_true_point_are_ignored(tmp_path, undrawn):
    page = written(run([record("a-b", direct=[0.01, None, 0.03] * 15)]), tmp_path)
    assert page.values("Means over pairs")["matches with a known true point"] == {"direct": "30.0"}
    assert page.values("Means over pairs")["mean of the first 45, per diameter"]["direct"] == "0.020"


def test_dense_maps_alone_make_a_report(tmp_path, undrawn):
    dense = {"direct": [0.01] * 90 + [0.51] * 10, "mirrored": [0.3] * 100, "unmapped": 7}
    pair = record("a-b", dense=dense, mirrored=[], coverage={}, ranking=None)
    page = written(run([pair], maps={"folder": "/secret/home/maps", "index_base": 1}), tmp_path)
    table = page.values("Means over pairs")
    assert table["dense map: mean, per √area"]["direct"] == "0.090"
    assert table["dense map: points within 0.05 √area"]["better of both"] == "90.0 %"
    assert table["dense map: points within 0.10 √area"]["better of both"].endswith(" %")
    assert "mean of the first 15, per diameter" not in table
    maps = page.values("Dense maps of another program")
    assert {name: cells["value"] for name, cells in maps.items()} == {"folder": "maps", "vertices count from": "1"}
    assert not (tmp_path / "figures" / "error-matrix.svg").exists()
    assert rows_of(tmp_path)[0]["dense_unmapped"] == "7"


def test_a_run_with_nothing_but_failures_has_a_report(tmp_path):
    page = written(run([failed("a-b", "/secret/home/data/a.off: empty")]), tmp_path)
    assert page.values("Failed pairs") == {"a-b": {"message": "a.off: empty"}}
    assert page.images == []
    assert rows_of(tmp_path) == [
        {"name": "a-b", "category": "cat", "source": "a.off", "target": "b.off", "status": "failed"}
        | {"error": "a.off: empty"}
    ]
    assert json.loads((tmp_path / "summary.json").read_text())["failed"] == {"a-b": "a.off: empty"}


def test_an_interrupted_run_says_how_much_is_left(tmp_path, undrawn):
    page = written(run([record("a-b", direct=[0.01] * 50)], cases=["a-b", "a-c", "a-d"]), tmp_path)
    assert "1 of 3" in page.text
    assert "2 pairs are not processed yet" in page.text


def test_file_names_are_escaped_and_paths_are_not_shown(tmp_path):
    names = ["<script>alert(1)</script>-b", '"><img src=x>-$x$', "a&amp;b-\x00\udcff形"]
    pairs = [record(name, name, direct=[0.01] * 50) for name in names] + [failed("<b>x</b>-y", "<i>/secret/z")]
    page = written(run(pairs), tmp_path)
    assert names[0] in page.values("Mean errors per diameter (dense: per √area); more columns in pairs.csv")
    assert names[1] in page.text
    assert "a&amp;b-\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}形" in page.text
    tags = {tag for tag, _ in page.elements}
    assert not tags & {"script", "b", "i", "link", "iframe", "object"}
    assert all(image["src"].startswith("data:image/") for image in page.images)
    for path in (tmp_path / "report.html", tmp_path / "pairs.csv", tmp_path / "summary.json"):
        assert "/secret/home" not in path.read_text(encoding="utf-8", errors="surrogatepass")
    assert not re.search(r"(src|href)=\"?(http|//|/)", (tmp_path / "report.html").read_text(encoding="utf-8"))


def test_the_page_is_accessible(report):
    _, page = report
    headings = [attributes for tag, attributes in page.elements if tag == "th"]
    assert headings
    assert all(attributes.get("scope") in ("row", "col") for attributes in headings)
    assert page.images
    assert all(len(image["alt"]) > 20 for image in page.images)
    assert ("html", {"lang": "en"}) in page.elements


def test_figures_in_the_page_are_the_files(report):
    folder, page = report
    names = ["error-matrix", "first-60", "confidence", "cumulative"]
    kinds = [image["src"].split(";")[0] for image in page.images]
    assert kinds == ["data:image/svg+xml"] * 4, "the meshes of this run do not exist, so no pair is drawn"
    for name, image in zip(names, page.images, strict=True):
        content = base64.b64decode(image["src"].split(",")[1])
        assert content == (folder / "figures" / f"{name}.svg").read_bytes()
        assert ElementTree.fromstring(content).tag.endswith("svg")
        assert imread(io.BytesIO((folder / "figures" / f"{name}.png").read_bytes())).shape[1] > 700


def test_the_same_records_give_the_same_bytes_and_other_times_change_times_alone(tmp_path):
    def files(name, records):
        write_report(run(records, folder=f"/elsewhere/{name}"), tmp_path / name)
        found = (path for path in (tmp_path / name).rglob("*") if path.is_file())
        return {str(path.relative_to(tmp_path / name)): path.read_bytes() for path in found}

    first = files("a", usual())
    assert files("b", usual()) == first
    slower = [pair | {"timings": {"voting": 9.0, "total": 99.0}, "memory_mb": 7.0} for pair in usual()]
    second = files(
        "c", [pair if pair["status"] == "failed" else new for pair, new in zip(usual(), slower, strict=True)]
    )
    changed = {name for name in first if first[name] != second[name]}
    assert changed == {"report.html", "pairs.csv", "summary.json"}
    times = re.compile(rb'<section id="times">.*?</section>', re.DOTALL)
    assert times.sub(b"", first["report.html"]) == times.sub(b"", second["report.html"])
    before, after = (json.loads(files["summary.json"]) for files in (first, second))
    assert before.pop("times") != after.pop("times")
    assert before == after
    for old, new in zip(rows_of(tmp_path / "a"), rows_of(tmp_path / "c"), strict=True):
        assert {k for k in old if old[k] != new[k]} <= {"memory_mb", "voting_seconds", "total_seconds"}


def test_the_csv_reads_back(report):
    folder, _ = report
    rows = rows_of(folder)
    assert [row["name"] for row in rows] == [pair["name"] for pair in usual()]
    for row, pair in zip(rows, usual(), strict=True):
        if pair["status"] == "done":
            assert float(row["mean45_mirrored"]) == pytest.approx(np.mean(pair["mirrored"][:45]))
            assert float(row["princeton_mean_direct"]) == pytest.approx(np.mean(pair["direct"]) * 1.5)
            assert (row["source"], row["matches"]) == (
                "cat0.off" if "cat" in pair["name"] else "dog0.off",
                str(len(pair["direct"])),
            )
            assert float(row["voting_seconds"]) == 0.25
            assert float(row["coverage_target_evenness"]) == 0.8
        else:
            assert row["mean45_direct"] == ""
    columns = list(rows[0])
    assert columns[-3:] == ["memory_mb", "voting_seconds", "total_seconds"]


def test_the_worst_pairs_are_drawn_and_missing_meshes_are_reported(tmp_path, undrawn):
    source, target = map(str, examples.paths("person"))
    here = {"source": source, "target": target}
    pairs = [record(f"p{k}-q{k}", direct=[0.01 * k] * 20, **(here if k in (4, 9) else {})) for k in range(1, 10)]
    page = written(run(pairs), tmp_path)
    drawn = [image["alt"] for image in page.images if image["src"].startswith("data:image/png")]
    assert ["p9-q9" in drawn[0], len(drawn)] == [True, 1]
    assert re.findall(r"(p\d)-q\d: direct [\d.]+\. Not drawn: p\d\.off: no such file", page.text) == ["p8", "p7", "p6"]
    assert sorted(path.name for path in (tmp_path / "figures").glob("worst*")) == ["worst-1.png"]
    picture = imread(tmp_path / "figures" / "worst-1.png")[:, :, :3]
    assert (picture.max(axis=2) - picture.min(axis=2) > 0.25).sum() > 500, "coloured spheres"
    written(run(pairs[:3]), tmp_path)
    assert not list((tmp_path / "figures").glob("worst*")), "pictures of an earlier report are removed"
    assert not [path for path in Path(tmp_path).rglob(".*") if path.is_file()]


@pytest.mark.parametrize(
    ("scoring", "said"),
    [("exact", "differ by 0.00040 of the diameter on average"), ("heat", "measure with exact geodesics")],
)
def test_the_geodesics_of_the_scoring_are_stated(tmp_path, undrawn, scoring, said):
    page = written(run([record("a-b", direct=[0.01] * 3)], scoring={"geodesics": scoring}), tmp_path)
    assert said in page.text


def test_the_better_variant_is_shown_only_where_it_differs(report, tmp_path):
    assert "better of both" in report[1].tables["Within 5 % of the diameter"][0]
    page = written(run(usual()[:1]), tmp_path)
    assert page.tables["Within 5 % of the diameter"][0] == ["confidence", "matches", "direct"]
    assert "Direct is the better of both in every pair" in page.text


def test_matches_without_a_landmark_are_ignored():
    measures = summary.measures(record("a-b", direct=[np.nan] * 50 + [0.02] * 15 + [0.08] * 5), "direct")
    assert measures["known"] == 20
    assert measures["mean15"] == pytest.approx(0.02)
    assert measures["mean45"] == pytest.approx(0.035)
    assert measures["first15_close"] == 1
    assert measures["wrong"] == 0
