"""Runs over many pairs: results do not depend on processes, interruptions and failures."""

import json
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import FormatError, SettingsError
from mobius_match.evaluation import find_dataset, load_run, run, write_report
from tests.evaluation.conftest import QUICK

NAMES = [f"lump{i}-lump{j}" for i in range(4) for j in range(i + 1, 4)]


@pytest.fixture(scope="module")
def finished(lumps, tmp_path_factory):
    """An uninterrupted run with its report."""
    out = tmp_path_factory.mktemp("finished") / "run"
    calls = []
    found = run(find_dataset(lumps), out, jobs=2, progress=lambda *call: calls.append(call), **QUICK)
    write_report(found, out)
    return found, calls


def comparable(folder):
    """All files of a run without times and memory, which are separate in each."""
    files = {}
    for path in sorted(path for path in Path(folder).rglob("*") if path.is_file()):
        content = path.read_bytes()
        if path.name == "report.html":
            content, cut = re.subn(rb'<section id="times">.*?</section>', b"", content, flags=re.DOTALL)
            assert cut == 1
        elif path.name == "pairs.csv":
            rows = [line.split(",") for line in content.decode().splitlines()]
            keep = [i for i, name in enumerate(rows[0]) if not name.endswith(("_seconds", "_mb"))]
            assert len(keep) < len(rows[0])
            content = [[row[i] for i in keep] for row in rows]
        elif path.suffix == ".json":
            content = json.loads(content)
            content = {key: value for key, value in content.items() if key not in ("timings", "memory_mb", "times")}
        files[str(path.relative_to(folder))] = content
    return files


def test_record_of_a_pair(finished, lumps):
    found, _ = finished
    assert [record["name"] for record in found.records] == NAMES == found.info["cases"]
    for record in found.records:
        source, target = Path(record["source"]), Path(record["target"])
        result = mm.match(source, target, seed=0, **QUICK)
        assert record["status"] == "done"
        assert record["pairs"] == result.pairs.tolist()
        assert record["confidence"] == pytest.approx(result.confidence.tolist(), rel=1e-8)
        assert record["kind"] == result.kind.tolist()
        n = len(result)
        assert [len(record[key]) for key in ("pairs", "direct", "mirrored")] == [n] * 3
        first, second = (np.loadtxt(lumps / "corres" / f"{path.stem}.vts", dtype=int) - 1 for path in (source, target))
        partner = dict(zip(first.tolist(), second.tolist(), strict=True))
        wrong = [partner[i] != j for i, j in record["pairs"]]
        assert [error > 0 for error in record["direct"]] == wrong
        assert sum(wrong) < n / 2
        assert all(error > 0 for error in record["mirrored"])
        assert record["area"] == pytest.approx(result.target_info["area"])
        assert record["diameter"] == pytest.approx(result.target_info["diameter"], rel=0.05)
        assert 0 < record["heat_difference"] < 0.02 or not any(wrong)
        assert {"source sampling", "target descriptors", "voting", "scoring", "total"} <= set(record["timings"])
        assert record["memory_mb"] > 20
        assert record["dense"] is None


def test_progress_reaches_the_end(finished):
    assert finished[1][0] == ("meshes", 0, 4)
    assert ("meshes", 4, 4) in finished[1]
    assert finished[1][-1] == ("pairs", 6, 6)
    assert [done for stage, done, _ in finished[1] if stage == "pairs"] == list(range(7))


def test_no_temporary_files_are_left(finished):
    folder = finished[0].folder
    assert {path.name for path in folder.iterdir()} == {
        "run.json",
        "pairs",
        "figures",
        "report.html",
        "pairs.csv",
        "summary.json",
    }
    assert sorted(path.stem for path in (folder / "pairs").iterdir()) == sorted(NAMES)


