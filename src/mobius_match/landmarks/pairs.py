"""Files of landmarks that a user gives for a match, as pairs of vertices."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import FormatError, SettingsError
from ..mesh import Mesh
from .formats import read_specimens
from .tables import Landmarks, numbers, split_rows
from .text import read_text

FAR = 0.02
"""Distance from the nearest vertex, per diagonal of the mesh's box, from which a landmark is told to lie beside it."""


def pairs_of_files(paths: Sequence[Path], meshes: Sequence[Mesh]) -> tuple[np.ndarray, list[str]]:
    """Pairs of vertices that files name.

    Parameters
    ----------
    paths
        One file, of pairs (CSV, columns ``source`` and ``target``, counting from 0 or as a column ``index_base`` says)
        or of two specimens; or two, with landmarks on the source and on the target. Landmarks are paired by name; if no
        name is on both sides, by order.
    meshes
        Source and target, repaired.

    Returns
    -------
    pairs
        (k, 2) int64, numbers of the user's files.
    notes
        A line for whatever is left out or odd.

    Raises
    ------
    FormatError
        If a file cannot be read, or does not have what is needed.
    SettingsError
        If there are more than two files.
    """
    if len(paths) == 1:
        table = _table(paths[0]) if paths[0].suffix.lower() == ".csv" else None
        if table is not None:
            return table, []
    listed = " and ".join(map(str, paths))
    found = [one for path in paths for one in read_specimens(path)]
    if len(paths) > 2 or len(found) != 2:
        raise (SettingsError if len(paths) > 2 else FormatError)(
            f"{listed}: {len(found)} sets of landmarks; give the source's and the target's, in one "
            "file or in two, or a table with columns source and target"
        )
    marks, notes = _paired(found, listed)
    sides = []
    for one, mesh in zip(marks, meshes, strict=True):
        if one.points is None:
            sides.append(one.vertices)
            continue
        vertices, far = _nearest(one.points, mesh)
        sides.append(mesh.vertex_ids[vertices])
        if len(far):
            notes.append(
                f"{listed}: {len(far)} landmarks lie beside {mesh.name} (the first is {one.names[far[0]]}): are they "
                "placed on this mesh, in its units and coordinates?"
            )
    return _apart(np.stack(sides, axis=1), notes, listed), notes


def _table(path: Path) -> np.ndarray | None:
    """Pairs (k, 2) of a table, if it is one of pairs."""
    heads, rows = split_rows(path, read_text(path))
    if not {"source", "target"} <= set(heads):
        return None
    columns = ["source", "target", *(["index_base"] if "index_base" in heads else [])]
    found = numbers(path, rows, [heads.index(name) for name in columns])
    if found.dtype.kind != "i":
        raise FormatError(f"{path}: its columns {', '.join(columns)} have a number that is not whole")
    return found[:, :2] - found[:, 2:] if found.shape[1] == 3 else found


def _paired(found: list[Landmarks], listed: str) -> tuple[list[Landmarks], list[str]]:
    """Both sides in one order, and what is left out."""
    notes: list[str] = []
    one, two = found
    unique = all(len(set(side.names)) == len(side) for side in found)
    shared = [name for name in one.names if name in set(two.names)] if unique else []
    if shared:
        alone = [name for side in found for name in side.names if name not in set(shared)]
        if alone:
            notes.append(f"{listed}: on one side only, and left out: {', '.join(alone)}")
        one, two = (side[np.array([side.names.index(name) for name in shared])] for side in found)
    elif len(one) != len(two):
        raise FormatError(
            f"{listed}: no name is on both sides, and {len(one)} landmarks cannot be paired with {len(two)} by order; "
            "give them equal names"
        )
    lost = np.zeros(len(one), bool)
    for side in (one, two):
        if side.points is not None:
            lost |= np.isnan(side.points).any(axis=1)
    if lost.any():
        notes.append(f"{listed}: missing on one side, and left out: {', '.join(one[lost].names)}")
    return [one[~lost], two[~lost]], notes


def _nearest(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """The vertices (k,) nearest to points (k, 3), and the rows of points that lie beside the mesh."""
    from scipy.spatial import cKDTree

    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    # On a coarse mesh the middle of a face is far from its corners, and no error.
    corners = mesh.vertices[mesh.faces]
    edge = float(np.median(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)))
    apart, vertices = cKDTree(mesh.vertices / size).query(points / size)
    return vertices, np.flatnonzero(apart > FAR + edge / size)


def _apart(pairs: np.ndarray, notes: list[str], listed: str) -> np.ndarray:
    """Without landmarks whose nearest vertex is another's already."""
    kept: list[int] = []
    taken: tuple[set[int], set[int]] = set(), set()
    for k, (i, j) in enumerate(pairs.tolist()):
        if i not in taken[0] and j not in taken[1]:
            kept.append(k)
            taken[0].add(i)
            taken[1].add(j)
    if len(kept) < len(pairs):
        notes.append(f"{listed}: {len(pairs) - len(kept)} landmarks share a vertex with another, and are left out")
    return pairs[kept]
