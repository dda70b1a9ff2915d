"""Landmark files of other programs, and the errors for damaged ones."""

import json
import tracemalloc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mobius_match as mm
from mobius_match.errors import FormatError, MobiusError, SettingsError
from mobius_match.exporting import FORMATS
from mobius_match.landmarks.tables import Landmarks

POINTS = np.array([[1.5, -2.25, 3e-7], [0.1, 0.2, 0.30000000000000004]])

MARKUPS = {
    "@schema": "https://raw.githubusercontent.com/Slicer/Slicer/main/.../markups-schema-v1.0.0.json#",
    "markups": [
        {
            "type": "Fiducial",
            "coordinateSystem": "LPS",
            "controlPoints": [
                {"label": "F-1", "position": [1.5, -2.25, 3e-7]},
                {"label": "F-2", "position": [0.1, 0.2, 0.30000000000000004]},
            ],
        }
    ],
}

# As other programs write them.
GOOD = {
    "F.mrk.json": json.dumps(MARKUPS, indent=4),
    "F.fcsv": "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
    "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
    "vtkMRMLMarkupsFiducialNode_0,1.5,-2.25,3e-7,0,0,0,1,1,1,0,F-1,,\n"
    "1,0.1,0.2,0.30000000000000004,0,0,0,1,1,1,0,F-2,,,2,0\n",
    "one.tps": "LM3=2\r\n1.5 -2.25 3e-7\r\n0.1\t0.2 0.30000000000000004\r\nIMAGE=x.jpg\r\nID=0\r\n",
    "one.morphologika": "[individuals]\n1\n[landmarks]\n2\n[Dimensions]\n3\n[names]\nAb 1\n[labels]\nSex\n"
    "[labelvalues]\nF\n[rawpoints]\n\n'#1\n1.5 -2.25 3e-7\n0.1 0.2 0.30000000000000004\n",
    "one.txt": "'a comment\n[Individuals]\n1\n[landmarks]\n2\n[dimensions]\n3\n[rawpoints]\n'#1\n1.5   -2.25 3E-7\n"
    "0.1 0.2 0.30000000000000004\n",
    "one.pts": "Version 1.0\n2\nS000 1.5 -2.25 3e-7\nS001  0.1  0.2 0.30000000000000004 \n",
    "one.pp": '<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData>\n  <DateTime date="2023-02-24" time="19:15"/>\n'
    '  <User name="me"/>\n  <DataFileName name="x.ply"/>\n  <templateName name=""/>\n </DocumentData>\n'
    ' <point y="-2.25" name="0" active="1" z="3e-7" x="1.5"/>\n'
    ' <point x="0.1" y="0.2" z="0.30000000000000004" name="1"/>\n</PickedPoints>\n',
    "one.csv": "name;x;y;z\nnose;1.5;-2.25;3e-7\ntail;0.1;0.2;0.30000000000000004\n",
    "plain.csv": "label,description,x,y,z\n1,,1.5,-2.25,3e-7\n2,,0.1,0.2,0.30000000000000004\n",
}
NAMES = {
    "F.mrk.json": ["F-1", "F-2"],
    "F.fcsv": ["F-1", "F-2"],
    "one.pts": ["S000", "S001"],
    "one.pp": ["0", "1"],
    "one.csv": ["nose", "tail"],
}


def written(folder, name, text):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("name", GOOD)
def test_files_of_other_programs(name, tmp_path):
    for mark in (b"", b"\xef\xbb\xbf"):
        landmarks = mm.read_landmarks(written(tmp_path, name, mark + GOOD[name].encode()))
        assert landmarks.points.tobytes() == POINTS.tobytes()
        assert landmarks.names == NAMES.get(name, ["1", "2"])


def test_recorded_coordinate_systems_are_converted_and_others_are_not(tmp_path):
    for name, text in GOOD.items():
        path = written(tmp_path, name, text)
        wanted = POINTS * [-1, -1, 1] if name.startswith("F") else POINTS
        np.testing.assert_array_equal(mm.read_landmarks(path, coordinate_system="RAS").points, wanted)
        path = written(tmp_path, name, text.replace("LPS", "RAS"))
        np.testing.assert_array_equal(mm.read_landmarks(path).points, wanted)
    old = GOOD["F.fcsv"].replace("= LPS", "= 0")
    np.testing.assert_array_equal(mm.read_landmarks(written(tmp_path, "F.fcsv", old)).points, POINTS * [-1, -1, 1])