def test_the_number_of_processes_changes_nothing(finished, lumps, tmp_path):
    again = run(find_dataset(lumps), tmp_path, jobs=1, **QUICK)
    parts = [comparable(folder / "pairs") for folder in (tmp_path, finished[0].folder)]
    assert len(parts[0]) == 6
    assert parts[0] == parts[1]
    assert again.info == finished[0].info


def children(process):
    return [int(number) for number in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL here")
def test_killed_twice_and_resumed(finished, lumps, tmp_path):
    out = tmp_path / "run"
    arguments = ["bench", lumps, "-o", out, "--jobs", 1, "--samples", 25, "--votes", 4000, "--quiet", "--resume"]
    command = [sys.executable, "-c", "from mobius_match.cli import main; main()", *map(str, arguments)]
    for moment in ("surfaces/*.npz", "pairs/*.json"):
        process = subprocess.Popen(command)
        wait_for(lambda process=process, moment=moment: process.poll() is not None or any(out.glob(moment)))
        workers = children(process.pid) if sys.platform == "linux" else []
        process.kill()
        assert process.wait() < 0
        assert workers or sys.platform != "linux"
        for worker in workers:
            wait_for(lambda worker=worker: not Path(f"/proc/{worker}").exists(), 20)
        (out / "pairs" / ".lump0-lump1.json.half").write_text("{")  # as a killed process may leave it
    before = {path: path.stat().st_mtime_ns for path in out.glob("pairs/lump*.json")}
    assert 1 <= len(before) < 6
    assert subprocess.run(command, check=False, stdout=subprocess.DEVNULL).returncode == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert comparable(out) == comparable(finished[0].folder)


def test_a_finished_run_is_not_done_again(finished, lumps, tmp_path):
    shutil.copytree(finished[0].folder, tmp_path / "run")
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.json")}
    run(find_dataset(lumps), tmp_path / "run", resume=True, **QUICK)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.json")} == before


def test_resuming_needs_the_same_run(finished, lumps, tmp_path):
    out = tmp_path / "run"
    shutil.copytree(finished[0].folder, out)
    dataset = find_dataset(lumps)
    kept = comparable(out)
    for words, options in (
        ("already holds a run; continue it with `resume`", {"resume": False}),
        ("other settings, seed.*0.*1", {"seed": 1}),
        ("other settings, samples", {"samples": 30}),
        ("other settings, geodesics.*heat.*dijkstra", {"preset": "paper"}),
        ("other scoring, geodesics.*exact.*heat", {"scoring": "heat"}),
        ("other dense maps", {"maps": lumps, "index_base": 1}),
    ):
        with pytest.raises(SettingsError, match=words):
            run(dataset, out, **({"resume": True} | QUICK | options))
    (tmp_path / "pairs.txt").write_text("lump0 lump1\n")
    with pytest.raises(SettingsError, match="other meshes, known correspondence or pairs"):
        run(find_dataset(lumps, tmp_path / "pairs.txt"), out, resume=True, **QUICK)
    changed = tmp_path / "lumps"
    shutil.copytree(lumps, changed)
    with (changed / "lump2.off").open("a") as file:
        file.write("# touched\n")
    with pytest.raises(SettingsError, match="other meshes, known correspondence or pairs"):
        run(find_dataset(changed), out, resume=True, **QUICK)
    assert comparable(out) == kept


def test_the_data_may_have_moved(finished, lumps, tmp_path):
    shutil.copytree(lumps, tmp_path / "lumps")
    shutil.copytree(finished[0].folder, tmp_path / "run")
    assert len(run(find_dataset(tmp_path / "lumps"), tmp_path / "run", resume=True, **QUICK).records) == 6


def test_bad_pairs_fail_alone_and_are_tried_again(lumps, tmp_path):
    data, out = tmp_path / "lumps", tmp_path / "run"
    shutil.copytree(lumps, data)
    whole = (data / "lump1.off").read_text()
    (data / "lump1.off").write_text("OFF\n4 4 0\n")
    numbers = (data / "corres" / "lump0.vts").read_text().split("\n")
    (data / "corres" / "lump0.vts").write_text("\n".join(["643", *numbers[1:]]))
    (data / "pairs.txt").write_text("lump3 lump1\nlump0 lump2\nlump2 lump3\n")
    found = run(find_dataset(data), out, scoring="heat", jobs=1, **QUICK)
    assert [record["status"] for record in found.records] == ["failed", "failed", "done"]
    for record, words in zip(found.records, ("lump1.off", "lump0.off: the list of"), strict=False):
        assert words in record["error"]
        assert set(record) == {"name", "category", "source", "target", "status", "error"}
    again = run(find_dataset(data), out, scoring="heat", resume=True, jobs=1, **QUICK)
    assert again.records == found.records
    (data / "lump1.off").write_text(whole)
    with pytest.raises(SettingsError, match="other meshes, known correspondence or pairs"):
        run(find_dataset(data), out, scoring="heat", resume=True, **QUICK)


def test_dense_maps_of_another_program(lumps, tmp_path):
    maps = tmp_path / "maps"
    maps.mkdir()
    (tmp_path / "pairs.txt").write_text("lump0 lump1\nlump0 lump2\nlump0 lump3\nlump1 lump2\n")
    truth = [np.loadtxt(lumps / "corres" / f"lump{i}.vts", dtype=int) for i in range(4)]
    mirrored = np.loadtxt(lumps / "corres" / "lump2.sym.vts", dtype=int)
    for name, found in (("lump0-lump1", truth[1]), ("lump0-lump2", mirrored), ("lump0-lump3", truth[3])):
        dense = np.empty(len(found), int)
        dense[truth[0] - 1] = found
        np.savetxt(maps / f"{name}.txt", dense[: 600 if "3" in name else None], fmt="%d")
    found = run(
        find_dataset(lumps, tmp_path / "pairs.txt"), tmp_path / "run", maps=maps, index_base=1, scoring="heat", jobs=1
    )
    right, turned, short, missing = found.records
    assert right["dense"]["direct"] == [0] * 642
    assert min(right["dense"]["mirrored"]) > 0
    assert turned["dense"]["mirrored"] == [0] * 642
    assert min(turned["dense"]["direct"]) > 0
    assert right["pairs"] == right["direct"] == []
    assert "600 entries" in short["error"]
    assert "lump1-lump2.txt" in missing["error"]
    assert found.info["maps"]["index_base"] == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scoring": "dijkstra"}, "`scoring` is 'dijkstra'; choose one of exact, heat"),
        ({"maps": "maps"}, "index_base"),
        ({"index_base": 0}, "index_base"),
        ({"maps": "maps", "index_base": 2}, "index_base"),
        ({"jobs": 0}, "`jobs` is 0; give a number from 1 to 1024"),
        ({"samples": 2}, "samples"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_wrong_settings_leave_nothing(lumps, tmp_path, options, words):
    with pytest.raises(SettingsError, match=words):
        run(find_dataset(lumps), tmp_path / "run", **options)
    assert not (tmp_path / "run").exists()


def test_folders_that_are_no_runs(finished, tmp_path):
    with pytest.raises(FormatError, match=r"run\.json"):
        load_run(tmp_path)
    (tmp_path / "run.json").write_text('{"format": "something else"}')
    with pytest.raises(FormatError, match="not a run"):
        load_run(tmp_path)
    shutil.copytree(finished[0].folder, tmp_path / "run")
    (tmp_path / "run" / "pairs" / f"{NAMES[2]}.json").unlink()
    assert [record["name"] for record in load_run(tmp_path / "run").records] == NAMES[:2] + NAMES[3:]
    (tmp_path / "run" / "pairs" / f"{NAMES[0]}.json").write_text("{")
    with pytest.raises(FormatError, match=NAMES[0]):
        load_run(tmp_path / "run")
