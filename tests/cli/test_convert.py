"""`mobius convert` and `mobius landmarks`: what they write and say, and how they end."""

import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.exporting import FORMATS, export
from mobius_match.landmarks.tables import Landmarks
from mobius_match.results.surface_map import SurfaceMap


@pytest.fixture(scope="module")
def given(saved_map, tmp_path_factory):
    """A folder with a result of the meshes of ``saved_map``, written as it would be, and their map."""
    folder, surface_map, number, *_ = saved_map
    some = np.flatnonzero(surface_map.source_mapped)[:20]
    infos = [
        {"path": str(folder / name), "sha256": mm.read_mesh(folder / name).sha256, "vertices": 642, "faces": 1280}
        for name in ("one.ply", "two.ply")
    ]
    matches = np.column_stack([some, number[some]]), np.linspace(0.9, 0.5, 20), np.full(20, "voted")
    out = tmp_path_factory.mktemp("given")
    mm.Correspondence(*matches, *infos, {}).save(out / "result.json")
    surface_map.save(out / "map.npz")
    return out


@pytest.mark.parametrize("name", FORMATS)
def test_convert_writes_what_the_function_does(mobius, given, tmp_path, name):
    ending = FORMATS[name].endings[0]
    ended = mobius("convert", given / "result.json", tmp_path / f"a{ending}", "--dense", given / "map.npz")
    assert (ended.code, ended.out) == (0, ""), ended.err
    (tmp_path / "b").mkdir()
    result, dense = mm.Correspondence.load(given / "result.json"), SurfaceMap.load(given / "map.npz")
    paths = result.export(tmp_path / "b" / f"a{ending}", dense=dense)
    assert ended.err == f"written: {', '.join(str(tmp_path / path.name) for path in paths)}\n"
    for path in paths:
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_options_of_convert(mobius, given, tmp_path):
    options = ("--format", "slicer", "--side", "target", "--min-confidence", "0.7", "--coordinate-system", "RAS", "-q")
    ended = mobius("convert", given / "result.json", tmp_path / "points", *options)
    assert ended == (0, "", "")
    (markup,) = json.loads((tmp_path / "points").read_text())["markups"]
    assert markup["coordinateSystem"] == "RAS"
    result = mm.Correspondence.load(given / "result.json")
    wanted = mm.read_mesh(result.target_info["path"]).vertices[result.pairs[result.confidence >= 0.7, 1]]
    assert [point["position"] for point in markup["controlPoints"]] == wanted.tolist()


