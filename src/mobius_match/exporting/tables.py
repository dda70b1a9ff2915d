"""Tables and arrays: CSV, numpy's .npz, MATLAB's .mat, and a dense map as text."""

from __future__ import annotations

import csv
import io

import numpy as np

from ..geometry.points import SurfacePoints
from ..landmarks.csv_npz import COORDINATE_COLUMNS, SIDES
from ..landmarks.text import plain
from ..results.surface_map import SurfaceMap
from .content import DIRECTION, Content


def write_csv(content: Content) -> bytes:
    """A row for each match; the column ``index_base`` holds the number of the first vertex."""
    matches, points = content.matches, content.matches.target_points
    heads = ["name", "source", "target", "confidence", "kind", "given", *COORDINATE_COLUMNS, "index_base"]
    columns = [content.landmarks[0].names, *matches.pairs.T.tolist(), map(repr, matches.confidence.tolist())]
    columns += [matches.kind.tolist(), content.given.astype(int).tolist()]
    columns += [map(repr, column) for landmarks in content.landmarks for column in landmarks.points.T.tolist()]
    columns += [[0] * len(matches)]
    if points is not None:
        heads += ["target_face", *(f"target_corner_{k}" for k in range(3)), *(f"target_weight_{k}" for k in range(3))]
        columns += [points.faces.tolist(), *points.corners.T.tolist()]
        columns += [map(repr, column) for column in points.barycentric.T.tolist()]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(zip(*columns, strict=True))
    return out.getvalue().encode()


def arrays_of(content: Content, base: int) -> dict[str, np.ndarray]:
    """All arrays by name. Vertices and faces count from ``base``; ``base - 1`` is none."""
    arrays: dict[str, np.ndarray] = {"index_base": np.array(base), "direction": np.array(DIRECTION)}
    if content.reflected:
        arrays["reflected"] = np.array(True)
    for side, name in zip(SIDES, content.names, strict=True):
        arrays[f"{side}_name"] = np.array(plain(name))
    if content.result is not None:
        matches = content.result
        arrays |= {"source": matches.pairs[:, 0] + base, "target": matches.pairs[:, 1] + base}
        arrays |= {"confidence": matches.confidence, "recovered": matches.kind == "recovered"}
        arrays["given"] = content.given
        arrays |= {f"{side}_points": landmarks.points for side, landmarks in zip(SIDES, content.landmarks, strict=True)}
        if matches.target_points is not None:
            arrays |= _point_arrays("target", matches.target_points, base)
    if content.dense is not None:
        for side, surface_map in zip(SIDES, (content.dense, content.dense.inverse), strict=True):
            arrays |= _map_arrays(f"dense_{side}", surface_map, base)
    return arrays


def _map_arrays(prefix: str, surface_map: SurfaceMap, base: int) -> dict[str, np.ndarray]:
    """The image of each vertex of the source's file: the nearest vertex, and the exact point."""
    source, target, points = surface_map.source, surface_map.target, surface_map.target_points
    row = np.full(source.n_file_vertices, -1)
    row[source.vertex_ids[surface_map.source_mapped]] = np.flatnonzero(surface_map.source_mapped)
    in_file = SurfacePoints(target.face_ids[points.faces], target.vertex_ids[points.corners], points.barycentric)
    arrays = _point_arrays(prefix, in_file[row], base)
    for array in arrays.values():
        array[row < 0] = 0 if array.dtype.kind == "f" else base - 1
    return {f"{prefix}_vertex": surface_map.vertex_map + base, **arrays}


def _point_arrays(prefix: str, points: SurfacePoints, base: int) -> dict[str, np.ndarray]:
    return {
        f"{prefix}_face": points.faces + base,
        f"{prefix}_corners": points.corners + base,
        f"{prefix}_weights": points.barycentric.copy(),
    }


def write_npz(content: Content) -> bytes:
    """All arrays as .npz, counting from 0."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays_of(content, 0))
    return buffer.getvalue()


def write_mat(content: Content) -> bytes:
    """All arrays for MATLAB (files of version 5), counting from 1 as MATLAB does."""
    from scipy.io import savemat

    buffer = io.BytesIO()
    arrays = {
        name: array.astype(np.float64) if array.dtype.kind in "iu" else array
        for name, array in arrays_of(content, 1).items()
    }
    savemat(buffer, arrays, oned_as="column", do_compression=True)
    # The header has 116 bytes of text. SciPy writes platform and time there, which differ from run to run.
    header = f"MATLAB 5.0 MAT-file, mobius-match: {DIRECTION}, vertices and faces count from 1, 0 is none"
    return header.encode().ljust(116)[:116] + buffer.getvalue()[116:]


def write_text(content: Content) -> bytes:
    """The dense map as text: line i is the target vertex of source vertex i, both from 0, or -1."""
    return content.map.text().encode()
