"""What holds for all formats: the same bytes each time, one side, refusals that write nothing, names as data."""

import csv

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import MeshError, NothingFoundError, SettingsError
from mobius_match.exporting import FORMATS, export
from mobius_match.landmarks.tables import Landmarks


def equal(found, wanted):
    """The same numbers, to the last digit."""
    found = np.array(found, np.float64)
    assert found.shape == wanted.shape
    assert found.tobytes() == np.ascontiguousarray(wanted).tobytes()


@pytest.mark.parametrize("name", FORMATS)
def test_bytes_are_the_same_each_time_and_from_a_loaded_result(name, result, dense, tmp_path):
    result.save(tmp_path / "result.json")
    options = {"format": name, "dense": dense}
    for folder, one in (("a", result), ("b", mm.Correspondence.load(tmp_path / "result.json"))):
        (tmp_path / folder).mkdir()
        written = one.export(tmp_path / folder / "out", **options)
        assert sorted(written) == sorted((tmp_path / folder).iterdir())
    for path in written:
        assert path.read_bytes() == (tmp_path / "a" / path.name).read_bytes()


@pytest.mark.parametrize("name", [name for name, one in FORMATS.items() if one.marks])
def test_one_side_goes_to_the_path_itself(name, result, places, tmp_path):
    path = tmp_path / f"out{FORMATS[name].endings[0]}"
    assert result.export(path, side="target") == [path]
    marks = mm.read_landmarks(path)
    equal(marks.points, places[1])
    assert marks.names == [str(i) for i in range(1, len(result) + 1)]


def test_least_confidence(result, tmp_path):
    least = float(np.median(result.confidence))
    (path,) = result.export(tmp_path / "out.csv", min_confidence=least)
    with path.open(newline="") as file:
        assert [float(row["confidence"]) for row in csv.DictReader(file)] == [
            value for value in result.confidence.tolist() if value >= least
        ]


@pytest.mark.parametrize(
    ("name", "options", "error", "message"),
    [
        ("out.stl", {}, SettingsError, r"unknown ending; known are \.csv, \.mrk\.json, \.json, \.fcsv, \.tps"),
        ("out", {}, SettingsError, "unknown ending"),
        ("out.csv", {"format": "excel"}, SettingsError, "the format is 'excel'; choose one of csv, slicer"),
        ("out.pts", {"side": "left"}, SettingsError, "side is 'left'; choose one of source, target"),
        ("out.mat", {"side": "source"}, SettingsError, "holds both shapes together"),
        ("out.fcsv", {"coordinate_system": "ras"}, SettingsError, "coordinate system is 'ras'; choose one of LPS, RAS"),
        ("out.csv", {"min_confidence": 1.5}, SettingsError, "from 0 to 1"),
        ("out.csv", {"min_confidence": float("nan")}, SettingsError, "from 0 to 1"),
        (
            "out.csv",
            {"min_confidence": 1.0},
            NothingFoundError,
            "a confidence of 1.0 or more; the highest",
        ),
        ("out.txt", {}, SettingsError, "give it with --dense"),
    ],
)
def test_errors_write_nothing(result, tmp_path, name, options, error, message):
    with pytest.raises(error, match=message):
        result.export(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_maps_have_no_landmarks_and_belong_to_their_meshes(result, dense, tmp_path):
    with pytest.raises(SettingsError, match="a dense map holds no list of matches"):
        export(dense, tmp_path / "out.csv")
    with pytest.raises(MeshError, match="the map is of other meshes"):
        result.export(tmp_path / "out.ply", dense=dense.inverse)


def test_a_changed_mesh_is_told(result, tmp_path):
    changed = mm.Correspondence(
        **{name: getattr(result, name) for name in ("pairs", "confidence", "kind", "target_info", "settings")},
        source_info=result.source_info | {"sha256": "0" * 64},
    )
    with pytest.raises(MeshError, match="has changed since the match"):
        changed.export(tmp_path / "out.tps")


HOSTILE = [
    "<point x='9'/>",
    'a,b"c',
    "two\nlines",
    "LM3=4",
    "x=1\tid=2",
    "[rawpoints]",
    "nose tip",
    "ü—鼻",
    "\ud800",
    "--",
]


@pytest.mark.parametrize("name", [name for name, one in FORMATS.items() if one.marks])
def test_names_are_data(name, tmp_path):
    """Whatever landmarks and specimens are called, the file reads back with the same points."""
    points = np.random.default_rng(0).normal(size=(len(HOSTILE), 3)) * 10.0 ** np.arange(-8, 2)[:, None]
    for title in HOSTILE:
        marks = Landmarks([mark.replace("\ud800", "?").replace("\n", " ") for mark in HOSTILE], None, points, title)
        path = tmp_path / f"out{FORMATS[name].endings[0]}"
        path.write_bytes(FORMATS[name].marks([marks], "a -- comment\nwith [names] and LM3=2", "LPS"))
        found = mm.read_landmarks(path)
        equal(found.points, points)
        if name in ("slicer", "fcsv", "pp", "csv", "tps"):
            assert found.names == [" ".join(mark.split()) for mark in marks.names]
