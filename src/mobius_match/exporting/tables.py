"""Tables and arrays: CSV, numpy's .npz, MATLAB's .mat, and a dense map as text."""

from __future__ import annotations

import csv
import io

import numpy as np

from ..geometry.points import SurfacePoints
from ..landmarks.rows import PLACES, SIDES
from ..landmarks.text import plain
from .content import DIRECTION, Content


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
            found[f"dense_{side}_vertex"] = onward.vertex_map + base
            rows = np.full(here.n_file_vertices, -1)
            rows[here.vertex_ids[onward.source_mapped]] = np.flatnonzero(onward.source_mapped)
            exact = onward.target_points
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
