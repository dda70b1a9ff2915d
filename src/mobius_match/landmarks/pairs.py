"""Landmarks that a user gives for a match, as pairs of vertices: arrays, tables of pairs, files of landmarks."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError, SettingsError
from ..mesh import Mesh
from .formats import read_specimens
from .tables import FAR, Landmarks, numbers, split_rows
from .text import read_text


def given_pairs(given: Any, meshes: Sequence[Mesh]) -> tuple[np.ndarray, list[str]]:
    """Pairs of vertices from an array or from files, checked.

    Parameters
    ----------
    given
        (k, 2) vertex numbers, one path, or a list of paths; see :func:`pairs_of_files`.
    meshes
        Source and target, repaired.

    Returns
    -------
    pairs
        (k, 2) int64, k > 0, in the numbers of the user's files; each vertex at most once on each side.
    notes
        A line on each landmark that is ignored or doubtful.

    Raises
    ------
    SettingsError
        For anything else, a vertex that does not exist, a vertex with two counterparts, or no pair.
    FormatError
        If a file is malformed.
    """
    paths = [given] if isinstance(given, str | os.PathLike) else given
    if isinstance(paths, list | tuple) and paths and all(isinstance(path, str | os.PathLike) for path in paths):
        pairs, notes = pairs_of_files([Path(path) for path in paths], meshes)
    else:
        pairs, notes = _pairs_of_array(given), []
    if not len(pairs):
        raise SettingsError("`landmarks`: there is no pair; give at least one")
    for numbers_of_side, mesh in zip(pairs.T, meshes, strict=True):
        wrong = numbers_of_side[(numbers_of_side < 0) | (numbers_of_side >= mesh.n_file_vertices)]
        if len(wrong):
            raise SettingsError(
                f"`landmarks`: {mesh.name} has no vertex {wrong[0]}; it has {mesh.n_file_vertices}, numbered from 0"
            )
    _, first = np.unique(pairs, axis=0, return_index=True)
    if len(first) < len(pairs):
        notes.append(f"landmarks: {len(pairs) - len(first)} repeated pair(s) ignored")
        pairs = pairs[np.sort(first)]
    for side, mesh in enumerate(meshes):
        values, counts = np.unique(pairs[:, side], return_counts=True)
        if counts.max() > 1:
            number = values[counts.argmax()]
            counterparts = ", ".join(map(str, pairs[pairs[:, side] == number, 1 - side].tolist()))
            raise SettingsError(
                f"`landmarks`: vertex {number} of {mesh.name} is given {counts.max()} counterparts ({counterparts}); "
                "keep the right one"
            )
    return pairs, notes


def _pairs_of_array(given: Any) -> np.ndarray:
    try:
        pairs = np.array(given)
    except (ValueError, TypeError):
        pairs = np.empty(0, object)
    if pairs.size == 0 and pairs.dtype != object:
        return np.empty((0, 2), np.int64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu":
        raise SettingsError(
            "`landmarks` must be pairs (k, 2) of vertex numbers, a file of pairs, or two files of landmarks"
        )
    return pairs.astype(np.int64)


def pairs_of_files(paths: Sequence[Path], meshes: Sequence[Mesh]) -> tuple[np.ndarray, list[str]]:
    """Pairs of vertices from files.

    Parameters
    ----------
    paths
        One file, of pairs (CSV, columns ``source`` and ``target``, counting from 0 or from the column ``index_base``)
        or of two specimens; or two files, with landmarks on the source and on the target. Landmarks are paired by
        name; if no name is on both sides, by order.
    meshes
        Source and target, repaired.

    Returns
    -------
    pairs
        (k, 2) int64, numbers of the user's files.
    notes
        A line on each landmark that is ignored or doubtful.

    Raises
    ------
    FormatError
        If a file cannot be read, or lacks what is needed.
    SettingsError
        If there are more than two files.
    """
    if len(paths) == 1:
        table = _table(paths[0]) if paths[0].suffix.lower() == ".csv" else None
        if table is not None:
            return table, []
    listed = " and ".join(map(str, paths))
    specimens = [specimen for path in paths for specimen in read_specimens(path)]
    if len(paths) > 2 or len(specimens) != 2:
        raise (SettingsError if len(paths) > 2 else FormatError)(
            f"{listed}: {len(specimens)} sets of landmarks; give the source's and the target's, in one "
            "file or in two, or a table with columns source and target"
        )
    sides, notes = _in_one_order(specimens[0], specimens[1], listed)
    columns = []
    for landmarks, mesh in zip(sides, meshes, strict=True):
        if landmarks.points is None:
            columns.append(landmarks.vertices)
            continue
        vertices, far = _nearest_vertices(landmarks.points, mesh)
        columns.append(mesh.vertex_ids[vertices])
        if len(far):
            notes.append(
                f"{listed}: {len(far)} landmarks are off the surface of {mesh.name} (the first is "
                f"{landmarks.names[far[0]]}); check that they belong to this mesh, in its units and coordinates"
            )
    return _without_shared_vertices(np.stack(columns, axis=1), notes, listed), notes


def _table(path: Path) -> np.ndarray | None:
    """Pairs (k, 2) of a table with columns source and target; None for another table."""
    heads, rows = split_rows(path, read_text(path))
    if not {"source", "target"} <= set(heads):
        return None
    columns = ["source", "target", *(["index_base"] if "index_base" in heads else [])]
    table = numbers(path, rows, [heads.index(name) for name in columns])
    if table.dtype.kind != "i":
        raise FormatError(f"{path}: its columns {', '.join(columns)} have a number that is not an integer")
    return table[:, :2] - table[:, 2:] if table.shape[1] == 3 else table


def _in_one_order(source: Landmarks, target: Landmarks, listed: str) -> tuple[list[Landmarks], list[str]]:
    """Both sides in one order, without those that one side lacks, and notes on these."""
    notes: list[str] = []
    unique = all(len(set(side.names)) == len(side) for side in (source, target))
    shared = [name for name in source.names if name in set(target.names)] if unique else []
    if shared:
        unpaired = [name for side in (source, target) for name in side.names if name not in set(shared)]
        if unpaired:
            notes.append(f"{listed}: ignored, on one side only: {', '.join(unpaired)}")
        source, target = (side[np.array([side.names.index(name) for name in shared])] for side in (source, target))
    elif len(source) != len(target):
        raise FormatError(
            f"{listed}: no name is on both sides, and {len(source)} landmarks cannot be paired with {len(target)} by "
            "order; give them equal names"
        )
    missing = np.zeros(len(source), bool)
    for side in (source, target):
        if side.points is not None:
            missing |= np.isnan(side.points).any(axis=1)
    if missing.any():
        notes.append(f"{listed}: ignored, missing on one side: {', '.join(source[missing].names)}")
    return [source[~missing], target[~missing]], notes


def _nearest_vertices(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """The vertices (k,) nearest to points (k, 3), and the rows of points that are off the surface."""
    from scipy.spatial import cKDTree  # a match without landmarks starts without it

    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    # On a coarse mesh the centre of a face is far from its corners.
    corners = mesh.vertices[mesh.faces]
    edge = float(np.median(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)))
    distances, vertices = cKDTree(mesh.vertices / diagonal).query(points / diagonal)
    return vertices, np.flatnonzero(distances > FAR + edge / diagonal)


def _without_shared_vertices(pairs: np.ndarray, notes: list[str], listed: str) -> np.ndarray:
    """The pairs without those that share a vertex with an earlier one."""
    kept: list[int] = []
    used: tuple[set[int], set[int]] = set(), set()
    for k, (i, j) in enumerate(pairs.tolist()):
        if i not in used[0] and j not in used[1]:
            kept.append(k)
            used[0].add(i)
            used[1].add(j)
    if len(kept) < len(pairs):
        notes.append(f"{listed}: {len(pairs) - len(kept)} landmarks ignored, at the same vertex as another")
    return pairs[kept]
