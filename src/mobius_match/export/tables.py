"""Tables and arrays: CSV, numpy's .npz, MATLAB's .mat, and a dense map as text."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..dense.tables import Landmarks, numbers, read_table, split_rows
from ..errors import FormatError
from ..geometry.points import SurfacePoints
from .content import DIRECTION, SIDES, Content
from .words import plain, read_text

PLACES = [f"{side}_{axis}" for side in SIDES for axis in "xyz"]


def write_csv(content: Content) -> bytes:
    """A row for each match; the headings tell the direction, the column ``index_base`` where vertices begin."""
    matches, exact = content.matches, content.matches.target_points
    heads = ["name", "source", "target", "confidence", "kind", "given", *PLACES, "index_base"]
    columns = [content.marks[0].names, *matches.pairs.T.tolist(), map(repr, matches.confidence.tolist())]
    columns += [matches.kind.tolist(), content.given.astype(int).tolist()]
    columns += [map(repr, column) for marks in content.marks for column in marks.points.T.tolist()]
    columns += [[0] * len(matches)]
    if exact is not None:
        heads += ["target_face", *(f"target_corner_{k}" for k in range(3)), *(f"target_weight_{k}" for k in range(3))]
        columns += [exact.faces.tolist(), *exact.corners.T.tolist()]
        columns += [map(repr, column) for column in exact.barycentric.T.tolist()]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(zip(*columns, strict=True))
    return out.getvalue().encode()


def write_csv_marks(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """One specimen: name, vertex (from 0), x, y, z."""
    (marks,) = specimens
    return marks.text()


def read_csv(path: Path, wanted: str) -> list[Landmarks]:
    """Landmarks in columns ``x, y, z`` (or ``vertex``), or both shapes' as :func:`write_csv` has them."""
    heads, rows = split_rows(path, read_text(path))
    if not set(PLACES) <= set(heads):
        table = read_table(path)
        if isinstance(table, Landmarks):
            return [table]
        raise FormatError(f"{path}: has no columns x, y, z, nor vertex; name them in its first line")
    names = [row[heads.index("name")] for _, row in rows] if "name" in heads else []
    places = numbers(path, rows, [heads.index(name) for name in PLACES]).astype(np.float64)
    return [Landmarks(names, None, places[:, 3 * k : 3 * k + 3], side) for k, side in enumerate(SIDES)]


def arrays_of(content: Content, base: int) -> dict[str, np.ndarray]:
    """All that there is, by name, with vertices and faces counting from ``base``; one less where there is none."""
    found: dict[str, np.ndarray] = {"index_base": np.array(base), "direction": np.array(DIRECTION)}
    for side, name in zip(SIDES, content.names, strict=True):
        found[f"{side}_name"] = np.array(plain(name))
    if content.result is not None:
        matches, exact = content.result, content.result.target_points
        found |= {"source": matches.pairs[:, 0] + base, "target": matches.pairs[:, 1] + base}
        found |= {"confidence": matches.confidence, "recovered": matches.kind == "recovered"}
        found["given"] = content.given
        found |= {f"{side}_points": marks.points for side, marks in zip(SIDES, content.marks, strict=True)}
        if exact is not None:
            found |= _points("target", exact, base)
    if content.dense is not None:
        for side, onward in zip(SIDES, (content.dense, content.dense.inverse), strict=True):
            here, there = onward.source, onward.target
            found[f"dense_{side}_vertex"] = onward.vertices + base
            rows = np.full(here.n_file_vertices, -1)
            rows[here.vertex_ids[onward.found]] = np.flatnonzero(onward.found)
            exact = onward.points
            values = _points(
                f"dense_{side}",
                SurfacePoints(there.face_ids[exact.faces], there.vertex_ids[exact.corners], exact.barycentric)[rows],
                base,
            )
            for name, array in values.items():
                array[rows < 0] = 0 if array.dtype.kind == "f" else base - 1
                found[name] = array
    return found


def _points(prefix: str, points: SurfacePoints, base: int) -> dict[str, np.ndarray]:
    return {
        f"{prefix}_face": points.faces + base,
        f"{prefix}_corners": points.corners + base,
        f"{prefix}_weights": points.barycentric.copy(),
    }


def write_npz(content: Content) -> bytes:
    """All of it as numpy's .npz, counting from 0."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays_of(content, 0))
    return buffer.getvalue()


def write_mat(content: Content) -> bytes:
    """All of it for MATLAB (version 5 files), counting from 1 as MATLAB does."""
    from scipy.io import savemat

    buffer = io.BytesIO()
    found = arrays_of(content, 1)
    found = {name: array.astype(np.float64) if array.dtype.kind in "iu" else array for name, array in found.items()}
    savemat(buffer, found, oned_as="column", do_compression=True)
    # In place of the platform and the time, what the file holds; 116 bytes of text are for that.
    said = f"MATLAB 5.0 MAT-file, mobius-match: {DIRECTION}, vertices and faces count from 1, 0 is none"
    return said.encode().ljust(116)[:116] + buffer.getvalue()[116:]


def write_text(content: Content) -> bytes:
    """The dense map as text: line i is the target vertex of source vertex i, both from 0, or -1."""
    return content.map.text().encode()


def read_npz(path: Path, wanted: str) -> list[Landmarks]:
    """The matches that :func:`write_npz` wrote, as landmarks of the source and of the target."""
    try:
        with np.load(path, allow_pickle=False) as file:
            places = [np.asarray(file[f"{side}_points"], np.float64) for side in SIDES]
            found = [str(file[f"{side}_name"]) for side in SIDES]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise FormatError(f"{path}: not an .npz file of mobius convert with matches ({error})") from error
    if any(array.ndim != 2 or array.shape[1:] != (3,) for array in places):
        raise FormatError(f"{path}: its points are not rows of three coordinates")
    return [Landmarks([], None, array, name) for array, name in zip(places, found, strict=True)]
