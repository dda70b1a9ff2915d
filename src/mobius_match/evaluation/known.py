"""The known correspondence of one pair of meshes, from a file or from a data set that contains the pair."""

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
        One of: a text file with lines ``SOURCE TARGET``, vertices counting from 0; a text file with one line for each
        vertex of the source, its target vertex or -1 for none, as :meth:`mobius_match.SurfaceMap.save` writes; a CSV
        file with columns ``source`` and ``target``; a folder or manifest as for :func:`find_dataset`, which contains
        the pair.
    source, target
        Paths of the meshes; None for arrays.
    vertices
        Number of vertices in the source's file.

    Raises
    ------
    FormatError
        If the file is none of these, is damaged, or does not contain the pair.
    """
    path = Path(path)
    if path.is_dir():
        return _from_dataset(path, source, target)
    if path.suffix.lower() == ".csv":
        if "source_landmarks" in (read_lines(path) or [""])[0]:
            return _from_dataset(path, source, target)
        rows = [(line, [row["source"], row["target"]]) for line, row in read_table(path, ("source", "target"))]
    else:
        split = ((number, line.split("#")[0].split()) for number, line in enumerate(read_lines(path), start=1))
        rows = [(number, words) for number, words in split if words]
    if not rows:
        raise FormatError(f"{path}: holds no vertex numbers; give one pair per line.")
    if all(len(words) == 1 for _, words in rows):
        targets = read_vertices(path, 0, gaps=True)
        if len(targets) != vertices:
            raise FormatError(
                f"{path}: has {len(targets)} lines and the source {vertices} vertices; give one line for each vertex, "
                "-1 for none, or pairs 'SOURCE TARGET'."
            )
        known = np.flatnonzero(targets >= 0)
        pairs = np.stack([known, targets[known]], axis=1)
    else:
        pairs = np.array([_pair(path, line, words) for line, words in rows], np.int64)
    if not len(pairs):
        raise FormatError(f"{path}: no vertex has a counterpart.")
    return Truth(pairs[:, 0], pairs[:, 1], landmarks=len(pairs) < FEW)


def _pair(path: Path, line: int, words: list[str]) -> list[int]:
    if len(words) != 2:
        raise FormatError(
            f"{path}, line {line}: {len(words)} words; give two vertex numbers, of source and target. (For vertex "
            "lists, one for each mesh, give the folder of the data set.)"
        )
    try:
        numbers = [int(word) for word in words]
    except ValueError:
        raise FormatError(f"{path}, line {line}: {' '.join(words)!r} are not two vertex numbers.") from None
    if min(numbers) < 0:
        raise FormatError(f"{path}, line {line}: vertex {min(numbers)}; vertices are numbered from 0.")
    return numbers


def _from_dataset(path: Path, source: str | None, target: str | None) -> Truth:
    """The pair of a data set in either direction; meshes are compared by path, then by file name."""
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
        f"{path}: {names} are none of its {len(cases)} pairs, the first of which is {cases[0].source.name} and "
        f"{cases[0].target.name}. Give another folder, or a file of pairs."
    )


def _same_file(mesh: Path, wanted: Path | None) -> bool:
    return wanted is not None and mesh.resolve() == wanted.resolve()


def _same_name(mesh: Path, wanted: Path | None) -> bool:
    return wanted is not None and mesh.name == wanted.name
