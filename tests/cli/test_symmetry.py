"""`mobius symmetry`: what it prints and writes, and how it ends."""

import hashlib
import json

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from mobius_match.matching.symmetry.parameters import SymmetryParameters

QUICK = ("--samples", 60, "--votes", 6000)


@pytest.fixture(scope="session")
def twofold(shape, tmp_path_factory):
    """A file of a shape that the plane x = 0 cuts into mirror images, and the mirror image of each vertex."""
    vertices, faces = shape
    radius = np.linalg.norm(vertices, axis=1, keepdims=True)
    opposite = cKDTree(vertices / radius).query(vertices / radius * [-1, 1, 1])[1]
    mirrored = vertices / radius * (radius + radius[opposite]) / 2
    path = tmp_path_factory.mktemp("twofold") / "twofold.off"
    path.write_bytes(trimesh.Trimesh(mirrored, faces, process=False).export(file_type="off").encode())
    return path, opposite


def test_result_file_follows_the_contract(mobius, twofold, tmp_path):
    path, opposite = twofold
    output = tmp_path / "symmetry.json"
    ended = mobius("symmetry", path, *QUICK, "--seed", 3, "-o", output)
    assert ended.code == 0, ended.err
    assert ended.out == ""
    found = json.loads(output.read_text())
    assert (found["format"], found["version"]) == ("mobius-match/symmetry", 1)
    assert found["source"]["path"] == str(path)
    assert found["source"]["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (found["source"]["vertices"], found["source"]["faces"]) == (642, 1280)
    assert (found["settings"]["seed"], found["settings"]["samples"], found["settings"]["votes"]) == (3, 60, 6000)
    assert all(seconds >= 0 for seconds in found["timings"].values())
    assert found["software"]["mobius-match"]
    assert found["warnings"] == []
    assert len(found["pairs"]) >= 12
    for row in found["pairs"]:
        assert set(row) == {"source", "target", "confidence"}
        assert opposite[row["source"]] == row["target"]
        assert 0 < row["confidence"] <= 1
    assert found["score"] > 0.99
    middle = np.flatnonzero(opposite == np.arange(642))
    assert set(middle.tolist()) <= set(found["stationary"])
    assert f"{len(found['pairs'])} pairs, score 1.00, written to" in ended.err
    assert [output] == list(tmp_path.iterdir())


@pytest.mark.parametrize("options", [["--json"], ["-o", "-"], ["-o", "-", "--json"]])
def test_json_alone_on_standard_output(mobius, twofold, options):
    ended = mobius("symmetry", twofold[0], *QUICK, *options)
    assert ended.code == 0
    assert json.loads(ended.out)["pairs"]


def test_without_options_a_table_is_printed(mobius, twofold):
    ended = mobius("symmetry", twofold[0], *QUICK)
    assert ended.code == 0
    for text in ("score 1.00", "map to themselves", "mirrored", "confidence"):
        assert text in ended.out
    assert "\x1b" not in ended.out + ended.err


def test_a_shape_without_symmetry_is_reported(mobius, pair):
    ended = mobius("symmetry", pair[0], "--json")
    if ended.code == 4:
        assert "no mirror symmetry" in ended.err
    else:
        assert json.loads(ended.out)["score"] < SymmetryParameters().low_score
        assert "hardly symmetric" in ended.err


def test_threads_do_not_change_the_result(mobius, twofold):
    one, three = (json.loads(mobius("symmetry", twofold[0], *QUICK, "--jobs", n, "--json").out) for n in (1, 3))
    for name in ("pairs", "stationary", "score"):
        assert one[name] == three[name]


@pytest.mark.parametrize(
    ("option", "value", "name"),
    [
        ("--samples", 33, "samples"),
        ("--votes", 3000, "votes"),
        ("--geodesics", "dijkstra", "geodesics"),
        ("--triangulation", "mesh", "triangulation"),
        ("--seed", 7, "seed"),
        ("--jobs", 1, "jobs"),
    ],
)
def test_every_option_reaches_the_search(mobius, twofold, option, value, name):
    assert json.loads(mobius("symmetry", twofold[0], *QUICK, "--json", option, value).out)["settings"][name] == value


def test_quiet_says_nothing_and_verbose_shows_timings(mobius, twofold, tmp_path):
    assert mobius("symmetry", twofold[0], *QUICK, "-o", tmp_path / "a.json", "--quiet") == (0, "", "")
    assert "voting: " in mobius("symmetry", twofold[0], *QUICK, "-o", tmp_path / "a.json", "--verbose").err


def test_picture(mobius, twofold, tmp_path):
    path = tmp_path / "pairs.png"
    ended = mobius("symmetry", twofold[0], *QUICK, "--picture", path, "--json")
    assert ended.code == 0, ended.err
    assert path.read_bytes().startswith(b"\x89PNG\r\n")
    assert json.loads(ended.out)
    assert [path] == list(tmp_path.iterdir())


def test_nothing_found_is_4_and_leaves_no_file(mobius, pair, tmp_path):
    ended = mobius("symmetry", pair[0], "--samples", 6, "-o", tmp_path / "a.json", "--picture", tmp_path / "a.png")
    assert (ended.code, ended.out) == (4, "")
    assert ended.err.startswith("error: one.off: no mirror symmetry")
    assert ended.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_result_outlives_a_failure(mobius, pair, tmp_path):
    path = tmp_path / "a.json"
    path.write_text("earlier")
    assert mobius("symmetry", pair[0], "--samples", 6, "-o", path).code == 4
    assert path.read_text() == "earlier"


def test_unusable_meshes_are_3(mobius, klein, broken, tmp_path):
    for path in (klein, broken, tmp_path / "missing.off"):
        ended = mobius("symmetry", path, "--json")
        assert (ended.code, ended.out) == (3, "")
        assert path.name in ended.err
        assert "Traceback" not in ended.err


def test_wrong_usage_is_2_before_any_work(mobius, twofold, tmp_path):
    path = twofold[0]
    for options, text in (
        (["--samples", 3], "samples"),
        (["--geodesics", "flat"], "geodesics"),
        (["-o", tmp_path / "no" / "a.json"], "does not exist"),
        (["-o", path], "one of the inputs"),
        (["--picture", tmp_path / "a.jpg"], ".png"),
        (["--picture", tmp_path / "a.png", "-o", tmp_path / "a.png"], "another file"),
    ):
        ended = mobius("symmetry", path, *options)
        assert (ended.code, ended.out) == (2, ""), options
        assert text in ended.err
    assert list(tmp_path.iterdir()) == []
