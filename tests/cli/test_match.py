"""`mobius match`: what it prints and writes."""

import hashlib
import json
import re

import numpy as np
import pytest

QUICK = ("--samples", 40, "--votes", 4000)


@pytest.fixture
def result(mobius, pair, tmp_path):
    """Result file of a quick match, read."""

    def match(*options):
        path = tmp_path / "result.json"
        ended = mobius("match", *pair[:2], *QUICK, "-o", path, *options)
        assert ended.code == 0, ended.err
        return json.loads(path.read_text())

    return match


def test_result_file_follows_the_contract(result, pair):
    found = result("--seed", 3)
    assert found["format"] == "mobius-match/correspondence"
    assert found["version"] == 1
    for role, path in zip(("source", "target"), pair[:2], strict=True):
        mesh = found[role]
        assert mesh["path"] == str(path)
        assert mesh["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert (mesh["vertices"], mesh["faces"]) == (642, 1280)
        assert mesh["area"] > 0
        assert mesh["diameter"] > 0
    assert found["settings"]["seed"] == 3
    assert found["settings"]["samples"] == 40
    assert all(seconds >= 0 for seconds in found["timings"].values())
    assert found["software"]["mobius-match"]
    rows = found["correspondences"]
    assert rows
    confidence = [row["confidence"] for row in rows]
    assert confidence == sorted(confidence, reverse=True)
    assert all(0 <= value <= 1 for value in confidence)
    assert {row["kind"] for row in rows} <= {"voted", "recovered"}
    for role in ("source", "target"):
        numbers = [row[role] for row in rows]
        assert all(type(number) is int and 0 <= number < 642 for number in numbers)
        assert len(set(numbers)) == len(numbers)


def test_finds_the_renumbered_vertices_of_a_turned_shape(result, pair):
    rows = result()["correspondences"]
    right = [pair[2][row["source"]] == row["target"] for row in rows]
    assert len(rows) >= 20
    assert np.mean(right) >= 0.95


def test_without_options_a_table_is_printed(mobius, pair):
    ended = mobius("match", *pair[:2], *QUICK)
    assert ended.code == 0
    assert "one.off" in ended.out
    assert "two.off" in ended.out
    assert "confidence" in ended.out
    assert "\x1b" not in ended.out + ended.err
    more = int(re.search(r"and (\d+) more: -o FILE", ended.out)[1])
    assert f"{more + 20} correspondences" in ended.out
    assert len(re.findall(r"voted|recovered", ended.out)) == 20


def test_output_is_written_in_the_format_that_its_name_says(mobius, pair, tmp_path):
    ended = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "a.csv")
    assert ended.code == 0
    rows = (tmp_path / "a.csv").read_text().splitlines()
    assert rows[0].startswith("name,source,target,")
    assert f"{len(rows) - 1} correspondences written to {tmp_path / 'a.csv'}\n" in ended.err
    ended = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "b.mrk.json", "--quiet")
    assert (ended.code, ended.out, ended.err) == (0, "", "")
    assert sorted(path.name for path in tmp_path.glob("b*")) == ["b-source.mrk.json", "b-target.mrk.json"]


def test_outputs_of_unknown_or_too_small_formats_are_refused_before_any_work(mobius, tmp_path):
    for output, options, words in (
        ("a.xlsx", (), (".json", ".csv", ".mrk.json")),
        ("a", (), (".json", ".csv", ".mrk.json")),
        ("a.csv", ("--alternatives",), ("--alternatives", "a.csv", "--json")),
    ):
        ended = mobius("match", "no.off", "such.off", "-o", tmp_path / output, *options)
        assert (ended.code, ended.out) == (2, "")
        assert all(word in ended.err for word in words)
    ended = mobius("symmetry", "no.off", "-o", tmp_path / "a.csv")
    assert ended.code == 2
    assert "a.csv" in ended.err


@pytest.mark.parametrize("options", [["--json"], ["-o", "-"], ["-o", "-", "--json"]])
def test_json_alone_on_standard_output(mobius, pair, options):
    ended = mobius("match", *pair[:2], *QUICK, *options)
    assert ended.code == 0
    assert json.loads(ended.out)["correspondences"]


def test_output_file_leaves_standard_output_empty(mobius, pair, tmp_path):
    path = tmp_path / "result.json"
    ended = mobius("match", *pair[:2], *QUICK, "-o", path)
    assert ended.out == ""
    assert f"{len(json.loads(path.read_text())['correspondences'])} correspondences" in ended.err
    assert [path] == list(tmp_path.iterdir())


def test_quiet_says_nothing(mobius, pair, tmp_path):
    assert mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "result.json", "--quiet") == (0, "", "")


def test_verbose_shows_timings(mobius, pair, tmp_path):
    ended = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "result.json", "--verbose")
    assert "voting: " in ended.err
    assert "total: " in ended.err


@pytest.mark.parametrize("proposal", ["guided", "uniform"])
def test_threads_do_not_change_the_result(result, proposal):
    one = result("--proposal", proposal, "--min-fraction", 0.3, "--jobs", 1)
    three = result("--proposal", proposal, "--min-fraction", 0.3, "--jobs", 3)
    assert one["correspondences"] == three["correspondences"]


@pytest.mark.parametrize(
    ("option", "value", "name"),
    [
        ("--samples", 33, "samples"),
        ("--votes", 3000, "votes"),
        ("--proposal", "uniform", "proposal"),
        ("--distance", "spherical", "distance"),
        ("--min-fraction", 0.25, "min_fraction"),
        ("--geodesics", "dijkstra", "geodesics"),
        ("--triangulation", "mesh", "triangulation"),
        ("--assignment", "linear", "assignment"),
        ("--threshold", 0.05, "threshold"),
        ("--spacing", 0.1, "spacing"),
        ("--reflect", "yes", "reflect"),
        ("--seed", 7, "seed"),
        ("--jobs", 1, "jobs"),
    ],
)
def test_every_option_reaches_the_match(result, option, value, name):
    assert result(option, value)["settings"][name] == value


