"""The cache: what it returns is what would have been computed, whatever happened to its files."""

import json
import logging
import os
import shutil
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import trimesh

import mobius_match as mm
from mobius_match.errors import SettingsError
from mobius_match.evaluation import examples
from mobius_match.surface import cache, storage
from mobius_match.surface import prepare as preparing
from mobius_match.surface.parameters import SurfaceParameters
from tests.shapes import lump, renumbered

QUICK = {"samples": 30, "votes": 2000}


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Files of a shape and of the same renumbered."""
    folder, paths = tmp_path_factory.mktemp("meshes"), []
    for name, (vertices, faces) in (("one", lump(3)), ("two", renumbered(lump(3))[0])):
        paths.append(folder / f"{name}.off")
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        paths[-1].write_bytes(mesh.export(file_type="off", digits=17).encode())
    return paths


@pytest.fixture
def prepared(monkeypatch):
    """Names of the meshes that were prepared, not taken from the cache."""
    names, real = [], preparing.prepare_mesh

    def counting(mesh, *arguments):
        names.append(mesh.name)
        return real(mesh, *arguments)

    monkeypatch.setattr(preparing, "prepare_mesh", counting)
    return names


def arrays(surface):
    """All that a surface is, as bytes, but for the seconds that it took and the name of its file."""
    values = {f"{type(record).__name__}.{f.name}": getattr(record, f.name)
              for record in (surface, surface.mesh) for f in fields(record)}  # fmt: skip
    for name in ("Surface.mesh", "Surface.timings", "Mesh.path", "Mesh.name"):
        del values[name]
    return {
        name: (value.dtype.str, value.strides, value.tobytes()) if isinstance(value, np.ndarray) else repr(value)
        for name, value in values.items()
    }


def test_results_are_the_same_to_the_last_byte_with_and_without_the_cache(meshes, prepared):
    without, first, second = (mm.match(*meshes, **QUICK, cache=cached) for cached in (False, True, True))
    assert prepared == 2 * ["one.off", "two.off"]
    for result in (first, second):
        for side in ("source", "target"):
            assert arrays(getattr(result, side)) == arrays(getattr(without, side))
    texts = [json.dumps(result.to_dict(alternatives=True) | {"timings": None}) for result in (without, first, second)]
    assert texts[0] == texts[1] == texts[2]
    assert "source sampling" in first.timings
    assert "source sampling" not in second.timings


def test_a_symmetry_is_the_same_with_and_without_the_cache(prepared):
    path = examples.paths("person")[0]
    without, first, second = (mm.symmetry(path, **QUICK, cache=cached) for cached in (False, True, True))
    assert len(prepared) == 2
    assert without.to_dict() | {"timings": 0} == second.to_dict() | {"timings": 0} == first.to_dict() | {"timings": 0}


def test_the_library_stores_nothing_unless_asked(meshes, cache_folder):
    mm.prepare(meshes[0], samples=10)
    assert not cache_folder.exists()


def test_the_path_is_the_one_given_now(meshes, prepared, tmp_path):
    other = Path(shutil.copy(meshes[0], tmp_path / "other.off"))
    surfaces = [mm.prepare(path, samples=10, cache=True) for path in (meshes[0], other, str(other))]
    assert prepared == ["one.off"]
    assert [surface.mesh.path for surface in surfaces] == [meshes[0], other, other]
    assert [surface.mesh.name for surface in surfaces] == ["one.off", "other.off", "other.off"]


def test_the_file_name_depends_on_all_that_the_surface_depends_on(monkeypatch):
    def name(mesh="a.off", sha256="0" * 64, parameters=SurfaceParameters(), **settings):
        return cache._path(Path(mesh), sha256, mm.PrepareSettings(**settings), parameters).name

    assert name() == name("b/other.OFF")
    names = [name(), name("a.stl"), name(sha256="1" * 64), name(samples=99), name(geodesics="dijkstra")]
    names += [name(triangulation="mesh"), name(placement="closest"), name(parameters=SurfaceParameters(proxy_size=9))]
    program = cache._program()
    monkeypatch.setattr(cache, "_program", lambda: program[::-1])
    names.append(name())
    assert len(set(names)) == len(names)


def test_the_program_is_identified_by_its_libraries_and_its_source(monkeypatch, tmp_path):
    digest = cache._program.__wrapped__
    programs = [cache._program(), digest()]
    assert programs[0] == programs[1]
    with monkeypatch.context() as patch:
        patch.setattr(cache, "software", lambda: {"numpy": "0"})
        programs.append(digest())
    (tmp_path / "surface.py").write_text("x = 1")
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "cache.py"))
    programs.append(digest())
    (tmp_path / "surface.py").write_text("x = 2")
    programs.append(digest())
    assert len(set(programs)) == 4


@pytest.mark.parametrize("what", ["settings", "content", "program", "layout"])
def test_after_any_change_the_surface_is_prepared_again(meshes, prepared, tmp_path, monkeypatch, what):
    path, samples = Path(shutil.copy(meshes[0], tmp_path / "mesh.off")), 10
    mm.prepare(path, samples=samples, cache=True)
    if what == "settings":
        samples = 11
    elif what == "content":
        path.write_bytes(path.read_bytes() + b"\n")
    elif what == "program":
        monkeypatch.setattr(cache, "_program", lambda: "another")
    else:
        monkeypatch.setattr(storage, "VERSION", storage.VERSION + 1)
    for _ in range(2):
        assert mm.prepare(path, samples=samples, cache=True).settings.samples == samples
        assert len(prepared) == 2


def test_a_mesh_that_changes_while_it_is_read_is_stored_under_its_own_hash(meshes, monkeypatch, tmp_path):
    path = Path(shutil.copy(meshes[0], tmp_path / "mesh.off"))
    real = preparing.matchable_mesh

    def overtaken(*given):
        shutil.copy(meshes[1], path)
        return real(*given)

    monkeypatch.setattr(preparing, "matchable_mesh", overtaken)
    first = mm.prepare(path, samples=10, cache=True)
    shutil.copy(meshes[0], path)
    assert cache.load_cached(path, first.settings) is None
    assert arrays(cache.load_cached(meshes[1], first.settings)) == arrays(mm.prepare(meshes[1], samples=10))


def only(folder):
    (path,) = folder.iterdir()
    return path


def test_damaged_and_foreign_files_are_detected_and_replaced(meshes, prepared, cache_folder, caplog):
    caplog.set_level(logging.INFO, "mobius_match")
    good = arrays(mm.prepare(meshes[0], samples=10, cache=True))
    path = only(cache_folder)
    whole = path.read_bytes()
    mm.prepare(meshes[0], samples=11).save(path)
    foreign = path.read_bytes()
    wrong = (b"", whole[: len(whole) // 2], whole[:-1], b"PK" + whole[5:], foreign, b"no archive at all")
    for number, content in enumerate(wrong, start=2):
        path.write_bytes(content)
        caplog.clear()
        assert arrays(mm.prepare(meshes[0], samples=10, cache=True)) == good
        assert "one.off: prepared anew" in caplog.text
        assert prepared.count("one.off") == number + 1
        assert only(cache_folder) == path
        assert mm.Surface.load(path).settings.samples == 10


def test_every_flipped_bit_is_detected_or_harmless(meshes, cache_folder):
    surface = mm.prepare(meshes[0], samples=10, cache=True)
    path, good = only(cache_folder), arrays(surface)
    whole = path.read_bytes()
    generator = np.random.default_rng(0)
    # Headers of the members, their index, and anywhere.
    places = [*range(200), *range(len(whole) - 300, len(whole)), *generator.integers(len(whole), size=200)]
    headers = [k + d for k in range(len(whole)) if whole.startswith(b"\x93NUMPY", k) for d in (8, 20, 22, 60, 65, 66)]
    noticed = 0
    for place in places + headers:
        flipped = bytearray(whole)
        flipped[place] ^= 1 << int(generator.integers(8))
        path.write_bytes(flipped)
        found = cache.load_cached(meshes[0], surface.settings)
        assert found is None or arrays(found) == good, place
        noticed += found is None
    assert noticed > len(places) / 2


def test_the_least_recently_used_file_is_removed_first(meshes, prepared, cache_folder, monkeypatch):
    paths = {}
    for age, samples in enumerate((10, 11, 12, 13)):
        before = set(cache_folder.glob("*"))
        mm.prepare(meshes[0], samples=samples, cache=True)
        (paths[samples],) = set(cache_folder.glob("*")) - before
        os.utime(paths[samples], (1000 + age, 1000 + age))
    size = max(path.stat().st_size for path in paths.values())
    (cache_folder / "notes.txt").write_text("not of the cache" * 10**6)
    mm.prepare(meshes[0], samples=10, cache=True)  # used again
    monkeypatch.setattr(cache, "cache_limit", lambda: 3 * size + 100)
    mm.prepare(meshes[1], samples=10, cache=True)
    assert [samples for samples, path in paths.items() if path.exists()] == [10, 13]
    monkeypatch.setattr(cache, "cache_limit", lambda: 10)
    mm.prepare(meshes[1], samples=11, cache=True)
    assert [path.name for path in cache_folder.iterdir()] == ["notes.txt"]


@pytest.mark.skipif(os.name != "posix", reason="there are no such permissions")
def test_the_cache_is_private(meshes, cache_folder):
    mm.prepare(meshes[0], samples=10, cache=True)
    assert cache_folder.stat().st_mode & 0o777 == 0o700


def test_clearing_removes_files_of_the_cache_only(meshes, cache_folder):
    mm.prepare(meshes[0], samples=10, cache=True)
    path = only(cache_folder)
    path.with_name(f".{path.name}.abc123").write_bytes(b"left by a killed process")
    others = {"mine.npz", "a" * 64, f"{'g' * 64}.npz"}
    for name in others:
        (cache_folder / name).write_bytes(b"")
    cache.clear_cache()
    assert {path.name for path in cache_folder.iterdir()} == others


def test_concurrent_use_is_safe(meshes, monkeypatch, cache_folder):
    surfaces = [mm.prepare(meshes[0], samples=samples) for samples in (10, 11)]
    good = [arrays(surface) for surface in surfaces]
    monkeypatch.setattr(cache, "cache_limit", lambda: 300_000)
    hits, stop = [0, 0], threading.Event()

    def work(number):
        while not stop.is_set():
            surface = surfaces[number % 2]
            found = cache.load_cached(meshes[0], surface.settings)
            assert found is None or arrays(found) == good[number % 2]
            hits[number % 2] += found is not None
            cache.store(meshes[0], surface)
            if number == 0:
                cache.clear_cache()

    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(work, number) for number in range(4)]
        stop.wait(1.5)
        stop.set()
        for job in jobs:
            job.result()
    assert min(hits) > 0
    assert not [path for path in cache_folder.iterdir() if path.name.startswith(".")]


def test_a_folder_that_cannot_be_written_is_no_error(meshes, monkeypatch, tmp_path, caplog):
    caplog.set_level(logging.INFO, "mobius_match")
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MOBIUS_CACHE_DIR", str(tmp_path / "file"))
    assert len(mm.prepare(meshes[0], samples=10, cache=True).samples) == 10
    assert "one.off: not kept in the cache" in caplog.text
    assert list(cache.cached_files(cache.cache_folder())) == []


def test_files_that_refer_to_others_are_not_cached(meshes, cache_folder, tmp_path):
    for name in ("mesh.glb", "mesh.gltf"):
        trimesh.load_mesh(meshes[0]).export(tmp_path / name)
        mm.prepare(tmp_path / name, samples=10, cache=True)
    assert not cache_folder.exists()


def test_an_unreadable_mesh_is_the_usual_error(tmp_path):
    with pytest.raises(mm.FormatError, match="no such file"):
        mm.prepare(tmp_path / "none.off", cache=True)
    with pytest.raises(mm.FormatError, match="is a folder"):
        mm.prepare(tmp_path, cache=True)


def test_the_folder_of_each_system(monkeypatch, tmp_path):
    assert cache.cache_folder() == Path(os.environ["MOBIUS_CACHE_DIR"])
    monkeypatch.delenv("MOBIUS_CACHE_DIR")
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for system, place in (("linux", ".cache"), ("darwin", "Library/Caches"), ("win32", "AppData/Local")):
        monkeypatch.setattr(cache.sys, "platform", system)
        assert cache.cache_folder() == tmp_path / place / "mobius-match"
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert cache.cache_folder() == tmp_path / "local" / "mobius-match"
    monkeypatch.setattr(cache.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache.cache_folder() == tmp_path / "xdg" / "mobius-match"


def test_without_a_home_there_is_no_cache(meshes, prepared, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    for name in ("MOBIUS_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.raises(SettingsError, match="MOBIUS_CACHE_DIR"):
        cache.cache_folder()
    mm.prepare(meshes[0], samples=10, cache=True)
    assert prepared == ["one.off"]


@pytest.mark.parametrize("given", ["-1", "2 GB", "1.5"])
def test_a_wrong_size_is_refused_before_any_work(meshes, prepared, monkeypatch, given):
    monkeypatch.setenv("MOBIUS_CACHE_MB", given)
    with pytest.raises(SettingsError, match=f"MOBIUS_CACHE_MB is '{given}'"):
        mm.prepare(meshes[0], cache=True)
    assert prepared == []
    monkeypatch.setenv("MOBIUS_CACHE_MB", "5")
    assert cache.cache_limit() == 5_000_000
