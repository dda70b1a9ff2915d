"""``mobius bench``: what it prints, what it leaves, and how it ends."""

import json
import os
import shutil
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.conftest import lumps  # noqa: F401  # a fixture

QUICK = ("--samples", 25, "--votes", 4000, "--geodesics", "heat", "--jobs", 1)


@pytest.fixture
def two(lumps, tmp_path):  # noqa: F811
    """A folder with two pairs of shapes."""
    folder = tmp_path / "two"
    shutil.copytree(lumps, folder)
    (folder / "pairs.txt").write_text("lump0 lump1\nlump2 lump3\n")
    return folder


def test_run_report_resume_and_compare(mobius, two, tmp_path):
    out, other = tmp_path / "out", tmp_path / "other"
    ended = mobius("bench", two, "-o", out, *QUICK)
    assert ended.code == 0
    assert "2 pairs (vertex lists)" in ended.err
    assert str(out / "report.html") in ended.err
    assert "lump" in ended.out
    assert {path.name for path in out.iterdir()} >= {"run.json", "report.html", "pairs.csv", "summary.json", "figures"}
    assert json.loads((out / "run.json").read_text())["settings"]["samples"] == 25

    ended = mobius("bench", two, "-o", out, *QUICK)
    assert (ended.code, ended.out) == (2, "")
    assert "--resume" in ended.err

    ended = mobius("bench", two, "-o", out, *QUICK, "--resume", "--json", "--quiet")
    assert (ended.code, ended.err) == (0, "")
    figures = json.loads(ended.out)
    assert list(figures) == ["lump"]
    assert figures["lump"]["pairs"] == 2
    errors = [json.loads(path.read_text())["direct"] for path in sorted((out / "pairs").iterdir())]
    assert figures["lump"]["direct"]["mean15"] == pytest.approx(np.mean([found[:15] for found in errors]))
    assert figures["lump"]["mirrored"]["mean15"] > 0.2

    config = tmp_path / "settings.toml"
    config.write_text("samples = 25\nvotes = 4000\nseed = 7\njobs = 1\n")
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("lump0 lump1\n")
    options = ("--pairs", pairs, "--config", config, "--seed", 8)
    assert mobius("bench", two, "-o", other, *options).code == 0
    found = json.loads((other / "run.json").read_text())
    assert (found["cases"], found["settings"]["seed"], found["settings"]["votes"]) == (["lump0-lump1"], 8, 4000)

    ended = mobius("bench", "--compare", out, other, "-o", tmp_path / "both")
    assert (ended.code, ended.out) == (0, "")
    page = Path(ended.err.split("comparison: ")[1].strip())
    assert page.is_file()
    assert page.parent == tmp_path / "both"

    (other / "pairs" / "lump0-lump1.json").unlink()
    ended = mobius("bench", "--compare", out, other, "-o", tmp_path / "again")
    assert ended.code == 3
    assert "1 pairs of this run are not done" in ended.err
    assert not (tmp_path / "again").exists()


def test_some_pairs_failed_or_all(mobius, two, tmp_path):
    (two / "lump1.off").write_text("OFF\n4 4 0\n")
    ended = mobius("bench", two, "-o", tmp_path / "some", *QUICK)
    assert ended.code == 5
    assert "lump0-lump1" in ended.err
    assert "lump1.off" in ended.err
    assert "lump" in ended.out
    assert (tmp_path / "some" / "report.html").is_file()
    (two / "lump3.off").write_text("nothing")
    ended = mobius("bench", two, "-o", tmp_path / "all", *QUICK, "--json")
    assert ended.code == 3
    assert json.loads(ended.out)["lump"]["failed"] == 2
    assert (tmp_path / "all" / "report.html").is_file()


def test_maps_of_another_program(mobius, two, tmp_path):
    maps = tmp_path / "maps"
    maps.mkdir()
    for source, target in ((0, 1), (2, 3)):
        first, second = (np.loadtxt(two / "corres" / f"lump{i}.vts", dtype=int) for i in (source, target))
        dense = np.empty_like(first)
        dense[first - 1] = second - 1
        np.savetxt(maps / f"lump{source}-lump{target}.txt", dense, fmt="%d")
    out = tmp_path / "out"
    ended = mobius("bench", two, "-o", out, "--maps", maps, "--index-base", 0, *QUICK, "--json")
    assert ended.code == 0
    assert json.loads(ended.out)["lump"]["direct"]["dense_mean"] == 0
    assert json.loads(ended.out)["lump"]["mirrored"]["dense_mean"] > 0.1


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--maps", "."], 2, ["--index-base"]),
        (["--index-base", 1], 2, ["--index-base"]),
        (["--geodesics", "dijkstra"], 2, ["--geodesics is 'dijkstra'; choose one of exact, heat"]),
        (["--samples", 2], 2, ["samples"]),
        (["--jobs", 0], 2, ["--jobs is 0"]),
        (["--preset", "best"], 2, ["preset"]),
        (["--config", "none.toml"], 2, ["none.toml"]),
        (["--pairs", "none.txt"], 3, ["none.txt"]),
        (["-o", "pairs.txt"], 2, ["pairs.txt"]),
        (["--compare"], 2, ["two or more"]),
        (["--compare", "."], 3, ["run.json"]),
    ],
)
def test_refusals(mobius, two, options, code, words, monkeypatch):
    monkeypatch.chdir(two)
    ended = mobius("bench", two, *options)
    assert (ended.code, ended.out) == (code, "")
    for word in words:
        assert word in ended.err
    assert not (two / "mobius-bench").exists()


def test_wrong_usage(mobius, tmp_path):
    assert mobius("bench").code == 2
    assert "--compare" in mobius("bench", tmp_path, tmp_path).err
    ended = mobius("bench", tmp_path)
    assert ended.code == 3
    assert "corres/NAME.vts" in ended.err


def group(leader):
    """Processes of a group that are running."""
    stats = [path.read_text().rpartition(")")[2].split() for path in Path("/proc").glob("[0-9]*/stat") if path.exists()]
    return [stat for stat in stats if stat[2] == str(leader) and stat[0] != "Z"]


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize(
    ("moment", "signum", "code"), [("run.json", signal.SIGTERM, 143), ("pairs/*", signal.SIGINT, 130)]
)
def test_interrupted_with_all_its_processes(start_mobius, two, tmp_path, moment, signum, code):
    out = tmp_path / "out"
    process = start_mobius(
        "bench", two, "-o", out, "--samples", 25, "--votes", 10**6, "--jobs", 1, start_new_session=True
    )
    end = time.monotonic() + 60
    while not any(out.glob(moment)):
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.01)
    os.killpg(process.pid, signum) if signum == signal.SIGINT else process.send_signal(signum)
    printed, said = process.communicate(timeout=20)
    assert process.returncode == code
    assert printed == ""
    assert "Traceback" not in said
    assert said.splitlines()[-1] == {130: "interrupted", 143: "terminated"}[code]
    while group(process.pid):
        assert time.monotonic() < end
        time.sleep(0.01)


def test_progress_with_the_time_left_on_a_terminal(start_mobius, two, tmp_path):
    control, terminal = pytest.importorskip("pty").openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    process = start_mobius("bench", two, "-o", tmp_path / "out", *QUICK, stderr=terminal, env=environment)
    os.close(terminal)
    shown = b""
    while True:
        try:
            chunk = os.read(control, 4096)
        except OSError:  # how Linux reports that nobody writes any more
            break
        if not chunk:
            break
        shown += chunk
    os.close(control)
    assert process.wait(timeout=60) == 0
    for word in (b"meshes", b"pairs", b"left:"):
        assert word in shown
