"""`mobius transfer`: what it reads, writes and says, and how it ends."""

import io
import json

import numpy as np
import pytest
import trimesh
from PIL import Image

import mobius_match as mm
from mobius_match.mesh.appearance import read_appearance


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "npz", "csv", "txt"])
def test_colours(mobius, saved_map, kind, tmp_path):
    folder, surface_map, number, lost, given = saved_map
    out = tmp_path / f"out.{kind}"
    ended = mobius("transfer", folder / "map.npz", "--what", "colors", "-o", out)
    assert (ended.code, ended.out) == (0, ""), ended.err
    assert f"{lost.sum()} vertices have no counterpart: grey" in ended.err
    wanted = given["colors"][np.argsort(number)]
    wanted[lost] = [204, 207, 212, 255]
    if kind == "obj":
        wanted[:, 3] = 255
    if kind == "npz":
        found = np.load(out)["colors"]
    elif kind in ("csv", "txt"):
        found = np.loadtxt(out, delimiter=",", dtype=int)
    else:
        mesh = read_appearance(out)
        np.testing.assert_array_equal(mesh.mesh.faces, surface_map.target.faces)
        np.testing.assert_array_equal(mesh.mesh.vertices, surface_map.target.vertices)
        found = mesh.colors
    np.testing.assert_array_equal(found, wanted)
    assert [out] == list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["ply", "obj", "glb"])
def test_textures(mobius, saved_map, kind, tmp_path):
    folder, surface_map, _, lost, given = saved_map
    ended = mobius("transfer", folder / "map.npz", "--what", "uv", "-o", tmp_path / f"out.{kind}")
    assert ended.code == 0, ended.err
    found = read_appearance(tmp_path / f"out.{kind}")
    target = surface_map.target
    there = ~lost[target.faces].any(axis=1)
    np.testing.assert_allclose(found.uv[there], (target.vertices[:, :2] / 10 + 0.5)[target.faces][there], atol=1e-6)
    assert f"{(~there).sum()} faces have no counterpart: without texture" in ended.err
    pictures = [np.asarray(Image.open(io.BytesIO(one)).convert("RGB")) for one in (found.image, given["image"])]
    np.testing.assert_array_equal(*pictures)
    beside = {"ply": {"out.png"}, "obj": {"out.png", "out.mtl"}, "glb": set()}[kind]
    assert {path.name for path in tmp_path.iterdir()} == {f"out.{kind}", *beside}


def test_several_things_at_once_and_back(mobius, saved_map, tmp_path):
    folder, surface_map, number, lost, given = saved_map
    height = surface_map.source.vertices[:, 2]
    np.savez(tmp_path / "given.npz", height=height, part=np.arange(len(height)))
    what = ("--what", "labels", "--what", "colors", "--what", tmp_path / "given.npz")
    assert mobius("transfer", folder / "map.npz", *what, "-o", tmp_path / "there.ply").code == 0
    found = read_appearance(tmp_path / "there.ply")
    lost_faces = lost[surface_map.target.faces].any(axis=1)
    np.testing.assert_array_equal(found.labels, np.where(lost_faces, -1, given["labels"]))
    rows = trimesh.load(tmp_path / "there.ply", process=False).metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(rows["height"], np.where(lost, np.nan, surface_map.target.vertices[:, 2]))
    np.testing.assert_array_equal(rows["part"], np.where(lost, -1, np.argsort(number)))
    # And back, from a file that is not the map's own.
    options = ("--what", "labels", "--back", "--from", tmp_path / "there.ply", "-o", tmp_path / "back.npz")
    assert mobius("transfer", folder / "map.npz", *options).code == 0
    np.testing.assert_array_equal(np.load(tmp_path / "back.npz")["labels"], np.where(lost_faces, -1, given["labels"]))


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "npz"])
def test_positions(mobius, saved_map, kind, tmp_path):
    folder, surface_map, _, lost, _ = saved_map
    ended = mobius("transfer", folder / "map.npz", "--what", "positions", "-o", tmp_path / f"out.{kind}")
    assert ended.code == 0, ended.err
    assert f"{lost.sum()} vertices have no counterpart" in ended.err
    gone = ~surface_map.source_mapped
    if kind == "npz":
        found = np.load(tmp_path / "out.npz")
        np.testing.assert_array_equal(found["faces"], surface_map.source.faces)
        np.testing.assert_array_equal(np.isnan(found["positions"]).all(axis=1), gone)
        places = found["positions"]
    else:
        mesh = mm.read_mesh(tmp_path / f"out.{kind}")
        kept_faces = surface_map.source.faces[~gone[surface_map.source.faces].any(axis=1)]
        np.testing.assert_array_equal(mesh.faces, kept_faces)
        places = mesh.vertices
    np.testing.assert_allclose(places[~gone], surface_map.source.vertices[~gone], atol=1e-6)


