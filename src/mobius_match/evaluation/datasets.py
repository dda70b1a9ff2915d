"""Pairs of shapes with known correspondence, in the layouts in which such sets are published.

A folder is looked at for these, in this order; the first that fits is taken:

manifest
    ``manifest.csv``, or any CSV file given instead of a folder. Columns ``source``, ``target`` (mesh files),
    ``source_landmarks``, ``target_landmarks`` (vertex lists of equal length, line i is the same point) and, if
    wanted, ``mirrored_landmarks`` (the target's list with left and right exchanged), ``category`` and ``base``.
    Paths are relative to the CSV file. Vertex lists are read by :func:`read_vertices`: a number a line, or CSV with
    a column ``vertex``. ``base`` is 0 or 1, the number of the first vertex in that row's lists; it may be left
    out where the lists have lines ``vertex x y z``, which count from 0.
vertex lists
    ``corres/NAME.vts`` for the mesh ``NAME.off`` (or another mesh format), numbers from 1; line i of two lists is
    the same point. ``corres/NAME.sym.vts``, if it is there, is the same list with left and right exchanged.
landmarks
    ``NAME.vts`` beside the mesh, lines ``vertex x y z``, numbers from 0.
same numbering
    Meshes alone, with as many vertices as the others of their category: vertex i is vertex i, as TOSCA, SCAPE and
    FAUST are published.

Pairs are those of ``pairs.txt`` in the folder (two names a line, without or with the file's ending), or of another
file in that format, or else all pairs within each category. The category is the mesh's name without the numbers
around it: ``cat`` of ``cat0``, ``man`` of ``8_man_01``; where nothing is left, the folder's name.
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
"""A manifest's lists shorter than this are landmarks, longer ones stand for the whole surface."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Known correspondence of two meshes.

    Parameters
    ----------
    source, target
        (L,) int64 vertex numbers from 0 in the user's files: entry i of both is the same point.
    mirrored
        (L,) int64 or None: the same for the target with left and right exchanged.
    landmarks
        Whether these are a few chosen points, rather than points all over the surface.
    """

    source: np.ndarray
    target: np.ndarray
    mirrored: np.ndarray | None = None
    landmarks: bool = False

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Case:
    """One pair of shapes: its name, its category, the two mesh files, and the truth."""

    name: str
    category: str
    source: Path
    target: Path
    truth: Truth

    def __repr__(self) -> str:
        return one_line(self)


@dataclass(frozen=True, eq=False)
class Dataset:
    """Pairs of shapes: where they were found, in which layout, and the pairs in order."""

    path: Path
    layout: str
    cases: tuple[Case, ...]

    def __repr__(self) -> str:
        return one_line(self)


def find_dataset(folder: str | os.PathLike[str], pairs: str | os.PathLike[str] | None = None) -> Dataset:
    """The pairs of a folder, whose layout is found by looking (the module's text says which there are).

    Parameters
    ----------
    folder
        A folder, or a manifest (CSV file).
    pairs
        File of pairs to take instead of the folder's ``pairs.txt``.

    Raises
    ------
    FormatError
        No known layout, or a file in it that is missing or damaged.
    SettingsError
        ``pairs`` was given with a manifest, which has its own.
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
        f"{folder}: no pairs with known correspondence were found. Looked for manifest.csv; for meshes ({endings}) "
        "with corres/NAME.vts; for meshes with NAME.vts beside them; and for at least two meshes whose names differ "
        "only in their numbers and that have equally many vertices. See 'mobius bench --help'."
    )


def _manifest(given: Path, pairs: Path | None) -> Dataset | None:
    path = given / "manifest.csv" if given.is_dir() else given
    if not path.is_file():
        return None
    if pairs is not None:
        raise SettingsError(f"--pairs: {path} is a manifest, which lists its own pairs; leave one of the two out")
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
        twin = lists / f"{target.stem}.sym.vts"
        files += [twin] if twin.is_file() else []
        found = [read(file) for file in files]
        _check_lengths(str(lists), [file.name for file in files], found)
        return Truth(found[0], found[1], found[2] if len(found) == 3 else None)

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
        found = [read(file) for file in files]
        _check_lengths(str(folder), [file.name for file in files], found)
        return Truth(found[0], found[1], landmarks=True)

    return _dataset(folder, "landmarks", shapes, pairs, truth)


def _same_numbering(folder: Path, pairs: Path | None) -> Dataset | None:
    shapes = _meshes(folder, lambda mesh: True)
    if len(shapes) < 2:
        return None

    @cache
    def vertices(path: Path) -> int:
        return read_mesh(path).n_file_vertices

    everything = cache(lambda count: np.arange(count, dtype=np.int64))

    def truth(source: Path, target: Path) -> Truth:
        counts = vertices(source), vertices(target)
        if counts[0] != counts[1]:
            raise FormatError(
                f"{folder}: {source.name} has {counts[0]} vertices and {target.name} has {counts[1]}, so their "
                "vertices do not correspond by number, and there are no lists (corres/NAME.vts or NAME.vts) either."
            )
        return Truth(everything(counts[0]), everything(counts[0]))

    return _dataset(folder, "same numbering", shapes, pairs, truth)


def _meshes(folder: Path, wanted: Callable[[Path], bool]) -> dict[str, Path]:
    """Mesh files of a folder by their name without ending, in natural order (cat2 before cat10)."""
    if not folder.is_dir():
        return {}
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir(), key=_natural):
        if path.suffix.lower() in READERS and path.is_file() and wanted(path):
            if path.stem in found:
                raise FormatError(f"{folder}: {found[path.stem].name} and {path.name} have one name. Remove one.")
            found[path.stem] = path
    return found


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _dataset(
    folder: Path, layout: str, shapes: dict[str, Path], pairs: Path | None, truth: Callable[[Path, Path], Truth]
) -> Dataset | None:
    """The cases of the pairs file, or of all pairs within each category."""
    listed = folder / "pairs.txt" if pairs is None else pairs
    if pairs is not None or listed.is_file():
        chosen = _read_pairs(listed, folder, shapes)
    else:
        chosen = [two for two in combinations(shapes.values(), 2) if category(two[0]) == category(two[1])]
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
    """The class of a mesh by its name: ``cat`` of ``cat0.off``, ``man`` of ``8_man_01.off``; else its folder's name."""
    return re.sub(r"^[\d_.-]+|[\d_.-]+$", "", mesh.stem) or mesh.resolve().parent.name


def _case(earlier: list[Case], source: Path, target: Path, truth: Truth, given: str | None = None) -> Case:
    """A case with a name of its own, which is also a file's."""
    names = {case.name for case in earlier}
    name = wanted = f"{source.stem}-{target.stem}"
    number = 2
    while name in names:
        name, number = f"{wanted}-{number}", number + 1
    classes = category(source), category(target)
    return Case(name, given or (classes[0] if classes[0] == classes[1] else "-".join(classes)), source, target, truth)


def _check_lengths(place: str, names: list[str], lists: list[np.ndarray]) -> None:
    for name, values in zip(names, lists, strict=True):
        if len(values) != len(lists[0]):
            raise FormatError(
                f"{place}: {names[0]} lists {len(lists[0])} points and {name} {len(values)}; "
                "line i of both must be the same point, so the lists must be equally long."
            )
