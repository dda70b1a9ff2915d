"""The result record and its file."""

import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.evaluation import examples
from tests.shapes import lump


@pytest.fixture(scope="module")
def result():
    return mm.match(lump(2), lump(2), samples=30)


def test_file_is_the_contracts(result, tmp_path):
    path = tmp_path / "result.json"
    result.save(path)
    content = json.loads(path.read_text())
    assert content["format"] == "mobius-match/correspondence"
    assert content["version"] == 1
    for side in ("source", "target"):
        assert set(content[side]) == {"path", "sha256", "vertices", "faces", "area", "diameter"}
        assert content[side]["vertices"] == 162
        assert len(content[side]["sha256"]) == 64
    rows = content["correspondences"]
    assert len(rows) == len(result)
    assert [row["confidence"] for row in rows] == sorted((row["confidence"] for row in rows), reverse=True)
    assert set(rows[0]) == {"source", "target", "confidence", "kind", "target_point"}
    faces = lump(2)[1]
    for row in rows:
        point = row["target_point"]
        assert point["vertices"] == faces[point["face"]].tolist()
        assert row["target"] == point["vertices"][int(np.argmax(point["barycentric"]))]
        assert min(point["barycentric"]) >= 0
        assert sum(point["barycentric"]) == pytest.approx(1)
    assert {row["kind"] for row in rows} <= {"voted", "recovered"}
    assert content["settings"]["samples"] == 30
    assert content["timings"]["total"] > 0
    assert 0 < content["diagnostics"]["source closure"] < 1e-9
    assert content["diagnostics"]["triplets"] >= content["diagnostics"]["voting triplets"] > 0
    assert "alternatives" not in content
    assert content["software"]["mobius-match"] == mm.__version__


def test_alternatives_are_written_when_asked_for():
    person = mm.match(*examples.paths("person"))
    rows = person.to_dict(alternatives=True)["alternatives"]
    assert [row["margin"] for row in rows] == [one.margin for one in person.alternatives]
    assert len(rows) > 0
    for row, one in zip(rows, person.alternatives, strict=True):
        assert [(pair["source"], pair["target"]) for pair in row["correspondences"]] == list(
            map(tuple, one.pairs.tolist())
        )


def test_load_returns_what_was_saved_to_the_last_bit(result, tmp_path):
    path = tmp_path / "result.json"
    result.save(path)
    loaded = mm.Correspondence.load(path)
    np.testing.assert_array_equal(loaded.pairs, result.pairs)
    np.testing.assert_array_equal(loaded.confidence, result.confidence)
    np.testing.assert_array_equal(loaded.kind, result.kind)
    np.testing.assert_array_equal(loaded.target_points.barycentric, result.target_points.barycentric)
    assert loaded.to_dict() == json.loads(result.to_json())


def test_matches_that_are_samples_have_no_target_point(tmp_path):
    result = mm.match(lump(2), lump(2), preset="paper", votes=20_000, samples=20)
    assert "target_point" not in result.to_dict()["correspondences"][0]
    result.save(tmp_path / "result.json")
    assert mm.Correspondence.load(tmp_path / "result.json").target_points is None


def test_failed_save_leaves_the_old_file_and_nothing_else(result, tmp_path, monkeypatch):
    path = tmp_path / "result.json"
    path.write_text("old")

    def full(self, target):
        raise OSError("disk full")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(OSError, match="disk full"):
        result.save(path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["result.json"]


def test_save_writes_through_a_link(result, tmp_path):
    path, link = tmp_path / "result.json", tmp_path / "link.json"
    link.symlink_to(path)
    result.save(link)
    assert link.is_symlink()
    assert mm.Correspondence.load(path).pairs.shape == result.pairs.shape


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a readable result file"),
        ("{", "not a readable result file"),
        ("[1, 2]", "not a result of mobius match"),
        ('{"format": "other"}', "not a result of mobius match"),
        ('{"format": "mobius-match/correspondence", "version": 9}', "version 9"),
        ('{"format": "mobius-match/correspondence", "version": 1}', "damaged"),
        (
            '{"format": "mobius-match/correspondence", "version": 1, "correspondences": [{"source": "x"}]}',
            "damaged",
        ),
    ],
)
def test_bad_files_are_refused_by_name(tmp_path, text, words):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(mm.FormatError, match=words) as caught:
        mm.Correspondence.load(path)
    assert "bad.json" in str(caught.value)


def test_missing_file(tmp_path):
    with pytest.raises(mm.FormatError, match=r"nowhere\.json"):
        mm.Correspondence.load(tmp_path / "nowhere.json")