def test_missing_landmarks_keep_their_rank(tmp_path):
    files = {
        "F.mrk.json": json.dumps(MARKUPS).replace(
            '{"label": "F-1",', '{"label": "F-1", "positionStatus": "undefined",'
        ),
        "one.tps": GOOD["one.tps"].replace("1.5 -2.25 3e-7", "NA NA NA"),
        "one.pts": GOOD["one.pts"].replace("1.5 -2.25 3e-7", "9999 9999 9999"),
        "one.pp": GOOD["one.pp"].replace('active="1"', 'active="0"'),
    }
    for name, text in files.items():
        points = mm.read_landmarks(written(tmp_path, name, text)).points
        assert np.isnan(points[0]).all()
        np.testing.assert_array_equal(points[1], POINTS[1])


def test_specimens_are_chosen(tmp_path):
    text = GOOD["one.tps"].replace("ID=0", "SCALE=2\nID=a") + GOOD["one.tps"].replace(
        "ID=0", "ID=1\nCURVES=1\nPOINTS=1\n7 8 9"
    )
    path = written(tmp_path, "two.tps", text)
    for choice, size in (("a", 2), (0, 2), ("0", 2), ("1", 1), (1, 1)):
        np.testing.assert_array_equal(mm.read_landmarks(path, choice).points, size * POINTS)
    with pytest.raises(
        SettingsError, match=r"holds 2 specimens \(0 a, 1 1\); choose one by name or number with `specimen`"
    ):
        mm.read_landmarks(path)
    for choice in ("b", 2, -1):
        with pytest.raises(SettingsError, match=f"no specimen matches `specimen` {choice!r}; there are 0 a, 1 1"):
            mm.read_landmarks(path, choice)
    twice = written(tmp_path, "same.tps", 2 * GOOD["one.tps"].replace("ID=0", "ID=x"))
    with pytest.raises(SettingsError, match="several specimens match `specimen` 'x'"):
        mm.read_landmarks(twice, "x")


def test_vertex_numbers_of_a_table(tmp_path):
    landmarks = mm.read_landmarks(written(tmp_path, "v.csv", "name,vertex\nnose,12\ntail,0\n"))
    assert (landmarks.names, landmarks.vertices.tolist(), landmarks.points) == (["nose", "tail"], [12, 0], None)


def test_names_in_latin_1_are_read_in_every_text_format(tmp_path):
    for name in ("F.mrk.json", "F.fcsv", "one.pts", "one.csv"):
        old = NAMES[name][0]
        landmarks = mm.read_landmarks(written(tmp_path, name, GOOD[name].replace(old, "N\xe4se").encode("latin-1")))
        assert landmarks.names[0] == "N\xe4se"
        assert landmarks.points.tobytes() == POINTS.tobytes()


def markups(change):
    return json.dumps(MARKUPS, indent=1).replace(*change)


