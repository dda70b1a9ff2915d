"""Pairs of shapes with known correspondence, in the layouts in which such data sets are published.

The layout of a folder is the first of these that fits:

manifest
    ``manifest.csv``, or any CSV file given instead of a folder. Columns ``source``, ``target`` (mesh files),
    ``source_landmarks``, ``target_landmarks`` (vertex lists of equal length, line i of both is the same point) and
    optionally ``mirrored_landmarks`` (the target's list with left and right exchanged), ``category`` and ``base``.
    Paths are relative to the CSV file. Vertex lists are read by :func:`read_vertices`: one number per line, or CSV
    with a column ``vertex``. ``base`` is 0 or 1, the number of the first vertex in the lists of that row; it is
    optional for lists with lines ``vertex x y z``, which count from 0.
vertex lists
    ``corres/NAME.vts`` for the mesh ``NAME.off`` (or another mesh format), numbers from 1; line i of two lists is
    the same point. ``corres/NAME.sym.vts``, if it exists, is the same list with left and right exchanged.
landmarks
    ``NAME.vts`` beside the mesh, lines ``vertex x y z``, numbers from 0.
same numbering
    Only meshes, which have equal numbers of vertices within a category: vertex i corresponds to vertex i, as in the
    published TOSCA, SCAPE and FAUST.

Pairs are listed in ``pairs.txt`` in the folder (two names per line, with or without the file's ending), or in another
file of that format; without a list they are all pairs within each category. The category is the name of the mesh
without leading and trailing numbers: ``cat`` of ``cat0``, ``man`` of ``8_man_01``; if nothing is left, the name of the
folder.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np

from .._core.display import one_line
from ..errors import FormatError, SettingsError
from ..mesh.files import READERS, read_mesh
from .vertexlists import read_lines, read_table, read_vertices

FEW = 200
"""Shorter vertex lists of a manifest are landmarks; longer ones cover the whole surface."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Known correspondence of two meshes.

    Parameters
    ----------
    source, target
        (L,) int64 vertex numbers from 0 in the user's files; entry i of both is the same point.
    mirrored
        (L,) int64 or None: the target's vertices with left and right exchanged.
    landmarks
        Whether these are a few selected points instead of points all over the surface.
    """

    source: np.ndarray
    target: np.ndarray
    mirrored: np.ndarray | None = None
    landmarks: bool = False

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Case:
    """One pair of shapes: its name, its category, both mesh files, and the known correspondence."""

    name: str
    category: str
    source: Path
    target: Path
    truth: Truth

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Dataset:
    """A data set: its folder or manifest, its layout, and its pairs in order."""

    path: Path
    layout: str
    cases: tuple[Case, ...]

    def __repr__(self) -> str:
        return one_line(self)


def find_dataset(folder: str | os.PathLike[str], pairs: str | os.PathLike[str] | None = None) -> Dataset:
    """The pairs of a folder. Its layout is detected; see the module ``mobius_match.evaluation.datasets``.

    Parameters
    ----------
    folder
        A folder, or a manifest (CSV file).
    pairs
        File of pairs to use instead of the folder's ``pairs.txt``.

    Raises
    ------
    FormatError
        If no layout fits, or a file is missing or damaged.
    SettingsError
        If ``pairs`` is given with a manifest, which lists its own.
    """
    folder = Path(folder)
    if not folder.exists():
        raise FormatError(f"{folder}: no such folder or file. Check the path.")
    for detector in (_manifest, _vertex_lists, _landmarks, _same_numbering):
        dataset = detector(folder, None if pairs is None else Path(pairs))
        if dataset is not None:
            return dataset
    endings = ", ".join(READERS)
    raise FormatError(
        f"{folder}: no pairs with known correspondence. A data set is one of: manifest.csv; meshes ({endings}) with "
        "corres/NAME.vts; meshes with NAME.vts beside them; at least two meshes whose names differ only in their "
        "numbers and that have equal numbers of vertices."
    )


def _manifest(folder: Path, pairs: Path | None) -> Dataset | None:
    path = folder / "manifest.csv" if folder.is_dir() else folder
    if not path.is_file():
        return None
    if pairs is not None:
        raise SettingsError(f"`pairs` cannot be given with {path}, a manifest, which lists its own pairs")
    cases: list[Case] = []
    for line, row in read_table(path, ("source", "target", "source_landmarks", "target_landmarks")):
        base = row.get("base") or None
        if base not in (None, "0", "1"):
            raise FormatError(f"{path}, line {line}: base is {base!r}; it must be 0 or 1.")
        mirrored = row.get("mirrored_landmarks")
        files = [row["source_landmarks"], row["target_landmarks"], *([mirrored] if mirrored else [])]
        lists = [read_vertices(path.parent / file, None if base is None else int(base)) for file in files]
        _check_lengths(f"{path}, line {line}", files, lists)
        meshes = path.parent / row["source"], path.parent / row["target"]
        for mesh in meshes:
            if not mesh.is_file():
                raise FormatError(f"{path}, line {line}: there is no mesh {mesh}.")
        truth = Truth(lists[0], lists[1], lists[2] if mirrored else None, landmarks=len(lists[0]) < FEW)
        cases.append(_case(cases, *meshes, truth, row.get("category")))
    if not cases:
        raise FormatError(f"{path}: lists no pairs. Add a line for each.")
    return Dataset(path, "manifest", tuple(cases))


def _vertex_lists(folder: Path, pairs: Path | None) -> Dataset | None:
    lists = folder / "corres"
    if not any(lists.glob("*.vts")):
        return None

    @cache
    def read(path: Path) -> np.ndarray:
        return read_vertices(path, base=1)

    def truth(source: Path, target: Path) -> Truth:
        files = [lists / f"{source.stem}.vts", lists / f"{target.stem}.vts"]
        mirrored = lists / f"{target.stem}.sym.vts"
        files += [mirrored] if mirrored.is_file() else []
        vertices = [read(file) for file in files]
        _check_lengths(str(lists), [file.name for file in files], vertices)
        return Truth(vertices[0], vertices[1], vertices[2] if len(vertices) == 3 else None)

    shapes = _meshes(folder, lambda mesh: (lists / f"{mesh.stem}.vts").is_file())
    return _dataset(folder, "vertex lists", shapes, pairs, truth)


def _landmarks(folder: Path, pairs: Path | None) -> Dataset | None:
    shapes = _meshes(folder, lambda mesh: mesh.with_suffix(".vts").is_file())
    if not shapes:
        return None

    @cache
    def read(path: Path) -> np.ndarray:
        return read_vertices(path, base=None)

    def truth(source: Path, target: Path) -> Truth:
        files = [source.with_suffix(".vts"), target.with_suffix(".vts")]
        vertices = [read(file) for file in files]
        _check_lengths(str(folder), [file.name for file in files], vertices)
        return Truth(vertices[0], vertices[1], landmarks=True)

    return _dataset(folder, "landmarks", shapes, pairs, truth)


def _same_numbering(folder: Path, pairs: Path | None) -> Dataset | None:
    shapes = _meshes(folder, lambda mesh: True)
    if len(shapes) < 2:
        return None

    @cache
    def vertices(path: Path) -> int:
        return read_mesh(path).n_file_vertices

    all_vertices = cache(lambda count: np.arange(count, dtype=np.int64))

    def truth(source: Path, target: Path) -> Truth:
        counts = vertices(source), vertices(target)
        if counts[0] != counts[1]:
            raise FormatError(
                f"{folder}: {source.name} has {counts[0]} vertices and {target.name} has {counts[1]}, so their "
                "vertices do not correspond by number, and there are no vertex lists (corres/NAME.vts or NAME.vts)."
            )
        return Truth(all_vertices(counts[0]), all_vertices(counts[0]))

    return _dataset(folder, "same numbering", shapes, pairs, truth)


def _meshes(folder: Path, wanted: Callable[[Path], bool]) -> dict[str, Path]:
    """The mesh files of a folder by name without ending, in natural order (cat2 before cat10)."""
    if not folder.is_dir():
        return {}
    meshes: dict[str, Path] = {}
    for path in sorted(folder.iterdir(), key=_natural_order):
        if path.suffix.lower() in READERS and path.is_file() and wanted(path):
            if path.stem in meshes:
                raise FormatError(f"{folder}: {meshes[path.stem].name} and {path.name} have one name. Remove one.")
            meshes[path.stem] = path
    return meshes


def _natural_order(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _dataset(
    folder: Path, layout: str, shapes: dict[str, Path], pairs: Path | None, truth: Callable[[Path, Path], Truth]
) -> Dataset | None:
    """The cases of the pairs file, or of all pairs within each category."""
    listed = folder / "pairs.txt" if pairs is None else pairs
    if pairs is not None or listed.is_file():
        chosen = _read_pairs(listed, folder, shapes)
    else:
        chosen = [pair for pair in combinations(shapes.values(), 2) if category(pair[0]) == category(pair[1])]
    cases: list[Case] = []
    for source, target in chosen:
        cases.append(_case(cases, source, target, truth(source, target)))
    return Dataset(folder, layout, tuple(cases)) if cases else None


def _read_pairs(path: Path, folder: Path, shapes: dict[str, Path]) -> list[tuple[Path, Path]]:
    known = {**shapes, **{file.name: file for file in shapes.values()}}
    chosen = []
    for number, line in enumerate(read_lines(path), start=1):
        names = line.split("#")[0].split()
        if not names:
            continue
        if len(names) != 2:
            raise FormatError(f"{path}, line {number}: {len(names)} names; give two, the source and the target.")
        for name in names:
            if name not in known:
                raise FormatError(
                    f"{path}, line {number}: {folder} has no mesh {name!r} with known correspondence; "
                    f"it has {', '.join(shapes) or 'none'}."
                )
        chosen.append((known[names[0]], known[names[1]]))
    if not chosen:
        raise FormatError(f"{path}: lists no pairs. Add a line 'SOURCE TARGET' for each.")
    return chosen


def category(mesh: Path) -> str:
    """The category in a mesh's name, ``cat`` of ``cat0.off``, ``man`` of ``8_man_01.off``; else the folder's name."""
    return re.sub(r"^[\d_.-]+|[\d_.-]+$", "", mesh.stem) or mesh.resolve().parent.name


def _case(earlier: list[Case], source: Path, target: Path, truth: Truth, given: str | None = None) -> Case:
    """A case with a unique name, which is also the name of its file."""
    names = {case.name for case in earlier}
    name = base_name = f"{source.stem}-{target.stem}"
    number = 2
    while name in names:
        name, number = f"{base_name}-{number}", number + 1
    both = category(source), category(target)
    return Case(name, given or (both[0] if both[0] == both[1] else "-".join(both)), source, target, truth)


def _check_lengths(place: str, names: list[str], lists: list[np.ndarray]) -> None:
    for name, values in zip(names, lists, strict=True):
        if len(values) != len(lists[0]):
            raise FormatError(
                f"{place}: {names[0]} lists {len(lists[0])} points and {name} {len(values)}; "
                "line i of both must be the same point, so the lists must be equally long."
            )