def test_landmarks_and_curves(mobius, saved_map, tmp_path):
    folder, surface_map, number, lost, _ = saved_map
    source = surface_map.source
    some = np.flatnonzero(surface_map.source_mapped)[:5]
    marks = tmp_path / "marks.csv"
    marks.write_text(
        "name,vertex\n" + "".join(f"n{k},{i}\n" for k, i in enumerate([*some, np.argsort(number)[lost][0]]))
    )
    out = tmp_path / "out.csv"
    ended = mobius("transfer", folder / "map.npz", "--what", marks, "-o", out)
    assert ended.code == 0, ended.err
    assert "1 points have no counterpart: NaN and vertex -1" in ended.err
    head, *rows = [line.split(",") for line in out.read_text().splitlines()]
    assert head == ["name", "vertex", "x", "y", "z"]
    assert [row[:2] for row in rows] == [[f"n{k}", str(i)] for k, i in enumerate([*number[some], -1])]
    np.testing.assert_array_equal([list(map(float, row[2:])) for row in rows[:5]], source.vertices[some])
    assert rows[5][2:] == ["nan"] * 3
    # What was written is read again; here as places, a little off the surface.
    raised = source.vertices[some] * 1.01
    marks.write_text("x;y;z\n" + "".join(f"{x!r};{y!r};{z!r}\n" for x, y, z in raised.tolist()))
    ended = mobius("transfer", folder / "map.npz", "--what", marks, "-o", "-")
    assert ended.code == 0, ended.err
    assert "5 points moved onto the surface of one.ply, by 0.0" in ended.err
    assert ended.out.splitlines()[0] == "vertex,x,y,z"
    np.savetxt(tmp_path / "plain.txt", some, "%d")
    ended = mobius("transfer", folder / "map.npz", "--what", tmp_path / "plain.txt", "-o", tmp_path / "out.npz")
    assert "5 rows without headings, read as landmarks" in ended.err
    np.testing.assert_array_equal(np.load(tmp_path / "out.npz")["vertices"], number[some])


def test_a_result_is_matched_again(mobius, pair, tmp_path):
    one, two, number = pair
    result = tmp_path / "result.json"
    assert mobius("match", one, two, "--samples", 60, "--votes", 6000, "-o", result).code == 0
    np.savetxt(tmp_path / "v.csv", np.arange(642), "%d")
    ended = mobius("transfer", result, "--what", tmp_path / "v.csv", "-o", tmp_path / "out.txt")
    assert ended.code == 0, ended.err
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "out.txt", dtype=int), np.argsort(number))
    changed = json.loads(result.read_text())
    changed["target"]["sha256"] = "0" * 64
    result.write_text(json.dumps(changed))
    ended = mobius("transfer", result, "--what", tmp_path / "v.csv", "-o", tmp_path / "other.txt")
    assert (ended.code, ended.out) == (3, "")
    assert "two.off: the file has changed since the match" in ended.err
    assert not (tmp_path / "other.txt").exists()


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (
            ("--what", "colours", "-o", "out.ply"),
            2,
            "colours is neither a file nor one of colors, uv, labels, positions",
        ),
        (("--what", "colors", "-o", "out.stl"), 2, "must end in one of .ply"),
        (("--what", "colors", "-o", "nowhere/out.ply"), 2, "does not exist"),
        (("--what", "colors", "-o", "map.npz"), 2, "is one of the inputs"),
        (("--what", "labels", "-o", "out.obj"), 2, "labels and values can be written to .ply"),
        (("--what", "colors", "--what", "labels", "-o", "out.csv"), 2, "can hold one attribute only"),
        (("--what", "positions", "--what", "colors", "-o", "out.ply"), 2, "run the command once for each"),
        (("--what", "marks.csv", "-o", "out.ply"), 2, "landmarks are written as .csv"),
        (("--what", "colors", "--back", "-o", "out.ply"), 3, "two.ply: has no colours"),
        (("--what", "labels", "--back", "-o", "out.ply"), 3, "two.ply: has no labels"),
        (
            ("--what", "colors", "--from", "other.off", "-o", "out.ply"),
            3,
            "its vertices or faces differ from those of one.ply",
        ),
        (("--what", "far.csv", "-o", "out.csv"), 2, "has no vertex 9999"),
        (("--what", "short.csv", "-o", "out.csv"), 3, "has 642 vertices and 1280 faces"),
        (("--what", "words.csv", "-o", "out.csv"), 3, "words.csv: line 2: 'b' is not a number"),
        (("--what", "ragged.csv", "-o", "out.csv"), 3, "ragged.csv: line 2 has 1 columns"),
        (("--what", "empty.csv", "-o", "out.csv"), 3, "the file is empty"),
        (("--what", "broken.npz", "-o", "out.csv"), 3, "broken.npz: cannot be read"),
    ],
)
def test_errors(mobius, saved_map, tmp_path, monkeypatch, options, code, message):
    texts = {
        "marks.csv": "vertex\n3\n",
        "far.csv": "vertex\n9999\n",
        "short.csv": "1,2\n3,4\n",
        "words.csv": "vertex\nb\n",
        "ragged.csv": "1,2\n3\n",
        "empty.csv": "\n",
        "broken.npz": "PK",
        "other.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "map.npz").write_bytes((saved_map[0] / "map.npz").read_bytes())
    monkeypatch.chdir(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    ended = mobius("transfer", "map.npz", *options)
    assert (ended.code, ended.out) == (code, ""), ended.err
    assert message in ended.err
    assert len(ended.err.splitlines()) == 1
    assert {path.name for path in tmp_path.iterdir()} == before


def test_a_file_that_is_no_map(mobius, tmp_path):
    (tmp_path / "map.npz").write_bytes(b"nothing")
    ended = mobius("transfer", tmp_path / "map.npz", "--what", "colors", "-o", tmp_path / "out.ply")
    assert ended.code == 3
    assert "not a readable map" in ended.err
