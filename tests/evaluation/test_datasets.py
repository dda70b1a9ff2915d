"""Detection of the layouts of data sets, and the errors for malformed ones."""

import numpy as np
import pytest

from mobius_match.errors import FormatError, SettingsError
from mobius_match.evaluation import find_dataset

HEADER = "source,target,source_landmarks,target_landmarks\n"
BASE = HEADER.strip() + ",base\n"
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 2 1\n0 1 3\n1 2 3\n0 3 2\n"


def meshes(folder, *names, content=TETRAHEDRON):
    for name in names:
        path = folder / (name if "." in name else f"{name}.off")
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(content)


def lists(folder, **content):
    folder.mkdir(exist_ok=True)
    for name, text in content.items():
        (folder / f"{name.replace('_sym', '.sym')}.vts").write_text(text)


def names(dataset):
    return [case.name for case in dataset.cases]


def test_vertex_lists_count_from_one(tmp_path):
    meshes(tmp_path, "cat0", "cat10", "cat2", "dog1", "dog2", "cat7")
    lists(tmp_path / "corres", cat0="1\n2\n4\n", cat2="2\n1\n3\n", cat10="4\n3\n2\n", cat10_sym="4\n2\n3\n")
    lists(tmp_path / "corres", dog1="1\n2\n", dog2="4\n3\n", dog2_sym="3\n4\n")
    found = find_dataset(tmp_path)
    assert found.layout == "vertex lists"
    # cat7 has no list; cat10 comes after cat2
    assert names(found) == ["cat0-cat2", "cat0-cat10", "cat2-cat10", "dog1-dog2"]
    case = found.cases[1]
    assert (case.category, case.source, case.target) == ("cat", tmp_path / "cat0.off", tmp_path / "cat10.off")
    assert case.truth.source.tolist() == [0, 1, 3]
    assert case.truth.target.tolist() == [3, 2, 1]
    assert case.truth.mirrored.tolist() == [3, 1, 2]
    assert not case.truth.landmarks
    assert found.cases[0].truth.mirrored is None
    assert found.cases[3].truth.mirrored.tolist() == [2, 3]


def test_pairs_file_of_the_folder_or_another(tmp_path):
    meshes(tmp_path, "8_man_01", "8_man_03", "8_gorilla_01")
    lists(tmp_path / "corres", **dict.fromkeys(("8_man_01", "8_man_03", "8_gorilla_01"), "1\n2\n"))
    (tmp_path / "pairs.txt").write_text("# across\n8_gorilla_01\t8_man_03\n\n8_man_03.off 8_man_01  # by file name\n")
    found = find_dataset(tmp_path)
    assert names(found) == ["8_gorilla_01-8_man_03", "8_man_03-8_man_01"]
    assert [case.category for case in found.cases] == ["gorilla-man", "man"]
    (tmp_path / "other.txt").write_text("8_man_01 8_man_03\n8_man_01 8_man_03\n")
    assert names(find_dataset(tmp_path, tmp_path / "other.txt")) == ["8_man_01-8_man_03", "8_man_01-8_man_03-2"]


def test_landmarks_beside_the_meshes_count_from_zero(tmp_path):
    meshes(tmp_path / "four legs", "381.off", "385.ply")
    lists(tmp_path / "four legs", **{"381": "0 0 0 0\n3 0 0 1\n", "385": " 2 0 1 0\n 0 0 0 0\n"})
    found = find_dataset(tmp_path / "four legs")
    assert found.layout == "landmarks"
    (case,) = found.cases
    assert (case.name, case.category) == ("381-385", "four legs")
    assert case.truth.landmarks
    assert case.truth.source.tolist() == [0, 3]
    assert case.truth.target.tolist() == [2, 0]


def test_same_numbering(tmp_path):
    meshes(tmp_path, "cat0", "cat1", "cat2", "dog0")
    found = find_dataset(tmp_path)
    assert found.layout == "same numbering"
    assert names(found) == ["cat0-cat1", "cat0-cat2", "cat1-cat2"]
    for case in found.cases:
        assert case.truth.source.tolist() == case.truth.target.tolist() == [0, 1, 2, 3]
        assert case.truth.mirrored is None


@pytest.mark.parametrize("as_file", [True, False])
def test_manifest(tmp_path, as_file):
    meshes(tmp_path / "shapes", "a", "b")
    (tmp_path / "a.txt").write_text("1  # the nose\n4\n")
    (tmp_path / "b.csv").write_text("name,vertex\nnose,2\ntail,3\n")
    lists(tmp_path, a="0 0 0 0\n3 0 0 1\n", b="1 1 0 0\n2 0 1 0\n")
    (tmp_path / "long.txt").write_text("0\n" * 200)
    path = tmp_path / "manifest.csv"
    path.write_text(
        "source, target, source_landmarks, target_landmarks, mirrored_landmarks, base, category\n"
        "shapes/a.off, shapes/b.off, a.txt, b.csv, a.txt, 1, things\n"
        "shapes/b.off, shapes/a.off, b.vts, a.vts, , ,\n"
        "shapes/a.off, shapes/b.off, long.txt, long.txt, , 0,\n"
    )
    found = find_dataset(path if as_file else tmp_path)
    assert (found.layout, found.path) == ("manifest", path)
    assert names(found) == ["a-b", "b-a", "a-b-2"]
    assert [case.category for case in found.cases] == ["things", "b-a", "a-b"]
    assert [case.truth.source.tolist()[:2] for case in found.cases] == [[0, 3], [1, 2], [0, 0]]
    assert [case.truth.target.tolist()[:2] for case in found.cases] == [[1, 2], [0, 3], [0, 0]]
    assert found.cases[0].truth.mirrored.tolist() == [0, 3]
    assert found.cases[1].truth.mirrored is None
    assert [case.truth.landmarks for case in found.cases] == [True, True, False]


