"""The known correspondence of one pair of meshes, from a file or from the folder of a set that holds the pair."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..errors import FormatError
from .datasets import FEW, Truth, find_dataset
from .vertexlists import read_lines, read_table, read_vertices


def read_truth(path: str | os.PathLike[str], source: str | None, target: str | None, vertices: int) -> Truth:
    """Read which vertices of two meshes are known to correspond.

    Parameters
    ----------
    path
        Text of one of two kinds, numbers from 0: lines ``SOURCE TARGET``, or a line for each vertex of the source with
        its target vertex, -1 for none, as ``mobius match --dense`` writes. Or a CSV file with columns ``source`` and
        ``target``. Or a folder or manifest that :func:`find_dataset` knows, in which the pair is looked up.
    source, target
        Paths of the meshes, None for arrays.
    vertices
        How many the source's file has.

    Raises
    ------
    FormatError
        The file is none of these, is damaged, or does not have the pair.
    """
    path = Path(path)
    if path.is_dir():
        return _of_set(path, source, target)
    if path.suffix.lower() == ".csv":
        if "source_landmarks" in (read_lines(path) or [""])[0]:
            return _of_set(path, source, target)
        rows = [(line, [row["source"], row["target"]]) for line, row in read_table(path, ("source", "target"))]
    else:
        split = ((number, line.split("#")[0].split()) for number, line in enumerate(read_lines(path), start=1))
        rows = [(number, words) for number, words in split if words]
    if not rows:
        raise FormatError(f"{path}: holds no vertex numbers; give a pair a line.")
    if all(len(words) == 1 for _, words in rows):
        found = read_vertices(path, 0, gaps=True)
        if len(found) != vertices:
            raise FormatError(
                f"{path}: has {len(found)} lines and the source {vertices} vertices; give a line for each, -1 for "
                "none, or pairs 'SOURCE TARGET'."
            )
        known = np.flatnonzero(found >= 0)
        pairs = np.stack([known, found[known]], axis=1)
    else:
        pairs = np.array([_pair(path, line, words) for line, words in rows], np.int64)
    if not len(pairs):
        raise FormatError(f"{path}: no vertex has a counterpart; the list is of no use.")
    return Truth(pairs[:, 0], pairs[:, 1], landmarks=len(pairs) < FEW)


def _pair(path: Path, line: int, words: list[str]) -> list[int]:
    if len(words) != 2:
        raise FormatError(
            f"{path}, line {line}: {len(words)} words, where two vertex numbers, of source and target, are expected. "
            "(For lists of vertices, one for each mesh, give the folder of the set.)"
        )
    try:
        numbers = [int(word) for word in words]
    except ValueError:
        raise FormatError(f"{path}, line {line}: {' '.join(words)!r} are not two vertex numbers.") from None
    if min(numbers) < 0:
        raise FormatError(f"{path}, line {line}: vertex {min(numbers)}; vertices are numbered from 0.")
    return numbers


def _of_set(path: Path, source: str | None, target: str | None) -> Truth:
    """The pair as it stands in a set, or turned round; meshes are told by their path, else by their name."""
    wanted = [None if mesh is None else Path(mesh) for mesh in (source, target)]
    cases = find_dataset(path).cases
    for same in (_same_file, _same_name):
        for case in cases:
            if same(case.source, wanted[0]) and same(case.target, wanted[1]):
                return case.truth
            if same(case.source, wanted[1]) and same(case.target, wanted[0]):
                return Truth(case.truth.target, case.truth.source, landmarks=case.truth.landmarks)
    names = " and ".join("an array" if mesh is None else mesh.name for mesh in wanted)
    raise FormatError(
        f"{path}: {names} are none of its {len(cases)} pairs, of which {cases[0].source.name} and "
        f"{cases[0].target.name} are the first. Name another folder, or a file of pairs."
    )


def _same_file(mesh: Path, wanted: Path | None) -> bool:
    return wanted is not None and mesh.resolve() == wanted.resolve()


def _same_name(mesh: Path, wanted: Path | None) -> bool:
    return wanted is not None and mesh.name == wanted.name
