"""Landmarks that the user knows: they decide between alignments, are in the result, and are checked."""

import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import FormatError, SettingsError
from mobius_match.evaluation import examples
from mobius_match.exporting import FORMATS
from mobius_match.landmarks.constraints import apply_constraints, landmark_constraints
from mobius_match.landmarks.parameters import LandmarkParameters
from mobius_match.landmarks.tables import Landmarks
from tests.shapes import icosphere, lump, renumbered, rotation


def two_fold(subdivisions=3):
    """A shape with a two-fold rotation symmetry, and the image of each vertex under it."""
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
    """A symmetric shape, a moved copy, and the two maps between them that are equally good."""
    shape, opposite = two_fold()
    (vertices, faces), new = renumbered(shape)
    return mm.prepare(shape), mm.prepare((vertices @ rotation(1).T * 2.5 + 1, faces)), new, new[opposite]


@pytest.fixture(scope="module")
def copies():
    shape = lump(3)
    copy, new = renumbered(shape)
    return mm.prepare(shape), mm.prepare(copy), new


@pytest.mark.parametrize("vertex", [0, 17, 400])
def test_one_landmark_decides_between_two_equally_good_alignments(ambiguous, vertex):
    source, target, *answers = ambiguous
    for answer in answers:
        result = mm.match(source, target, landmarks=[[vertex, answer[vertex]]])
        np.testing.assert_array_equal(result.pairs[0], [vertex, answer[vertex]])
        assert len(result) >= 90
        assert (answer[result.pairs[:, 0]] == result.pairs[:, 1]).mean() > 0.95
        assert not result.warnings
        assert (result.dense().vertex_map == answer).mean() > 0.95


def test_landmarks_come_first_with_confidence_1_and_are_marked(copies, tmp_path):
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


def test_the_dense_map_passes_exactly_through_inexact_landmarks(copies):
    source, target, new = copies
    face = source.mesh.faces[(source.mesh.faces == 40).any(axis=1)][0]
    neighbour = int(face[face != 40][0])
    dense = mm.match(source, target, landmarks=[[40, new[neighbour]]]).dense()
    assert dense.vertex_map[40] == new[neighbour]
    assert dense.inverse.vertex_map[new[neighbour]] == 40


def test_without_landmarks_the_result_has_no_entry_for_them(copies):
    result = mm.match(*copies[:2])
    assert result.given is None
    assert "landmarks" not in result.settings
    assert not any("given" in row for row in result.to_dict()["correspondences"])


def test_rematching_a_result_with_landmarks_reproduces_it(ambiguous, tmp_path):
    paths = []
    for name, surface in zip(("one.off", "two.off"), ambiguous[:2], strict=True):
        mesh = surface.mesh
        paths.append(tmp_path / name)
        rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
        rows += "".join(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces.tolist())
        paths[-1].write_text(f"OFF\n{len(mesh.vertices)} {len(mesh.faces)} 0\n{rows}")
    (tmp_path / "pairs.csv").write_text(f"source,target\n9,{ambiguous[3][9]}\n")
    first = mm.match(*paths, landmarks=tmp_path / "pairs.csv")
    first.save(tmp_path / "result.json")
    again = mm.rematch(mm.Correspondence.load(tmp_path / "result.json"))
    for result in (again, mm.match(*paths, landmarks=tmp_path / "pairs.csv", jobs=1)):
        assert result.to_dict()["correspondences"] == first.to_dict()["correspondences"]
        assert result.settings | {"jobs": None} == first.settings


def test_one_landmark_swaps_the_legs_of_a_person():
    """A landmark that pairs left and right foot swaps the legs, although every other term of the cost is against it."""
    one, two = (mm.prepare(path) for path in examples.paths("person"))
    faces, weights = examples.truth("person")
    mirrored_faces, mirrored_weights = examples.truth("person", mirrored=True)

    def vertices(faces, weights):
        return two.mesh.faces[faces, weights.argmax(axis=1)]

    true, mirrored = vertices(faces, weights), vertices(mirrored_faces, mirrored_weights)
    foot = int(one.mesh.vertices[:, 1].argmin())
    places = two.mesh.vertices
    for expected, opposite in ((true, mirrored), (mirrored, true)):
        result = mm.match(one, two, landmarks=[[foot, expected[foot]]])
        legs = one.mesh.vertices[result.pairs[:, 0], 1] < 0.4
        near, far = (
            np.linalg.norm(places[result.pairs[:, 1]] - places[which[result.pairs[:, 0]]], axis=1)[legs]
            for which in (expected, opposite)
        )
        assert legs.sum() >= 5
        assert (near < far).mean() > 0.9


