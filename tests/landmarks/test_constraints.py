"""Pairs that the user knows: they decide between explanations, stand in the result, and are checked."""

import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import FormatError, SettingsError
from mobius_match.evaluation import examples
from mobius_match.exporting import FORMATS
from mobius_match.landmarks.constraints import apply_constraints, landmark_constraints
from mobius_match.landmarks.tables import Landmarks
from tests.shapes import icosphere, lump, renumbered, rotation


def two_fold(subdivisions=3):
    """A shape that a half turn takes to itself, and the opposite of each vertex."""
    vertices, faces = icosphere(subdivisions)
    directions = np.array([[1, 0.2, 0.5], [0.3, 1, -0.6], [0.6, -0.5, 0.9]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    radius = np.ones(len(vertices))
    for direction, height, width in zip(directions, (1.5, 1.0, 0.7), (0.25, 0.35, 0.3), strict=True):
        for sign in ([1, 1, 1], [-1, -1, 1]):
            radius += height * np.exp((vertices @ (direction * sign) - 1) / width**2)
    turned = vertices * [-1, -1, 1]
    opposite = np.linalg.norm(vertices[:, None] - turned, axis=2).argmin(axis=0)
    return (vertices * radius[:, None], faces), opposite


@pytest.fixture(scope="module")
def ambiguous():
    """A symmetric shape, a moved copy, and the two right answers, which nothing tells apart."""
    shape, opposite = two_fold()
    (vertices, faces), new = renumbered(shape)
    return mm.prepare(shape), mm.prepare((vertices @ rotation(1).T * 2.5 + 1, faces)), new, new[opposite]


@pytest.fixture(scope="module")
def copies():
    shape = lump(3)
    copy, new = renumbered(shape)
    return mm.prepare(shape), mm.prepare(copy), new


@pytest.mark.parametrize("vertex", [0, 17, 400])
def test_one_hint_decides_between_two_equally_good_explanations(ambiguous, vertex):
    source, target, *answers = ambiguous
    for answer in answers:
        result = mm.match(source, target, landmarks=[[vertex, answer[vertex]]])
        np.testing.assert_array_equal(result.pairs[0], [vertex, answer[vertex]])
        assert len(result) >= 90
        assert (answer[result.pairs[:, 0]] == result.pairs[:, 1]).mean() > 0.95
        assert not any("nearly as good" in warning for warning in result.warnings)
        assert (result.dense().vertex_map == answer).mean() > 0.95


def test_hints_stand_first_with_confidence_1_and_are_marked(copies, tmp_path):
    source, target, new = copies
    given = np.array([[i, new[i]] for i in (300, 5, 77)])
    result = mm.match(source, target, landmarks=given)
    np.testing.assert_array_equal(result.pairs[:3], given)
    assert result.confidence[:3].tolist() == [1.0] * 3
    assert result.given.tolist() == [True] * 3 + [False] * (len(result) - 3)
    assert (np.diff(result.confidence) <= 0).all()
    for column in result.pairs.T:
        assert len(np.unique(column)) == len(result)
    points = result.target_points[np.arange(3)]
    np.testing.assert_array_equal(points.values(target.mesh.vertices), target.mesh.vertices[given[:, 1]])
    np.testing.assert_array_equal(points.corners, target.mesh.faces[points.faces])
    rows = result.to_dict()["correspondences"]
    assert [row.get("given") for row in rows] == [True] * 3 + [None] * (len(rows) - 3)
    assert {row["kind"] for row in rows} <= {"voted", "recovered"}
    result.save(tmp_path / "result.json")
    loaded = mm.Correspondence.load(tmp_path / "result.json")
    np.testing.assert_array_equal(loaded.given, result.given)
    assert json.loads(result.to_json())["settings"]["landmarks"] == given.tolist()


def test_the_dense_map_goes_through_hints_that_are_a_little_off(copies):
    source, target, new = copies
    beside = source.mesh.faces[(source.mesh.faces == 40).any(axis=1)][0]
    other = int(beside[beside != 40][0])
    dense = mm.match(source, target, landmarks=[[40, new[other]]]).dense()
    assert dense.vertex_map[40] == new[other]
    assert dense.inverse.vertex_map[new[other]] == 40


def test_without_hints_nothing_of_them_is_in_the_result(copies):
    result = mm.match(*copies[:2])
    assert result.given is None
    assert "landmarks" not in result.settings
    assert not any("given" in row for row in result.to_dict()["correspondences"])


def test_a_result_with_hints_is_made_again_the_same(ambiguous, tmp_path):
    paths = []
    for name, surface in zip(("one.off", "two.off"), ambiguous[:2], strict=True):
        mesh = surface.mesh
        paths.append(tmp_path / name)
        rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
        rows += "".join(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces.tolist())
        paths[-1].write_text(f"OFF\n{len(mesh.vertices)} {len(mesh.faces)} 0\n{rows}")
    (tmp_path / "hints.csv").write_text(f"source,target\n9,{ambiguous[3][9]}\n")
    first = mm.match(*paths, landmarks=tmp_path / "hints.csv")
    first.save(tmp_path / "result.json")
    again = mm.rematch(mm.Correspondence.load(tmp_path / "result.json"))
    for result in (again, mm.match(*paths, landmarks=tmp_path / "hints.csv", jobs=1)):
        assert result.to_dict()["correspondences"] == first.to_dict()["correspondences"]
        assert result.settings | {"jobs": None} == first.settings


def test_one_hint_swaps_the_legs_of_a_person():
    """Told that the left foot is the right one, a person's legs are matched so, though all else speaks against it."""
    one, two = (mm.prepare(path) for path in examples.paths("person"))
    faces, weights = examples.truth("person")
    mirrored_faces, mirrored_weights = examples.truth("person", mirrored=True)

    def vertices(faces, weights):
        return two.mesh.faces[faces, weights.argmax(axis=1)]

    true, mirrored = vertices(faces, weights), vertices(mirrored_faces, mirrored_weights)
    foot = int(one.mesh.vertices[:, 1].argmin())
    places = two.mesh.vertices
    for answer, other in ((true, mirrored), (mirrored, true)):
        result = mm.match(one, two, landmarks=[[foot, answer[foot]]])
        legs = one.mesh.vertices[result.pairs[:, 0], 1] < 0.4
        near, far = (
            np.linalg.norm(places[result.pairs[:, 1]] - places[which[result.pairs[:, 0]]], axis=1)[legs]
            for which in (answer, other)
        )
        assert legs.sum() >= 5
        assert (near < far).mean() > 0.9


def test_parts_take_hints_too():
    shape, _ = two_fold()
    vertices, faces = shape
    kept = faces[(vertices[faces][:, :, 2] > -0.9).all(axis=1)]
    numbers = np.unique(kept)
    part = mm.prepare((vertices[numbers], np.searchsorted(numbers, kept)))
    whole = mm.prepare(shape)
    result = mm.match(part, whole, landmarks=[[3, numbers[3]]])
    np.testing.assert_array_equal(result.pairs[0], [3, numbers[3]])
    back = mm.match(whole, part, landmarks=[[numbers[3], 3]])
    np.testing.assert_array_equal(back.pairs[0], [numbers[3], 3])


def test_pins_keep_their_arms_turned(copies):
    source, target, new = copies
    vertices = np.array([3, 200])
    hints, _ = landmark_constraints(np.column_stack([vertices, new[vertices]]), source, target)
    pins = hints.point_constraints(source, target, target.mesh.vertices)
    turns = np.tile(rotation(4), (len(source.proxy), 1, 1))
    rest = source.mesh.vertices[source.proxy] / np.sqrt(source.area)
    places, trust = apply_constraints(pins, np.zeros((len(rest), 3)), np.ones(len(rest)), turns)
    for row, place, arm in zip(pins.rows, pins.places, pins.arms, strict=True):
        np.testing.assert_allclose(places[row], place + arm @ rotation(4))
    untouched = np.setdiff1d(np.arange(len(rest)), pins.rows)
    assert (trust[untouched] == 1).all()
    assert not places[untouched].any()
    assert trust[pins.rows].min() > 1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([], "there is no pair"),
        ([[0, 642]], "has no vertex 642; it has 642, numbered from 0"),
        ([[-1, 0]], "has no vertex -1"),
        ([[1, 2], [1, 3]], r"vertex 1 of .* is given 2 counterparts \(2, 3\)"),
        ([[1, 2], [3, 2]], r"vertex 2 of .* is given 2 counterparts \(1, 3\)"),
        ([1, 2], "landmarks are pairs"),
        ([[1.5, 2]], "landmarks are pairs"),
        ([[1, 2], [3]], "landmarks are pairs"),
        (["a", "b", "c"], "3 files|sets of landmarks|cannot be read|unknown ending"),
        (7, "landmarks are pairs"),
    ],
)
def test_bad_hints_are_told(copies, given, message):
    with pytest.raises((SettingsError, FormatError), match=message):
        mm.match(*copies[:2], landmarks=given)


