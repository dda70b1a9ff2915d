"""The .npz file of a dense map: points in both directions, and both meshes."""

from __future__ import annotations

import io
import json
import os
import zipfile
from pathlib import Path

import numpy as np

from ..errors import FormatError
from ..geometry.points import SurfacePoints
from ..mesh import Mesh

FORMAT = "mobius-match/map"
VERSION = 1

Carried = np.ndarray | None
Fields = tuple[Mesh, Mesh, SurfacePoints, SurfacePoints, np.ndarray, np.ndarray, Carried, Carried, bool]
"""Source and target, target points and source points, which vertices of source and target are mapped, the carried
positions of both, and whether the map is reflected."""


def to_npz(
    meshes: tuple[Mesh, Mesh],
    points: tuple[SurfacePoints, SurfacePoints],
    mapped: tuple[np.ndarray, np.ndarray],
    carried: tuple[Carried, Carried],
    reflected: bool,
) -> bytes:
    """The content of the file."""
    buffer = io.BytesIO()
    arrays = {
        f"{side}_{name}": getattr(of_side, name)
        for side, of_side in zip(("points", "back"), points, strict=True)
        for name in ("faces", "corners", "barycentric")
    }
    sides = tuple(zip(("source", "target"), meshes, strict=True))
    for side, mesh in sides:
        arrays |= {f"{side}_{name}": getattr(mesh, name) for name in ("vertices", "faces", "vertex_ids", "face_ids")}
    for side, positions in zip(("points", "back"), carried, strict=True):
        if positions is not None:
            arrays[f"{side}_carried"] = positions
    head = {"format": FORMAT, "version": VERSION} | {
        side: {"name": mesh.name, "path": None if mesh.path is None else str(mesh.path), "sha256": mesh.sha256}
        | {"n_file_vertices": mesh.n_file_vertices, "n_file_faces": mesh.n_file_faces}
        for side, mesh in sides
    }
    if reflected:
        head["reflected"] = True
    arrays |= {"found": mapped[0], "back_found": mapped[1], "head": np.array(json.dumps(head))}
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def read_npz(path: str | os.PathLike[str]) -> Fields:
    """The fields of the map in a file.

    Raises
    ------
    FormatError
        If the file cannot be read or is none of this version.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        head = json.loads(str(found["head"]))
        if (head["format"], head["version"]) != (FORMAT, VERSION):
            raise FormatError(f"{path}: not a map of version {VERSION}; compute it again with this version")
        source, target = (
            Mesh(
                **{name: found[f"{side}_{name}"] for name in ("vertices", "faces", "vertex_ids", "face_ids")},
                **head[side] | {"path": None if head[side]["path"] is None else Path(head[side]["path"])},
                notes=(),
            )
            for side in ("source", "target")
        )
        target_points, source_points = (
            SurfacePoints(*(found[f"{side}_{name}"] for name in ("faces", "corners", "barycentric")))
            for side in ("points", "back")
        )
        carried = found.get("points_carried"), found.get("back_carried")
        mapped, reflected = (found["found"], found["back_found"]), bool(head.get("reflected", False))
        return source, target, target_points, source_points, *mapped, *carried, reflected
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"{path}: not a readable map ({error}); compute it again") from error