def refused(path, *words, pairs=None, error=FormatError):
    with pytest.raises(error) as caught:
        find_dataset(path, pairs)
    for word in words:
        assert str(word) in str(caught.value)


def test_a_folder_of_no_known_layout(tmp_path):
    refused(tmp_path, tmp_path, "manifest.csv", "corres/NAME.vts", "NAME.vts beside them", "equal numbers of vertices")
    meshes(tmp_path, "cat0", "dog0")  # nothing to pair
    refused(tmp_path, "corres/NAME.vts")
    refused(tmp_path / "none", "no such folder", tmp_path / "none")


def test_meshes_of_different_numbering(tmp_path):
    meshes(tmp_path, "cat0")
    meshes(tmp_path, "cat1", content="OFF\n5 4 0\n0 0 0\n" + TETRAHEDRON.split("\n", 2)[2])
    refused(tmp_path, "cat0.off has 4 vertices and cat1.off has 5")


def test_two_files_of_one_shape(tmp_path):
    meshes(tmp_path, "cat0.off", "cat0.ply", "cat1.off")
    refused(tmp_path, "cat0.off", "cat0.ply")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("1\n2\nthree\n", ["cat1.vts, line 3", "'three'"]),
        ("1\n0\n2\n", ["cat1.vts, line 2", "vertex 0", "from 1"]),
        ("1\n-1\n2\n", ["cat1.vts, line 2", "vertex -1"]),
        ("1\n2\n", ["cat0.vts lists 3 points and cat1.vts 2"]),
        ("# nothing\n", ["cat1.vts", "no vertex numbers"]),
        ("1.5\n2\n2\n", ["cat1.vts, line 1", "'1.5'"]),
    ],
)
def test_bad_vertex_lists(tmp_path, content, words):
    meshes(tmp_path, "cat0", "cat1")
    lists(tmp_path / "corres", cat0="1\n2\n3\n", cat1=content)
    refused(tmp_path, *words)


def test_a_vertex_list_that_is_no_text(tmp_path):
    meshes(tmp_path, "cat0", "cat1")
    lists(tmp_path / "corres", cat0="1\n2\n", cat1="")
    (tmp_path / "corres" / "cat1.vts").write_bytes(b"\xff\xfe\x00\x81")
    refused(tmp_path, "cat1.vts", "text")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("cat0 cat1 cat1\n", ["line 1", "3 names"]),
        ("\ncat0 cat9\n", ["line 2", "'cat9'", "cat0, cat1"]),
        ("# nothing\n", ["lists no pairs"]),
    ],
)
def test_bad_pairs_file(tmp_path, content, words):
    meshes(tmp_path, "cat0", "cat1")
    (tmp_path / "pairs.txt").write_text(content)
    refused(tmp_path, "pairs.txt", *words)
    (tmp_path / "pairs.txt").unlink()
    refused(tmp_path, "pairs.txt", pairs=tmp_path / "pairs.txt")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("source,target\na.off,b.off\n", ["no column 'source_landmarks'"]),
        ("", ["no column 'source'"]),
        (HEADER, ["lists no pairs"]),
        (
            HEADER + "a.off,b.off,a.txt\n",
            ["line 2", "'target_landmarks' is empty"],
        ),
        (HEADER + "a.off,b.off,a.txt,a.txt\n", ["a.txt", "from 0 or from 1"]),
        (
            BASE + "a.off,b.off,a.txt,a.txt,2\n",
            ["line 2", "base is '2'"],
        ),
        (BASE + "a.off,c.off,a.txt,a.txt,0\n", ["line 2", "c.off"]),
        (
            BASE + "a.off,b.off,a.txt,b.txt,0\n",
            ["line 2", "lists 2 points"],
        ),
        (
            BASE + "a.off,b.off,a.txt,no.txt,0\n",
            ["no.txt", "cannot be read"],
        ),
        (BASE + "a.off,b.off,a.txt,x.csv,0\n", ["x.csv", "'vertex'"]),
    ],
)
def test_bad_manifest(tmp_path, content, words):
    meshes(tmp_path, "a", "b")
    (tmp_path / "a.txt").write_text("1\n2\n")
    (tmp_path / "b.txt").write_text("1\n")
    (tmp_path / "x.csv").write_text("number\n1\n2\n")
    (tmp_path / "manifest.csv").write_text(content)
    refused(tmp_path, *words)


def test_a_manifest_takes_no_other_pairs(tmp_path):
    (tmp_path / "manifest.csv").write_text("source\n")
    refused(tmp_path, "`pairs`", "manifest", pairs=tmp_path / "pairs.txt", error=SettingsError)


def test_equal_correspondences_share_memory(tmp_path):
    meshes(tmp_path, "cat0", "cat1", "cat2")
    cases = find_dataset(tmp_path).cases
    assert all(np.shares_memory(case.truth.source, cases[0].truth.target) for case in cases)