def test_a_map_alone_is_converted(mobius, given, tmp_path):
    assert mobius("convert", given / "map.npz", tmp_path / "map.txt").code == 0
    export(SurfaceMap.load(given / "map.npz"), tmp_path / "same.txt")
    assert (tmp_path / "map.txt").read_bytes() == (tmp_path / "same.txt").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("result.json", "out.stl"), 2, "unknown ending; known are .csv, .mrk.json"),
        (("result.json", "out.csv", "--format", "xls"), 2, "--format is 'xls'; choose one of csv, slicer"),
        (("result.json", "-", "--format", "csv"), 2, "OUT cannot be standard output"),
        (("result.json", "result.json", "--side", "source"), 2, "is one of the inputs"),
        (("result.json", "nowhere/out.pts"), 2, "does not exist"),
        (("result.json", "out.csv", "--min-confidence", "0.95"), 4, "the highest is 0.900"),
        (("result.json", "out.txt"), 2, "this format holds a dense map; give one as --dense"),
        (("map.npz", "out.tps"), 2, "this format holds matches, and RESULT is a dense map"),
        (("broken.json", "out.tps"), 3, "not a readable result file"),
        (("absent.json", "out.tps"), 3, "not a readable result file"),
    ],
)
def test_errors_of_convert(mobius, given, tmp_path, monkeypatch, arguments, code, message):
    for name in ("result.json", "map.npz"):
        (tmp_path / name).write_bytes((given / name).read_bytes())
    (tmp_path / "broken.json").write_text("{")
    monkeypatch.chdir(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    ended = mobius("convert", *arguments)
    assert (ended.code, ended.out) == (code, ""), ended.err
    assert message in ended.err
    assert len(ended.err.splitlines()) == 1
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("start", [name for name, form in FORMATS.items() if form.write_landmarks])
@pytest.mark.parametrize("end", [name for name, form in FORMATS.items() if form.write_landmarks])
def test_landmarks_in_any_format_to_any_other_and_back(mobius, given, saved_map, tmp_path, start, end):
    """The map takes vertex to vertex: places come out as they are in the other file, to the last digit."""
    _, surface_map, number, lost, _ = saved_map
    some = np.flatnonzero(surface_map.source_mapped)[3:8]
    gone = np.argsort(number)[lost][:1]
    source, target = surface_map.source.vertices, surface_map.target.vertices
    endings = FORMATS[start].endings[0], FORMATS[end].endings[0]
    marks = Landmarks(["nose", "tail", "a", "b", "c", "lost"], None, source[[*some, *gone]], "one")
    (tmp_path / f"on-one{endings[0]}").write_bytes(FORMATS[start].write_landmarks([marks], "", "LPS"))
    ended = mobius(
        "landmarks", tmp_path / f"on-one{endings[0]}", given / "map.npz", "-o", tmp_path / f"on-two{endings[1]}"
    )
    assert (ended.code, ended.out) == (0, ""), ended.err
    nameless = "morphologika" in (start, end)
    left_out = "6" if start == "morphologika" else "lost"
    assert ended.err.splitlines()[-2:] == [
        f"left out, without counterpart: {left_out}",
        f"5 landmarks on two.ply written to {tmp_path / f'on-two{endings[1]}'}",
    ]
    found = mm.read_landmarks(tmp_path / f"on-two{endings[1]}")
    assert found.points.tobytes() == target[number[some]].tobytes()
    assert found.names == (["1", "2", "3", "4", "5"] if nameless else ["nose", "tail", "a", "b", "c"])
    back = tmp_path / f"back{endings[0]}"
    ended = mobius("landmarks", tmp_path / f"on-two{endings[1]}", given / "map.npz", "--back", "-q", "-o", back)
    assert ended == (0, "", "")
    assert mm.read_landmarks(back).points.tobytes() == source[some].tobytes()


def test_landmarks_off_the_surface_or_missing_are_reported(mobius, given, saved_map, tmp_path):
    _, surface_map, *_ = saved_map
    some = np.flatnonzero(surface_map.source_mapped)[:3]
    places = surface_map.source.vertices[some].copy()
    places[1] *= 1.5
    rows = [" ".join(map(repr, row)) for row in places.tolist()]
    (tmp_path / "a.pts").write_text("\n".join(["Version 1.0", "4", f"p {rows[0]}", f"q {rows[1]}", f"r {rows[2]}"]))
    with (tmp_path / "a.pts").open("a") as file:
        file.write("\ns 9999 9999 9999\n")
    ended = mobius("landmarks", tmp_path / "a.pts", given / "map.npz", "-o", tmp_path / "b.fcsv")
    assert ended.code == 0
    first, second, _ = ended.err.splitlines()
    assert first == "left out, missing in the file: s"
    assert second.startswith("1 of 3 landmarks lie up to ")
    assert "units off the surface of one.ply (q): check that they belong to this mesh" in second
    assert mm.read_landmarks(tmp_path / "b.fcsv").names == ["p", "q", "r"]


def test_a_file_in_the_other_system_is_converted(mobius, given, saved_map, tmp_path):
    _, surface_map, *_ = saved_map
    some = np.flatnonzero(surface_map.source_mapped)[:4]
    marks = Landmarks(list("abcd"), None, surface_map.source.vertices[some] * [-1, -1, 1])
    (tmp_path / "a.fcsv").write_bytes(FORMATS["fcsv"].write_landmarks([marks], "", "RAS"))
    for options, sign in (((), 1), (("--coordinate-system", "RAS"), None)):
        ended = mobius("landmarks", tmp_path / "a.fcsv", given / "map.npz", "-o", tmp_path / "b.fcsv", *options)
        assert ended.code == 0
        assert ("off the surface of one.ply" in ended.err) == (sign is None)
    assert "CoordinateSystem = RAS" in (tmp_path / "b.fcsv").read_text()


def test_landmarks_by_vertex_and_of_a_match_that_is_made_again(mobius, pair, tmp_path):
    one, two, number = pair
    result = tmp_path / "result.json"
    assert mobius("match", one, two, "--samples", 60, "--votes", 6000, "-o", result).code == 0
    (tmp_path / "v.csv").write_text("name,vertex\nnose,7\n")
    ended = mobius("landmarks", tmp_path / "v.csv", result, "-o", tmp_path / "b.csv")
    assert ended.code == 0, ended.err
    marks = mm.read_landmarks(tmp_path / "b.csv")
    assert (marks.names, marks.vertices.tolist()) == (["nose"], [number[7]])


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("a.csv", "-o", "b.stl"), 2, "unknown ending"),
        (("a.csv", "-o", "b.mat"), 2, "landmarks are written as .csv, .mrk.json"),
        (("a.csv", "-o", "a.csv"), 2, "is one of the inputs"),
        (("two.tps", "-o", "b.csv"), 2, "holds 2 specimens"),
        (("two.tps", "-o", "b.csv", "--specimen", "7"), 2, "no specimen matches --specimen '7'; there are"),
        (("bad.tps", "-o", "b.csv"), 3, "bad.tps, line 1: LM3=4 of line 1 is followed by only 0 rows"),
        (("a.csv", "-o", "b.csv", "--coordinate-system", "up"), 2, "--coordinate-system is 'up'; choose one"),
        (("far.csv", "-o", "b.csv"), 2, "one.ply has no vertex 9999"),
        (("lost.csv", "-o", "b.csv"), 4, "lost.csv: none of its landmarks has a counterpart on two.ply"),
    ],
)
def test_errors_of_landmarks(mobius, given, saved_map, tmp_path, monkeypatch, arguments, code, message):
    _, _, number, lost, _ = saved_map
    texts = {
        "a.csv": "x,y,z\n0,0,1\n",
        "two.tps": "LM3=1\n0 0 1\nLM3=1\n0 0 1\n",
        "bad.tps": "LM3=4\n",
        "far.csv": "vertex\n9999\n",
        "lost.csv": f"vertex\n{np.argsort(number)[lost][0]}\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "map.npz").write_bytes((given / "map.npz").read_bytes())
    monkeypatch.chdir(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    ended = mobius("landmarks", arguments[0], "map.npz", *arguments[1:])
    assert (ended.code, ended.out) == (code, ""), ended.err
    assert message in ended.err.splitlines()[-1]
    assert {path.name for path in tmp_path.iterdir()} == before
