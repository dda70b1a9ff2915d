"""`mobius demo`."""

import csv
import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.cli.demo import measure
from mobius_match.evaluation import examples
from mobius_match.geometry.geodesics import geodesic_solver


def test_every_pair_is_matched_measured_and_saved(mobius, tmp_path):
    folder = tmp_path / "new" / "folder"
    ended = mobius("demo", "-o", folder, "--json")
    assert ended.code == 0, ended.err
    assert str(folder) in ended.err.strip().split("\n")[-1]
    report = json.loads(ended.out)
    assert [entry["pair"] for entry in report] == list(examples.names())
    endings = (".json", ".csv", ".png", ".html")
    assert {path.name for path in folder.iterdir()} == {n + e for n in examples.names() for e in endings}
    for entry in report:
        name = entry["pair"]
        kept = mm.Correspondence.load(folder / f"{name}.json")
        matches = entry["matches"]
        assert kept.pairs.tolist() == [[row["source"], row["target"]] for row in matches]
        with (folder / f"{name}.csv").open() as lines:
            table = list(csv.DictReader(lines))
        assert table == [{key: str(value) for key, value in row.items()} for row in matches]
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG\r\n")
        assert (folder / f"{name}.html").read_text(encoding="utf-8").startswith("<!doctype html>")
        errors = [row["error"] for row in matches]
        assert entry["mean_error_first_15"] == pytest.approx(np.mean(errors[:15]))
        assert entry["mean_error_first_45"] == pytest.approx(np.mean(errors[:45]))
        assert entry["within_5_percent"] == pytest.approx(np.mean(np.array(errors) <= 0.05))
        assert entry["mean_error_first_15"] < 0.05
        assert entry["mean_error_first_45"] < 0.06


def test_tables_and_quiet(mobius, tmp_path, monkeypatch):
    first = examples.names()[0]
    monkeypatch.setattr(examples, "names", lambda: (first,))
    monkeypatch.chdir(tmp_path)
    ended = mobius("demo", "--quiet")
    assert (ended.code, ended.err) == (0, "")
    assert f"{first}: matches and their errors" in ended.out
    assert "within 5 %" in ended.out
    assert "\x1b" not in ended.out
    assert (tmp_path / "mobius-demo" / f"{first}.json").exists()


def test_a_folder_that_cannot_be(mobius, tmp_path):
    (tmp_path / "file").write_text("in the way")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        ended = mobius("demo", "-o", folder)
        assert (ended.code, ended.out) == (2, "")
        assert str(folder) in ended.err


def test_errors_are_geodesic_distances_per_diameter(pair, shape):
    result = mm.match(*pair[:2], samples=40, votes=2000)
    faces = pair[2][shape[1]]
    truth = np.zeros(642, dtype=int)
    corners = np.zeros((642, 3))
    everything = measure(result, *_as_points(pair[2], faces))["matches"]
    right = [row["error"] for row in everything if pair[2][row["source"]] == row["target"]]
    assert len(right) >= 20
    assert max(right) < 1e-3
    # All true points at one corner of one face: the errors are the distances to it, as well as heat gives them.
    truth[:], corners[:, 1] = 100, 1
    errors = [row["error"] for row in measure(result, truth, corners)["matches"]]
    exact = geodesic_solver(mm.read_mesh(pair[1]).vertices, faces, "exact")(faces[100, 1])[result.pairs[:, 1]]
    off = np.abs(errors - exact / result.target.diameter)
    assert off.mean() < 0.015
    assert off.max() < 0.05


def _as_points(vertices, faces):
    """Face and barycentric coordinates of vertices."""
    face = np.array([np.flatnonzero((faces == vertex).any(axis=1))[0] for vertex in vertices])
    return face, (faces[face] == vertices[:, None]).astype(float)