def test_uniform_triplets_take_no_hints(copies):
    with pytest.raises(SettingsError, match="`landmarks` need guided proposals"):
        mm.match(*copies[:2], landmarks=[[0, 0]], proposal="uniform")


def test_repeated_and_doubtful_hints_get_a_line(copies):
    source, target, new = copies
    some = [0, 100, 200, 300, 400]
    pairs = [[i, new[i]] for i in some]
    hints, notes = landmark_constraints([*pairs, pairs[1]], source, target)
    assert notes == ["landmarks: 1 given more than once count once"]
    np.testing.assert_array_equal(hints.pairs, pairs)
    solve = source.distances[:, 0]
    far = int(source.samples[solve.argmax()])
    near = int(source.samples[0])
    _, notes = landmark_constraints([*pairs, [near, new[far]]], source, target)
    assert len(notes) == 1
    assert f"vertex {near} and array vertex {new[far]} are not as far from the other landmarks" in notes[0]


def written(folder, name, marks):
    path = folder / name
    (ending,) = (one for one in FORMATS.values() if one.marks and name.endswith(one.endings[0]))
    path.write_bytes(ending.marks(marks, "", "LPS"))
    return path


@pytest.mark.parametrize("ending", [one.endings[0] for one in FORMATS.values() if one.marks])
def test_two_files_are_paired_by_name_or_by_order(copies, tmp_path, ending):
    source, target, new = copies
    some = np.array([7, 70, 170])
    names = ["a", "b", "c"]
    one = Landmarks(names, None, source.mesh.vertices[some])
    two = Landmarks(names[::-1], None, target.mesh.vertices[new[some[::-1]]])
    if ending == ".morphologika":  # has no names
        two = Landmarks(names, None, target.mesh.vertices[new[some]])
    paths = [written(tmp_path, f"one{ending}", [one]), written(tmp_path, f"two{ending}", [two])]
    hints, notes = landmark_constraints(paths, source, target)
    assert notes == []
    np.testing.assert_array_equal(hints.pairs, np.column_stack([some, new[some]]))