BAD = [
    ("a.mrk.json", "{", "line 1: not JSON"),
    ("a.mrk.json", '{"markups":\n [}', "line 2: not JSON"),
    ("a.mrk.json", "[" * 100_000, "not readable as JSON"),
    ("a.mrk.json", "[]", "line 1: not a Markups file"),
    ("a.mrk.json", '{"markups": [3]}', "line 1: not a Markups file"),
    ("a.mrk.json", '{"markups": []}', "holds no landmarks"),
    ("a.mrk.json", markups(('"LPS"', '"HFS"')), "line 4: the coordinateSystem is 'HFS'"),
    ("a.mrk.json", markups(("-2.25", '"b"')), "line 8: the position of control point 1 is not three finite numbers"),
    ("a.mrk.json", markups(("0.2,", "")), "line 16: the position of control point 2 is not"),
    ("a.mrk.json", markups(("0.2", "NaN")), "line 16: the position of control point 2 is not"),
    ("a.mrk.json", markups(("0.2", "9" * 400)), "line 16: the position of control point 2 is not"),
    ("a.mrk.json", '{"markups": [\n{"controlPoints": 3}]}', "line 2: 'controlPoints' is not a list"),
    ("a.fcsv", GOOD["F.fcsv"].replace("-2.25", "left"), "line 4: 'left' is not a number"),
    ("a.fcsv", GOOD["F.fcsv"].replace("= LPS", "= up"), "line 2: the coordinate system is 'up'"),
    ("a.fcsv", GOOD["F.fcsv"] + "2,3\n", "line 6: 2 columns, and x, y and z are not among them"),
    ("a.fcsv", "# only comments\n", "holds no landmarks"),
    ("a.tps", "LM=2\n1 2\n3 4\nID=0\n", "line 1: landmarks with two coordinates"),
    ("a.tps", "LM3=2\n1 2 3\nID=0\n", "line 3: LM3=2 of line 1 is followed by only 1 rows"),
    ("a.tps", "LM3=2\n1 2 3\n", "LM3=2 of line 1 is followed by only 1 rows"),
    ("a.tps", "LM3=2\n1 2 3\n4 5\nID=0\n", "line 3: 2 numbers where x, y and z are needed"),
    ("a.tps", "LM3=1\n1 2 3\n4 5 6\n", "line 3: a field such as LM3= or ID= is needed here"),
    ("a.tps", "LM3=1\n1 2 3,5\n", "line 2: '3,5' is not a number"),
    ("a.tps", "LM3=1\n1 2 1e999\n", "line 2: '1e999' is not a number, or too large"),
    ("a.tps", "LM3=1\n1 2 1_0\n", "line 2: '1_0' is not a number"),
    ("a.tps", "LM3=-1\n", "line 1: '-1' is not a number of points"),
    ("a.tps", "ID=4\n", "line 1: ID= before the landmarks"),
    ("a.tps", "LM3=1\n1 2 3\nSCALE=x\n", "line 3: 'x' is not a number"),
    ("a.tps", "LM3=1\n1e308 2 3\nSCALE=1e308\n", "not a finite number"),
    ("a.tps", "LM3=0\n", "holds no landmarks"),
    ("a.morphologika", "1 2 3\n", "line 1: a heading such as"),
    ("a.morphologika", "[individuals]\n1\n", "line 2: the file ends without [landmarks]"),
    ("a.morphologika", GOOD["one.morphologika"].replace("\n3\n", "\n2\n"), "line 6: landmarks have 2 coordinates"),
    (
        "a.morphologika",
        GOOD["one.morphologika"].replace("\n2\n", "\n3\n"),
        "2 rows of points; 1 individuals with 3 need 3",
    ),
    ("a.morphologika", GOOD["one.morphologika"].replace("0.1 0.2", "0.1"), "line 17: 2 numbers where"),
    ("a.morphologika", GOOD["one.morphologika"].replace("Ab 1", "a\nb"), "line 9: 2 names for 1 individuals"),
    ("a.pts", "version: 1\nn_points: 2\n{\n", "line 1: the first line should be 'Version 1.0'"),
    ("a.pts", "Version 1.0\n", "line 1: the number of landmarks should follow"),
    ("a.pts", "Version 1.0\n3\nS0 1 2 3\n", "line 3: 1 landmarks, and line 2 says 3"),
    ("a.pts", "Version 1.0\n1\nS0 1 2\n", "line 3: 2 numbers where"),
    ("a.pp", "<PickedPoints>\n<point x='1'", "line 2: not XML"),
    ("a.pp", "<html/>", "line 1: <html> where <PickedPoints> should begin"),
    ("a.pp", "<PickedPoints>\n<point x='1' y='2'/></PickedPoints>", "line 2: a point without z"),
    ("a.pp", "<PickedPoints>\n<point x='1' y='2' z='inf'/></PickedPoints>", "line 2: 'inf' is not a number"),
    ("a.pp", "<!DOCTYPE PickedPoints [\n<!ENTITY a 'b'>]>\n<PickedPoints/>", "line 2: it declares an entity"),
    ("a.pp", "<PickedPoints/>", "holds no landmarks"),
    ("a.csv", "a,b\n1,2\n", "has no columns x, y, z, nor vertex"),
    ("a.csv", "x,y,z\n1,2,b\n", "line 2: 'b' is not a number"),
    ("a.csv", "x,y,z\n1,2\n", "line 2 has 2 columns"),
    ("a.csv", "x,y,z\n", "holds no landmarks"),
    ("a.csv", "x,y,z\n1,2,3\n1,2,inf\n", "line 3 has a coordinate that is not a finite number"),
    ("a.csv", "name,vertex\na,3\nb,3.5\n", "line 3: '3.5' is not a vertex number"),
    ("a.csv", f"vertex\n{'9' * 20}\n", "line 2: '99999999999999999999' is not a vertex number"),
    ("a.npz", "PK", "not an .npz file of exported matches"),
    ("a.pts", "", "the file is empty"),
    ("a.stl", "solid", "unknown ending; landmarks are read from .csv, .mrk.json"),
]


