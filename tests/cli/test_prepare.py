"""`mobius prepare` and `mobius cache`, and prepared files and the cache in other commands."""

import json
import shutil

import pytest

import mobius_match as mm
from mobius_match.cli.prepare import file_names

QUICK = ("--samples", 30, "--votes", 2000)


def content(path):
    return json.loads(path.read_text()) | {"timings": None}


@pytest.fixture
def cache(mobius):
    def look(*options):
        ended = mobius("cache", "--json", *options)
        assert (ended.code, ended.err) == (0, "")
        return json.loads(ended.out)

    return look


def test_files_in_place_of_meshes_give_the_same_result(mobius, pair, tmp_path):
    ended = mobius("prepare", *pair[:2], "-o", tmp_path / "new" / "folder", "--samples", 30, "--json", "--jobs", 2)
    assert (ended.code, ended.err) == (0, "")
    entries = json.loads(ended.out)
    files = [tmp_path / "new" / "folder" / name for name in ("one.npz", "two.npz")]
    assert [entry["mesh"] for entry in entries] == [str(path) for path in pair[:2]]
    assert [entry["surface"] for entry in entries] == [str(path) for path in files]
    assert [(entry["vertices"], entry["samples"], entry["error"]) for entry in entries] == 2 * [(642, 30, None)]
    assert sorted(files[0].parent.iterdir()) == files
    for number, inputs in enumerate((pair[:2], files, (files[0], pair[1]))):
        ended = mobius("match", *inputs, *QUICK, "-o", tmp_path / f"{number}.json")
        assert (ended.code, "prepared with" in ended.err) == (0, False)
    assert content(tmp_path / "0.json") == content(tmp_path / "1.json") == content(tmp_path / "2.json")
    assert mobius("match", *files).out.count("one.off") == 1


def test_one_failing_mesh_is_reported_and_the_rest_finished(mobius, pair, klein, broken, tmp_path):
    ended = mobius("prepare", klein, pair[0], broken, "-o", tmp_path / "out", "--samples", 10, "--jobs", 1)
    assert ended.code == 5
    assert [line.split(":")[:2] for line in ended.err.splitlines()] == [
        ["error", f" {klein.name}"],
        ["error", f" {broken}"],
    ]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["one.npz"]
    assert ended.out.count("failed") == 2
    for alone in (broken, tmp_path / "out" / "one.npz"):
        ended = mobius("prepare", alone, "-o", tmp_path / "other", "--json")
        assert ended.code == 3
        assert str(alone) in ended.err
        (entry,) = json.loads(ended.out)
        assert (entry["mesh"], entry["surface"]) == (str(alone), None)
        assert f"error: {entry['error']}\n" == ended.err


def test_no_two_files_have_one_name(tmp_path):
    paths = [tmp_path / name for name in ("a/cat.off", "b/cat.off", "a/Cat.obj", "cat-2.off", "a/cat.off", "dog.off")]
    assert list(file_names(paths).values()) == ["cat.npz", "cat-2.npz", "Cat-3.npz", "cat-2-2.npz", "dog.npz"]


def test_preset_and_config_count(mobius, pair, tmp_path):
    (tmp_path / "config.toml").write_text('samples = 12\nvotes = 3\nplacement = "closest"\n')
    assert mobius("prepare", pair[0], "-o", tmp_path, "--config", tmp_path / "config.toml").code == 0
    found = mm.Surface.load(tmp_path / "one.npz").settings
    assert (found.samples, found.placement, found.geodesics) == (12, "closest", "heat")
    ended = mobius("prepare", pair[0], "-o", tmp_path, "--preset", "paper", "--samples", 11)
    assert ended.code == 0
    assert mm.Surface.load(tmp_path / "one.npz").settings == mm.PrepareSettings(11, "dijkstra", "mesh", "closest", 0)


def test_wrong_usage(mobius, pair, tmp_path):
    assert mobius("prepare", pair[0]).code == 2
    for options in (["--samples", 2], ["--jobs", 0], ["--preset", "thesis"]):
        ended = mobius("prepare", pair[0], "-o", tmp_path / "out", *options)
        assert ended.code == 2
        assert not (tmp_path / "out").exists()
    assert mobius("prepare", pair[0], "-o", pair[1]).code == 2


def test_options_that_a_prepared_file_does_not_follow_are_refused(mobius, pair, tmp_path):
    mobius("prepare", pair[0], "-o", tmp_path, "--samples", 30, "--quiet")
    for command in (("match", tmp_path / "one.npz", pair[1]), ("symmetry", tmp_path / "one.npz")):
        ended = mobius(*command, "--samples", 31, "--votes", 2000)
        assert (ended.code, ended.out) == (2, "")
        assert "but the " in ended.err
        assert "one.off was prepared with --samples 30" in ended.err
    ended = mobius("match", tmp_path / "one.npz", pair[1], "--votes", 2000)
    assert ended.code == 0
    assert "prepared with different settings (samples 30 and 100)" in ended.err


def test_other_archives_and_missing_files_are_refused(mobius, pair, tmp_path):
    (tmp_path / "other.npz").write_bytes(b"PK")
    for name in ("other.npz", "none.npz"):
        ended = mobius("match", pair[0], tmp_path / name)
        assert ended.code == 3
        assert ended.err.startswith(f"error: {tmp_path / name}: ")
        assert len(ended.err.splitlines()) == 1


def test_the_command_keeps_what_it_prepared_and_uses_it(mobius, pair, tmp_path, cache, cache_folder):
    assert cache() == {"folder": str(cache_folder), "surfaces": 0, "bytes": 0, "limit": 2_000_000_000}
    assert mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "0.json", "--no-cache", "-v").code == 0
    assert cache()["surfaces"] == 0
    first = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "1.json", "-v")
    second = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "2.json", "-v")
    assert "source sampling: " in first.err
    assert "prepared before" not in first.err
    assert "source sampling: " not in second.err
    # Both are looked up at once, so either may be told first.
    assert all(f"{name}: prepared before, taken from " in second.err for name in ("one.off", "two.off"))
    assert content(tmp_path / "0.json") == content(tmp_path / "1.json") == content(tmp_path / "2.json")
    assert "prepared before" not in mobius("match", *pair[:2], *QUICK).err
    sizes = [path.stat().st_size for path in cache_folder.iterdir()]
    assert cache() == {"folder": str(cache_folder), "surfaces": 2, "bytes": sum(sizes), "limit": 2_000_000_000}
    ended = mobius("cache")
    assert ended.out == f"{cache_folder}: 2 prepared surfaces, {sum(sizes) / 1e6:.1f} of 2000 MB\n"
    assert mobius("prepare", pair[0], "-o", tmp_path, "--samples", 30, "--quiet").code == 0
    assert cache()["surfaces"] == 2
    assert cache("--clear")["surfaces"] == 0
    assert list(cache_folder.iterdir()) == []


def test_a_damaged_file_of_the_cache_is_reported_if_verbose(mobius, pair, cache_folder, tmp_path):
    for options in (["-v"], []):
        shutil.rmtree(cache_folder, ignore_errors=True)
        mobius("match", *pair[:2], *QUICK)
        for path in cache_folder.iterdir():
            path.write_bytes(path.read_bytes()[:1000])
        ended = mobius("match", *pair[:2], *QUICK, "-o", tmp_path / "result.json", *options)
        assert ended.code == 0
        assert ("one.off: prepared anew, the cache is of no use" in ended.err) == ("-v" in options)
        assert all(path.stat().st_size > 1000 for path in cache_folder.iterdir())
