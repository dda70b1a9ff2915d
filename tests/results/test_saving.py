"""Results are written in the format that the ending of the name says, and as data frames."""

import json
import os
import sys
import types

import numpy as np
import pytest

import mobius_match as mm
from tests.shapes import lump


@pytest.fixture(scope="module")
def result():
    return mm.match(lump(2), lump(2), samples=30)


def test_json_is_the_result_file(result, tmp_path):
    for name in ("a.json", "B.JSON", "a.b.json"):
        result.save(tmp_path / name)
        np.testing.assert_array_equal(mm.Correspondence.load(tmp_path / name).pairs, result.pairs)


def test_other_endings_are_exported(result, tmp_path):
    result.save(tmp_path / "a.csv")
    rows = (tmp_path / "a.csv").read_text().splitlines()
    assert len(rows) == len(result) + 1
    assert rows[0].split(",")[:3] == ["name", "source", "target"]
    result.save(str(tmp_path / "b.npz"))
    with np.load(tmp_path / "b.npz") as file:
        assert len(file["source_points"]) == len(result)
    result.save(tmp_path / "c.mrk.json")
    assert sorted(path.name for path in tmp_path.glob("c*")) == ["c-source.mrk.json", "c-target.mrk.json"]
    assert "markups" in json.loads((tmp_path / "c-source.mrk.json").read_text())


@pytest.mark.parametrize("name", ["matches", "matches.xlsx", "csv", "matches.json.gz"])
def test_unknown_endings_are_refused(result, tmp_path, name):
    with pytest.raises(mm.SettingsError) as caught:
        result.save(tmp_path / name)
    message = str(caught.value)
    assert name in message
    assert all(ending in message for ending in (".json", ".csv", ".npz", ".mat", ".mrk.json", ".tps"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="the system has no /dev/null")  # noqa: PTH110
def test_a_device_gets_json(result):
    result.save("/dev/null")


def test_symmetries_are_json_alone(tmp_path):
    found = mm.symmetry(mm.examples.paths("person")[0])
    found.save(tmp_path / "a.json")
    assert json.loads((tmp_path / "a.json").read_text()) == json.loads(json.dumps(found.to_dict()))
    with pytest.raises(mm.SettingsError, match=r"a\.csv: the result is written as JSON"):
        found.save(tmp_path / "a.csv")
    assert not (tmp_path / "a.csv").exists()


@pytest.fixture
def pandas(monkeypatch):
    """A stand-in, whose data frames are dictionaries."""
    module = types.ModuleType("pandas")
    module.DataFrame = dict
    monkeypatch.setitem(sys.modules, "pandas", module)


@pytest.mark.usefixtures("pandas")
def test_matches_as_a_data_frame(result):
    frame = result.to_dataframe()
    assert list(frame) == [
        *("source", "target", "confidence", "kind", "given", "target_face"),
        *(f"target_vertex_{k}" for k in range(3)),
        *(f"barycentric_{k}" for k in range(3)),
    ]
    np.testing.assert_array_equal(np.stack([frame["source"], frame["target"]], axis=1), result.pairs)
    np.testing.assert_array_equal(frame["confidence"], result.confidence)
    np.testing.assert_array_equal(frame["kind"], result.kind)
    assert not frame["given"].any()
    weights = np.stack([frame[f"barycentric_{k}"] for k in range(3)], axis=1)
    np.testing.assert_array_equal(weights, result.target_points.barycentric)
    assert {column.shape for column in frame.values()} == {(len(result),)}


@pytest.mark.usefixtures("pandas")
def test_given_pairs_and_samples_in_a_data_frame():
    known = mm.match(lump(2), lump(2), samples=30, landmarks=[[3, 3]]).to_dataframe()
    assert known["source"][known["given"]].tolist() == [3]
    paper = mm.match(lump(2), lump(2), preset="paper", votes=20_000, samples=20).to_dataframe()
    assert list(paper) == ["source", "target", "confidence", "kind", "given"]


@pytest.mark.usefixtures("pandas")
def test_symmetries_as_a_data_frame():
    found = mm.symmetry(mm.examples.paths("person")[0])
    frame = found.to_dataframe()
    np.testing.assert_array_equal(np.stack([frame["source"], frame["target"]], axis=1), found.pairs)
    np.testing.assert_array_equal(frame["confidence"], found.confidence)


def test_without_pandas_the_remedy_is_named(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(mm.MissingPackageError, match="pip install pandas") as caught:
        result.to_dataframe()
    assert isinstance(caught.value, ImportError)