def test_options_win_over_the_preset(result):
    settings = result("--preset", "paper", "--geodesics", "heat")["settings"]
    assert settings["proposal"] == "uniform"
    assert settings["min_fraction"] == 0.4
    assert settings["samples"] == 40
    assert settings["geodesics"] == "heat"


def test_a_mirror_image_is_matched(mobius, pair, tmp_path):
    lines = pair[0].read_text().split()
    n, m = int(lines[1]), int(lines[2])
    vertices = np.reshape(lines[4 : 4 + 3 * n], (n, 3)).astype(float) * [-1, 1, 1]
    faces = np.reshape(lines[4 + 3 * n : 4 + 3 * n + 4 * m], (m, 4))[:, [0, 1, 3, 2]]
    mirrored = tmp_path / "mirrored.off"
    rows = [f"OFF {n} {m} 0", *(f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()), *map(" ".join, faces)]
    mirrored.write_text("\n".join(rows) + "\n")
    ended = mobius("match", pair[0], mirrored, *QUICK, "--reflect", "auto", "--json")
    assert ended.code == 0, ended.err
    found = json.loads(ended.out)
    assert found["reflected"] is True and found["settings"]["reflect"] == "auto"
    assert "its mirror image was matched (probability 1.00)" in ended.err
    assert np.mean([row["source"] == row["target"] for row in found["correspondences"]]) >= 0.95
    assert "--reflect is 'maybe'" in mobius("match", pair[0], mirrored, "--reflect", "maybe").err


def test_a_mesh_matches_itself(mobius, pair):
    ended = mobius("match", pair[0], pair[0], *QUICK, "--json")
    rows = json.loads(ended.out)["correspondences"]
    assert np.mean([row["source"] == row["target"] for row in rows]) >= 0.95


def test_a_repair_is_reported(mobius, pair, tmp_path):
    lines = pair[0].read_text().split("\n")
    extra = tmp_path / "extra.off"
    header, first = lines[1].split(), "9 9 9"
    extra.write_text("\n".join(["OFF", f"{int(header[0]) + 1} {header[1]} 0", *lines[2:644], first, *lines[644:]]))
    ended = mobius("match", extra, pair[1], *QUICK, "--json")
    assert ended.code == 0, ended.err
    assert "extra.off" in ended.err
    assert "1 unused vertex dropped" in ended.err
    assert json.loads(ended.out)["source"]["vertices"] == 643
    assert mobius("match", extra, pair[1], *QUICK, "--json", "--quiet").err == ""


def test_picture(mobius, pair, tmp_path):
    path = tmp_path / "matches.png"
    ended = mobius("match", *pair[:2], *QUICK, "--picture", path, "--json")
    assert ended.code == 0, ended.err
    assert path.read_bytes().startswith(b"\x89PNG\r\n")
    assert json.loads(ended.out)
    assert [path] == list(tmp_path.iterdir())


def test_landmarks_that_are_known(mobius, result, pair, tmp_path):
    number = pair[2]
    (tmp_path / "known.csv").write_text(f"source,target\n5,{number[5]}\n600,{number[600]}\n")
    found = result("--landmarks", tmp_path / "known.csv")
    first, second, *others = found["correspondences"]
    for row, vertex in ((first, 5), (second, 600)):
        assert (row["source"], row["target"], row["confidence"]) == (vertex, number[vertex], 1.0)
        assert row["given"] is True
    assert not any("given" in row for row in others)
    assert found["settings"]["landmarks"] == [[5, number[5]], [600, number[600]]]
    # The same pairs, in a file for each shape; and what is printed.
    for name, vertices in (("one.csv", [5, 600]), ("two.csv", number[[5, 600]])):
        (tmp_path / name).write_text("name,vertex\n" + "".join(f"n{k},{v}\n" for k, v in enumerate(vertices)))
    files = ("--landmarks", tmp_path / "one.csv", "--landmarks", tmp_path / "two.csv")
    assert result(*files)["correspondences"] == found["correspondences"]
    ended = mobius("match", *pair[:2], *QUICK, *files)
    assert ended.out.count("given") == 2


@pytest.mark.parametrize(
    ("text", "options", "code", "message"),
    [
        ("source,target\n1,642\n", (), 2, "has no vertex 642; it has 642, numbered from 0"),
        ("source,target\n1,2\n1,3\n", (), 2, "vertex 1 of one.off is given 2 counterparts (2, 3)"),
        ("source,target\n", (), 2, "there is no pair"),
        ("source,target\n1,x\n", (), 3, "known.csv: line 2: 'x' is not a number"),
        ("", (), 3, "known.csv: the file is empty"),
        ("source,target\n1,2\n", ("--proposal", "uniform"), 2, "--landmarks need guided proposals"),
        ("source,target\n1,2\n", ("-o", "known.csv"), 2, "is one of the inputs"),
    ],
)
def test_bad_landmarks(mobius, pair, tmp_path, monkeypatch, text, options, code, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "known.csv").write_text(text)
    ended = mobius("match", *pair[:2], *QUICK, "--landmarks", "known.csv", *options)
    assert (ended.code, ended.out) == (code, ""), ended.err
    assert message in ended.err
    assert len(ended.err.splitlines()) == 1
    assert (tmp_path / "known.csv").read_text() == text