@pytest.mark.parametrize(("name", "text", "message"), BAD)
def test_errors_name_the_file_and_the_line(name, text, message, tmp_path):
    path = written(tmp_path, name, text)
    with pytest.raises(FormatError) as error:
        mm.read_landmarks(path)
    assert str(error.value).startswith(str(path))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_no_such_file(tmp_path):
    for name in ("none.tps", "none.csv", "none.npz", "none.pp"):
        with pytest.raises(FormatError, match=name):
            mm.read_landmarks(tmp_path / name)


HUGE = "999999999"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.tps", f"LM3={HUGE}\n1 2 3\n"),
        ("a.tps", f"LM3=1\n1 2 3\nPOINTS={HUGE}\n1 2 3\n"),
        ("a.pts", f"Version 1.0\n{HUGE}\nS0 1 2 3\n"),
        ("a.morphologika", f"[individuals]\n{HUGE}\n[landmarks]\n{HUGE}\n[dimensions]\n3\n[rawpoints]\n1 2 3\n"),
    ],
)
def test_wrong_counts_allocate_nothing(name, text, tmp_path):
    path = written(tmp_path, name, text)
    tracemalloc.start()
    with pytest.raises(FormatError):
        mm.read_landmarks(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1_000_000


@pytest.mark.parametrize("name", [*GOOD, "both.csv", "both.tps"])
@given(data=st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_give_landmarks_or_the_packages_errors(name, data, tmp_path):
    both = {
        "both.csv": "name,source_x,source_y,source_z,target_x,target_y,target_z\n1,1,2,3,4,5,6\n",
        "both.tps": GOOD["one.tps"] * 2 + 'COMMENT=names ["a", "b"]\n',
    }
    good = (GOOD | both)[name].encode()
    start = data.draw(st.integers(0, len(good)))
    end = data.draw(st.integers(start, min(len(good), start + 12)))
    chunks = [
        b"",
        b"NA",
        b"=",
        b"-1",
        b"1e400",
        b"[",
        b"]}",
        b'"',
        b"\n",
        b"\x00",
        b"\xff\xfe",
        b"<a>",
        b"&x;",
        b"null",
    ]
    middle = data.draw(st.sampled_from(chunks) | st.binary(max_size=6))
    path = written(tmp_path, name, good[:start] + middle + good[end:])
    try:
        landmarks = mm.read_landmarks(path, data.draw(st.sampled_from([None, 0])))
    except MobiusError as error:
        assert str(error)
    else:
        assert len(landmarks.names) == len(landmarks)
        assert landmarks.points is None or (
            landmarks.points.shape == (len(landmarks), 3) and not np.isinf(landmarks.points).any()
        )
        assert all(mark.isprintable() and mark for mark in landmarks.names)


@pytest.mark.parametrize("name", [name for name, form in FORMATS.items() if form.write_landmarks])
@given(
    points=st.lists(
        st.tuples(*[st.floats(allow_nan=False, allow_infinity=False).filter(lambda x: abs(x) != 9999)] * 3),
        min_size=1,
        max_size=4,
    )
)
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_float_reads_back_to_the_last_digit(name, points, tmp_path):
    array = np.array(points)
    landmarks = Landmarks([str(i) for i in range(1, len(points) + 1)], None, array, "s")
    path = written(tmp_path, f"a{FORMATS[name].endings[0]}", FORMATS[name].write_landmarks([landmarks], "", "LPS"))
    assert mm.read_landmarks(path).points.tobytes() == array.tobytes()
