"""All formats: equal bytes each time, one side, errors that write nothing, arbitrary names."""

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
    for folder, same in (("a", result), ("b", mm.Correspondence.load(tmp_path / "result.json"))):
        (tmp_path / folder).mkdir()
        written = same.export(tmp_path / folder / "out", **options)
        assert sorted(written) == sorted((tmp_path / folder).iterdir())
    for path in written:
        assert path.read_bytes() == (tmp_path / "a" / path.name).read_bytes()


@pytest.mark.parametrize("name", [name for name, form in FORMATS.items() if form.write_landmarks])
def test_one_side_goes_to_the_path_itself(name, result, places, tmp_path):
    path = tmp_path / f"out{FORMATS[name].endings[0]}"
    assert result.export(path, side="target") == [path]
    landmarks = mm.read_landmarks(path)
    equal(landmarks.points, places[1])
    assert landmarks.names == [str(i) for i in range(1, len(result) + 1)]


def test_minimum_confidence(result, tmp_path):
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
        ("out.csv", {"format": "excel"}, SettingsError, "`format` is 'excel'; choose one of csv, slicer"),
        ("out.pts", {"side": "left"}, SettingsError, "`side` is 'left'; choose one of source, target"),
        ("out.mat", {"side": "source"}, SettingsError, "holds both shapes together; it cannot be written with `side`"),
        (
            "out.fcsv",
            {"coordinate_system": "ras"},
            SettingsError,
            "`coordinate_system` is 'ras'; choose one of LPS, RAS",
        ),
        ("out.csv", {"min_confidence": 1.5}, SettingsError, "`min_confidence` is 1.5; give a number from 0 to 1"),
        ("out.csv", {"min_confidence": float("nan")}, SettingsError, "from 0 to 1"),
        (
            "out.csv",
            {"min_confidence": 1.0},
            NothingFoundError,
            r"a confidence of at least 1\.0; the highest is \d\.\d+. Lower `min_confidence`",
        ),
        ("out.txt", {}, SettingsError, "this format holds a dense map; give one as `dense`"),
    ],
)
def test_errors_write_nothing(result, tmp_path, name, options, error, message):
    with pytest.raises(error, match=message):
        result.export(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_maps_have_no_landmarks_and_belong_to_their_meshes(result, dense, tmp_path):
    with pytest.raises(SettingsError, match="this format holds matches, and `result` is a dense map"):
        export(dense, tmp_path / "out.csv")
    with pytest.raises(MeshError, match="`dense` is a map between other meshes"):
        result.export(tmp_path / "out.ply", dense=dense.inverse)


def test_a_changed_mesh_is_refused(result, tmp_path):
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


@pytest.mark.parametrize("name", [name for name, form in FORMATS.items() if form.write_landmarks])
def test_names_may_hold_the_syntax_of_the_format(name, tmp_path):
    """Whatever the names of landmarks and specimens, the file reads back with the same points."""
    points = np.random.default_rng(0).normal(size=(len(HOSTILE), 3)) * 10.0 ** np.arange(-8, 2)[:, None]
    for title in HOSTILE:
        names = [name.replace("\ud800", "?").replace("\n", " ") for name in HOSTILE]
        landmarks = Landmarks(names, None, points, title)
        path = tmp_path / f"out{FORMATS[name].endings[0]}"
        path.write_bytes(FORMATS[name].write_landmarks([landmarks], "a -- comment\nwith [names] and LM3=2", "LPS"))
        found = mm.read_landmarks(path)
        equal(found.points, points)
        if name in ("slicer", "fcsv", "pp", "csv", "tps"):
            assert found.names == [" ".join(landmark.split()) for landmark in names]