def test_files_of_pairs_and_of_two_specimens(copies, tmp_path):
    source, target, new = copies
    some = np.array([7, 70])
    wanted = np.column_stack([some, new[some]])
    sides = [
        Landmarks(["1", "2"], None, surface.mesh.vertices[numbers], name)
        for surface, numbers, name in ((source, some, "one"), (target, new[some], "two"))
    ]
    from_1 = "".join(f"{i},{j},1\n" for i, j in (wanted + 1).tolist())
    (tmp_path / "from1.csv").write_text(f"source,target,index_base\n{from_1}")
    mm.match(source, target, landmarks=wanted).export(tmp_path / "own.csv")
    files = [
        written(tmp_path, "both.tps", sides),
        written(tmp_path, "both.morphologika", sides),
        tmp_path / "from1.csv",
    ]
    for path in files:
        hints, _ = landmark_constraints(path, source, target)
        np.testing.assert_array_equal(hints.pairs, wanted)
    hints, _ = landmark_constraints(tmp_path / "own.csv", source, target)
    np.testing.assert_array_equal(hints.pairs[:2], wanted)


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"a.tps": "LM3=1\n0 0 1\n"}, "1 sets of landmarks; give the source's and the target's"),
        ({"a.csv": "source,target\n1,b\n"}, r"a.csv: line 2: 'b' is not a number"),
        ({"a.csv": "source,target\n1,1.5\n"}, "have a number that is not whole"),
        ({"a.csv": "x,y\n1,1\n"}, "has no columns x, y, z"),
        ({"a.csv": "x,y,z\n0,0,1\n", "b.csv": "x,y,z\n0,0,1\n1,0,0\n"}, None),
        ({"a.csv": "name,x,y,z\na,0,0,1\n", "b.csv": "name,x,y,z\nb,0,0,1\nc,1,0,0\n"}, "cannot be paired"),
        ({"a.pts": "Version 1.0\n1\nS 1 2\n", "b.pts": "Version 1.0\n1\nS 1 2 3\n"}, "a.pts, line 3: 2 numbers"),
        ({"a.csv": "vertex\n3\n", "b.csv": "vertex\n999\n"}, "has no vertex 999"),
    ],
)
def test_bad_files_of_hints(copies, tmp_path, files, message):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    paths = [tmp_path / name for name in files]
    if message is None:
        _, notes = landmark_constraints(paths, *copies[:2])
        assert any("on one side only, and left out: 2" in note for note in notes)
        return
    with pytest.raises((FormatError, SettingsError), match=message):
        landmark_constraints(paths, *copies[:2])


def test_hints_on_a_large_mesh_are_those_of_the_users_vertices(copies):
    shape = lump(4)
    (vertices, faces), new = renumbered(shape)
    one, two = (mm.prepare(mesh, resolution=600, samples=60) for mesh in (shape, (vertices, faces)))
    assert one.detail is not None
    result = mm.match(one, two, landmarks=[[1234, new[1234]]])
    np.testing.assert_array_equal(result.pairs[0], [1234, new[1234]])
    assert result.dense().vertex_map[1234] == new[1234]
