"""A match in every format, read by an independent reader or by the published grammar of the format."""

import csv
import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import scipy.io
import trimesh

import mobius_match as mm
from mobius_match.exporting import export

SIDES = ("source", "target")

# Types by the published schema (markups-schema-v1.0.3.json).
OPTIONAL = {
    "id": str,
    "label": str,
    "description": str,
    "selected": bool,
    "locked": bool,
    "visibility": bool,
}


def names_of(result):
    return [info["path"].rsplit("/", 1)[-1] for info in (result.source_info, result.target_info)]


def equal(found, wanted):
    """The same numbers, to the last digit."""
    found = np.array(found, np.float64)
    assert found.shape == wanted.shape
    assert found.tobytes() == np.ascontiguousarray(wanted).tobytes()


def test_csv(result, places, tmp_path):
    assert result.export(tmp_path / "out.csv") == [tmp_path / "out.csv"]
    with (tmp_path / "out.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [[int(row[side]) for side in SIDES] for row in rows] == result.pairs.tolist()
    assert [float(row["confidence"]) for row in rows] == result.confidence.tolist()
    assert [row["kind"] for row in rows] == result.kind.tolist()
    assert {row["index_base"] for row in rows} == {"0"}
    assert [row["name"] for row in rows] == [str(i) for i in range(1, len(result) + 1)]
    for side, wanted in zip(SIDES, places, strict=True):
        equal([[row[f"{side}_{axis}"] for axis in "xyz"] for row in rows], wanted)
    there = result.target_points
    assert [int(row["target_face"]) for row in rows] == there.faces.tolist()
    assert [[int(row[f"target_corner_{k}"]) for k in range(3)] for row in rows] == there.corners.tolist()
    equal([[row[f"target_weight_{k}"] for k in range(3)] for row in rows], there.barycentric)


@pytest.mark.parametrize("system", ["LPS", "RAS"])
def test_slicer_markups_keep_to_their_schema(result, places, tmp_path, system):
    written = result.export(tmp_path / "out.mrk.json", coordinate_system=system)
    assert written == [tmp_path / f"out-{side}.mrk.json" for side in SIDES]
    for path, name, numbers, wanted in zip(written, names_of(result), result.pairs.T, places, strict=True):
        content = json.loads(path.read_text(encoding="utf-8"))
        assert re.fullmatch(r"https://\S+/markups-schema-v1\.0\.3\.json#", content["@schema"])
        assert "source -> target" in content["description"]
        (markup,) = content["markups"]
        assert (markup["type"], markup["coordinateSystem"], markup["name"]) == ("Fiducial", system, name)
        for number, point in enumerate(markup["controlPoints"]):
            assert {key: type(point[key]) for key in OPTIONAL} == OPTIONAL
            assert point["positionStatus"] == "defined"
            assert point["label"] == str(number + 1)
            assert point["description"] == f"vertex {numbers[number]}, counting from 0"
            assert all(type(x) is float for x in point["position"])
        equal([point["position"] for point in markup["controlPoints"]], wanted)


@pytest.mark.parametrize("system", ["LPS", "RAS"])
def test_fcsv(result, places, tmp_path, system):
    for path, wanted in zip(result.export(tmp_path / "o.fcsv", coordinate_system=system), places, strict=True):
        # As geomorph's and SlicerMorph's readers do: two lines are skipped, the third has the headings.
        lines = path.read_text().splitlines()
        assert lines[0].startswith("# Markups fiducial file version = ")
        assert lines[1] == f"# CoordinateSystem = {system}"
        assert not any(line.startswith("#") for line in lines[3:])
        heads = lines[2].removeprefix("# columns = ").split(",")
        rows = [dict(zip(heads, cells, strict=True)) for cells in csv.reader(lines[3:])]
        equal([[row[axis] for axis in "xyz"] for row in rows], wanted)
        assert [row["label"] for row in rows] == [str(i) for i in range(1, len(rows) + 1)]
        assert all("source -> target" in row["desc"] and "counting from 0" in row["desc"] for row in rows)


def tps_by_the_grammar(text):
    """As geomorph's readland.tps reads: comments go, LM3= says how many, what has no "=" are coordinates."""
    lines = [line for line in text.split("\n") if line and "COMMENT=" not in line]
    sizes = [int(line.removeprefix("LM3=")) for line in lines if line.startswith("LM3=")]
    assert len(set(sizes)) == 1
    assert not any("LM=" in line.upper() for line in lines)
    data = np.array([line.split() for line in lines if "=" not in line], np.float64)
    names = [line.removeprefix("ID=") for line in lines if line.startswith("ID=")]
    return data.reshape(len(sizes), sizes[0], 3), names


def test_tps(result, places, tmp_path):
    assert result.export(tmp_path / "out.tps") == [tmp_path / "out.tps"]
    text = (tmp_path / "out.tps").read_text(encoding="utf-8")
    found, names = tps_by_the_grammar(text)
    assert names == [name.replace(" ", "_") for name in names_of(result)]
    equal(found, np.array(places))
    assert (
        text.count(
            "COMMENT=mobius-match; source -> target: landmark k of the source corresponds to landmark k of the target"
        )
        == 2
    )


def test_morphologika(result, places, tmp_path):
    """As geomorph's read.morphologika reads: values follow their headings, lines with ' separate individuals."""
    result.export(tmp_path / "out.txt", format="morphologika")
    lines = [line.strip() for line in (tmp_path / "out.txt").read_text(encoding="utf-8").split("\n") if line.strip()]

    def after(word):
        (place,) = [i for i, line in enumerate(lines) if word in line.lower()]
        return place + 1

    n, p, k = (int(lines[after(word)]) for word in ("individuals", "landmarks", "dimensions"))
    assert (n, k) == (2, 3)
    assert lines[after("names") :][:n] == [name.replace(" ", "_") for name in names_of(result)]
    data = lines[after("rawpoints") :][: n * p + n]
    points = [line.split(" ") for line in data if "'" not in line]
    assert len(points) == n * p
    equal(np.array(points, np.float64).reshape(n, p, k), np.array(places))
    assert "source -> target" in lines[-1]


def test_pts(result, places, tmp_path):
    """As Morpho's read.pts reads: two lines are skipped, then name, x, y, z."""
    for path, wanted in zip(result.export(tmp_path / "out.pts"), places, strict=True):
        version, number, *rows = path.read_text().splitlines()
        assert (version, int(number)) == ("Version 1.0", len(result))
        cells = [row.split(" ") for row in rows]
        equal([row[1:] for row in cells], wanted)
        assert [row[0] for row in cells] == [str(i) for i in range(1, len(rows) + 1)]


def test_picked_points(result, places, tmp_path):
    for path, name, wanted in zip(result.export(tmp_path / "out.pp"), names_of(result), places, strict=True):
        assert path.read_text(encoding="utf-8").startswith(
            "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <!-- mobius-match"
        )
        root = ElementTree.parse(path).getroot()
        assert root.find("DocumentData/DataFileName").get("name") == name
        points = root.findall("point")
        equal([[point.get(axis) for axis in "xyz"] for point in points], wanted)
        assert [point.get("name") for point in points] == [str(i) for i in range(1, len(points) + 1)]
        assert {point.get("active") for point in points} == {"1"}


@pytest.mark.parametrize("kind", ["ply", "glb"])
def test_coloured_meshes(result, dense, tmp_path, kind):
    for given, name in ((None, "patches"), (dense, "carried")):
        paths = result.export(tmp_path / f"{name}.{kind}", dense=given)
        assert paths == [tmp_path / f"{name}-{side}.{kind}" for side in SIDES]
        colours = []
        for path, info in zip(paths, (result.source_info, result.target_info), strict=True):
            mesh, own = trimesh.load(path, process=False, force="mesh"), mm.read_mesh(info["path"])
            np.testing.assert_array_equal(mesh.faces, own.faces)
            comment = (
                f"mobius-match; source -> target: equal colours correspond; this is the {SIDES[paths.index(path)]},"
            )
            assert path.read_bytes().count(comment.encode()) == 1
            if kind == "ply":
                equal(mesh.vertices, own.vertices)
            else:
                np.testing.assert_array_equal(mesh.vertices.astype(np.float32), own.vertices.astype(np.float32))
            colours.append(np.asarray(mesh.visual.vertex_colors)[:, :3].astype(int))
        # Both ends of a match have similar colours, and different matches different ones.
        source_colours, target_colours = (side[numbers] for side, numbers in zip(colours, result.pairs.T, strict=True))
        if given is None:
            np.testing.assert_array_equal(source_colours, target_colours)
        else:
            assert np.abs(source_colours - target_colours).max() <= 20
        assert len(np.unique(source_colours, axis=0)) > len(result) // 2


def test_vertices_without_a_counterpart_are_grey(result, dense, tmp_path):
    lost = np.zeros(len(dense.source_mapped), bool)
    lost[:9] = True
    part = type(dense)(dense.source, dense.target, dense.target_points, dense.source_points, ~lost, dense.target_mapped)
    (path,) = export(part, tmp_path / "out.ply", side="source")
    colours = np.asarray(trimesh.load(path, process=False).visual.vertex_colors)
    np.testing.assert_array_equal((colours == [204, 207, 212, 255]).all(axis=1), lost)


def arrays_match(found, base, result, places, dense):
    assert int(found["index_base"]) == base
    assert str(found["direction"]) == "source -> target"
    np.testing.assert_array_equal(np.column_stack([found[side] for side in SIDES]) - base, result.pairs)
    equal(found["confidence"].ravel(), result.confidence)
    np.testing.assert_array_equal(found["recovered"].ravel(), result.kind == "recovered")
    for side, wanted in zip(SIDES, places, strict=True):
        equal(found[f"{side}_points"], wanted)
    np.testing.assert_array_equal(found["target_corners"] - base, result.target_points.corners)
    equal(found["target_weights"], result.target_points.barycentric)
    for side, onward in (("source", dense), ("target", dense.inverse)):
        np.testing.assert_array_equal(found[f"dense_{side}_vertex"].ravel() - base, onward.vertex_map)
        there = onward.target
        corners = (found[f"dense_{side}_corners"] - base).astype(int)
        faces = (found[f"dense_{side}_face"].ravel() - base).astype(int)
        np.testing.assert_array_equal(corners[onward.source_mapped], there.faces[faces[onward.source_mapped]])
        images = np.einsum("nk,nkd->nd", found[f"dense_{side}_weights"], there.vertices[corners])
        equal(images[onward.source_mapped], onward.positions[onward.source_mapped])
        assert (corners[~onward.source_mapped] == -1).all()
        assert (faces[~onward.source_mapped] == -1).all()


def test_npz_counts_from_0(result, places, partial, tmp_path):
    result.export(tmp_path / "out.npz", dense=partial)
    with np.load(tmp_path / "out.npz", allow_pickle=False) as found:
        arrays_match(dict(found), 0, result, places, partial)


def test_mat_counts_from_1_and_says_so(result, places, partial, tmp_path):
    result.export(tmp_path / "out.mat", dense=partial)
    found = scipy.io.loadmat(tmp_path / "out.mat", squeeze_me=True)
    arrays_match(found, 1, result, places, partial)
    assert b"source -> target, vertices and faces count from 1, 0 is none" in found["__header__"]
    assert found["dense_source_vertex"].min() == 0
    assert scipy.io.loadmat(tmp_path / "out.mat")["source"].shape == (len(result), 1), "a column, as in MATLAB"


def test_dense_text(result, partial, tmp_path):
    result.export(tmp_path / "out.txt", dense=partial)
    export(partial, tmp_path / "same.txt")
    assert (tmp_path / "out.txt").read_bytes() == (tmp_path / "same.txt").read_bytes()
    np.testing.assert_array_equal(np.loadtxt(tmp_path / "out.txt", dtype=int), partial.vertex_map)