def test_landmarks_of_a_part_and_of_a_whole():
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


def test_offsets_of_constrained_points_rotate(copies):
    source, target, new = copies
    vertices = np.array([3, 200])
    parameters = LandmarkParameters(weight=7.0)
    landmarks, _ = landmark_constraints(np.column_stack([vertices, new[vertices]]), source, target, parameters)
    points = landmarks.point_constraints(source, target, target.mesh.vertices)
    rotations = np.tile(rotation(4), (len(source.proxy), 1, 1))
    n = len(source.proxy)
    targets, weights = apply_constraints(points, np.zeros((n, 3)), np.ones(n), rotations)
    for row, position, offset in zip(points.rows, points.targets, points.offsets, strict=True):
        np.testing.assert_allclose(targets[row], position + offset @ rotation(4))
    others = np.setdiff1d(np.arange(n), points.rows)
    assert (weights[others] == 1).all()
    assert not targets[others].any()
    assert (weights[points.rows] == 7).all()


def test_the_number_of_guides_is_a_parameter(copies):
    source, target, new = copies
    vertices = np.array([3, 200, 400])
    pairs = np.column_stack([vertices, new[vertices]])
    landmarks, _ = landmark_constraints(pairs, source, target, LandmarkParameters(max_guides=2))
    np.testing.assert_array_equal(landmarks.pairs, pairs)
    assert [len(distances) for distances in landmarks.distances] == [2, 2]
    np.testing.assert_array_equal(landmarks.inverse.distances[0], landmarks.distances[1])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([], "there is no pair"),
        ([[0, 642]], "has no vertex 642; it has 642, numbered from 0"),
        ([[-1, 0]], "has no vertex -1"),
        ([[1, 2], [1, 3]], r"vertex 1 of .* is given 2 counterparts \(2, 3\)"),
        ([[1, 2], [3, 2]], r"vertex 2 of .* is given 2 counterparts \(1, 3\)"),
        ([1, 2], "`landmarks` must be pairs"),
        ([[1.5, 2]], "`landmarks` must be pairs"),
        ([[1, 2], [3]], "`landmarks` must be pairs"),
        (["a", "b", "c"], "3 files|sets of landmarks|cannot be read|unknown ending"),
        (7, "`landmarks` must be pairs"),
    ],
)
def test_bad_landmarks_are_refused(copies, given, message):
    with pytest.raises((SettingsError, FormatError), match=message):
        mm.match(*copies[:2], landmarks=given)


def test_uniform_triplets_refuse_landmarks(copies):
    with pytest.raises(SettingsError, match="`landmarks` need guided proposals"):
        mm.match(*copies[:2], landmarks=[[0, 0]], proposal="uniform")


def test_repeated_and_inconsistent_landmarks_are_reported(copies):
    source, target, new = copies
    pairs = [[i, new[i]] for i in (0, 100, 200, 300, 400)]
    landmarks, notes = landmark_constraints([*pairs, pairs[1]], source, target)
    assert notes == ["landmarks: 1 repeated pair(s) ignored"]
    np.testing.assert_array_equal(landmarks.pairs, pairs)
    far = int(source.samples[source.distances[:, 0].argmax()])
    near = int(source.samples[0])
    _, notes = landmark_constraints([*pairs, [near, new[far]]], source, target)
    assert len(notes) == 1
    assert f"vertex {near} and array vertex {new[far]} from the other landmarks differ" in notes[0]


def written(folder, name, marks):
    path = folder / name
    (file_format,) = (form for form in FORMATS.values() if form.write_landmarks and name.endswith(form.endings[0]))
    path.write_bytes(file_format.write_landmarks(marks, "", "LPS"))
    return path


