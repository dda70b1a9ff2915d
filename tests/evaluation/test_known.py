"""Known correspondence of one pair, from lists and from data sets."""

import numpy as np
import pytest

from mobius_match import FormatError
from mobius_match.evaluation import read_truth

PAIRS = np.array([[0, 3], [2, 1], [5, 0]])


def read(path, vertices=6, source=None, target=None):
    truth = read_truth(path, source, target, vertices)
    return np.stack([truth.source, truth.target], axis=1).tolist(), truth.landmarks


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("pairs.txt", "# source target\n0 3\n\n2\t1  # a foot\n5 0\n"),
        ("pairs.csv", "target,confidence,source\n3,1,0\n1,,2\n0,0.5,5\n"),
        ("dense.txt", "3\n-1\n1\n-1\n-1\n0\n"),
    ],
)
def test_lists_of_one_pair(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    assert read(tmp_path / name) == (PAIRS.tolist(), True)


def test_many_pairs_cover_the_surface(tmp_path):
    path = tmp_path / "dense.txt"
    path.write_text("".join(f"{i}\n" for i in range(300)))
    pairs, landmarks = read(path, 300)
    assert pairs == [[i, i] for i in range(300)]
    assert not landmarks


@pytest.fixture
def folder(tmp_path):
    """A set of two shapes with lists that count from 1."""
    for name, numbers in (("a", "1\n2\n3\n"), ("b", "3\n1\n2\n")):
        (tmp_path / f"{name}0.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        (tmp_path / "corres").mkdir(exist_ok=True)
        (tmp_path / "corres" / f"{name}0.vts").write_text(numbers)
    (tmp_path / "pairs.txt").write_text("a0 b0\n")
    return tmp_path


def test_a_data_set_has_the_pair_in_both_directions_and_by_name(folder):
    source, target = str(folder / "a0.off"), str(folder / "b0.off")
    assert read(folder, 3, source, target)[0] == [[0, 2], [1, 0], [2, 1]]
    assert read(folder, 3, target, source)[0] == [[2, 0], [0, 1], [1, 2]]
    assert read(folder, 3, "/elsewhere/a0.off", "b0.off")[0] == [[0, 2], [1, 0], [2, 1]]


def test_a_manifest_gives_the_pair(folder):
    (folder / "list.csv").write_text(
        "source,target,source_landmarks,target_landmarks,base\na0.off,b0.off,corres/a0.vts,corres/b0.vts,1\n"
    )
    assert read(folder / "list.csv", 3, "a0.off", "b0.off") == ([[0, 2], [1, 0], [2, 1]], True)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("t.txt", "0 1\n2 x\n", r"t\.txt, line 2: '2 x'"),
        ("t.txt", "0 1\n-1 2\n", "line 2: vertex -1"),
        ("t.txt", "0 1 2\n", "line 1: 3 words"),
        ("t.txt", "0 1.0 2.0 3.0\n", "folder of the data set"),
        ("t.txt", "1\n2\n", "2 lines and the source 6 vertices"),
        ("t.txt", "-1\n" * 6, "no vertex has a counterpart"),
        ("t.txt", "# nothing\n", "holds no vertex numbers"),
        ("t.txt", "1\ntwo\n", "line 2: 'two'"),
        ("t.csv", "source,other\n1,2\n", "no column 'target'"),
        ("t.csv", "source,target\n1,\n", "line 2"),
    ],
)
def test_errors_name_the_line(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=words):
        read(tmp_path / name)


def test_a_set_without_the_pair_says_so(folder):
    with pytest.raises(FormatError, match=r"a0\.off and c\.off are none of its 1 pairs"):
        read(folder, 3, "a0.off", "c.off")
    with pytest.raises(FormatError, match="an array"):
        read(folder, 3, None, "b0.off")
    with pytest.raises(FormatError, match="cannot be read"):
        read(folder / "nowhere.txt")