@pytest.mark.parametrize("ending", [form.endings[0] for form in FORMATS.values() if form.write_landmarks])
def test_two_files_are_paired_by_name_or_by_order(copies, tmp_path, ending):
    source, target, new = copies
    vertices = np.array([7, 70, 170])
    names = ["a", "b", "c"]
    on_source = Landmarks(names, None, source.mesh.vertices[vertices])
    on_target = Landmarks(names[::-1], None, target.mesh.vertices[new[vertices[::-1]]])
    if ending == ".morphologika":  # has no names
        on_target = Landmarks(names, None, target.mesh.vertices[new[vertices]])
    paths = [written(tmp_path, f"one{ending}", [on_source]), written(tmp_path, f"two{ending}", [on_target])]
    landmarks, notes = landmark_constraints(paths, source, target)
    assert notes == []
    np.testing.assert_array_equal(landmarks.pairs, np.column_stack([vertices, new[vertices]]))


def test_files_of_pairs_and_of_two_specimens(copies, tmp_path):
    source, target, new = copies
    chosen = np.array([7, 70])
    wanted = np.column_stack([chosen, new[chosen]])
    sides = [
        Landmarks(["1", "2"], None, surface.mesh.vertices[numbers], name)
        for surface, numbers, name in ((source, chosen, "one"), (target, new[chosen], "two"))
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
        landmarks, _ = landmark_constraints(path, source, target)
        np.testing.assert_array_equal(landmarks.pairs, wanted)
    landmarks, _ = landmark_constraints(tmp_path / "own.csv", source, target)
    np.testing.assert_array_equal(landmarks.pairs[:2], wanted)


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"a.tps": "LM3=1\n0 0 1\n"}, "1 sets of landmarks; give the source's and the target's"),
        ({"a.csv": "source,target\n1,b\n"}, r"a.csv: line 2: 'b' is not a number"),
        ({"a.csv": "source,target\n1,1.5\n"}, "have a number that is not an integer"),
        ({"a.csv": "x,y\n1,1\n"}, "has no columns x, y, z"),
        ({"a.csv": "x,y,z\n0,0,1\n", "b.csv": "x,y,z\n0,0,1\n1,0,0\n"}, None),
        ({"a.csv": "name,x,y,z\na,0,0,1\n", "b.csv": "name,x,y,z\nb,0,0,1\nc,1,0,0\n"}, "cannot be paired"),
        ({"a.pts": "Version 1.0\n1\nS 1 2\n", "b.pts": "Version 1.0\n1\nS 1 2 3\n"}, "a.pts, line 3: 2 numbers"),
        ({"a.csv": "vertex\n3\n", "b.csv": "vertex\n999\n"}, "has no vertex 999"),
    ],
)
def test_bad_files_of_landmarks(copies, tmp_path, files, message):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    paths = [tmp_path / name for name in files]
    if message is None:
        _, notes = landmark_constraints(paths, *copies[:2])
        assert any("ignored, on one side only: 2" in note for note in notes)
        return
    with pytest.raises((FormatError, SettingsError), match=message):
        landmark_constraints(paths, *copies[:2])


def test_landmarks_on_a_simplified_mesh_are_vertices_of_the_users_file(copies):
    shape = lump(4)
    (vertices, faces), new = renumbered(shape)
    one, two = (mm.prepare(mesh, resolution=600, samples=60) for mesh in (shape, (vertices, faces)))
    assert one.detail is not None
    result = mm.match(one, two, landmarks=[[1234, new[1234]]])
    np.testing.assert_array_equal(result.pairs[0], [1234, new[1234]])
    assert result.dense().vertex_map[1234] == new[1234]


def test_landmarks_off_the_surface_are_reported(copies, tmp_path):
    source, target, new = copies
    positions = source.mesh.vertices[[7, 70]]
    on_source = Landmarks(["nose", "tail"], None, positions + np.array([[0, 0, 0], [9, 0, 0]]))
    on_target = Landmarks(["nose", "tail"], None, target.mesh.vertices[new[[7, 70]]])
    paths = [written(tmp_path, f"{k}.csv", [side]) for k, side in enumerate((on_source, on_target))]
    _, notes = landmark_constraints(paths, source, target)
    assert "1 landmarks are off the surface of array (the first is tail)" in notes[0]
