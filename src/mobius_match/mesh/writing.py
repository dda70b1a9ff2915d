"""Mesh files with colours, textures, labels and values, as bytes; vertices and faces stay in their order."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SettingsError
from .mesh import Floats, Ints

MESH_ENDINGS = (".ply", ".glb", ".obj")


def mesh_files(
    path: Path,
    vertices: Floats,
    faces: Ints,
    *,
    colors: np.ndarray | None = None,
    uv: np.ndarray | None = None,
    image: bytes | None = None,
    labels: np.ndarray | None = None,
    values: Mapping[str, np.ndarray] | None = None,
    comment: str = "",
) -> dict[Path, bytes]:
    """The files of a mesh by path: the mesh itself last, after its material and texture.

    Parameters
    ----------
    path
        Ends in .ply, .obj or .glb. A .glb has one texture coordinate per vertex: vertices on seams are duplicated, the
        copies placed after all others.
    vertices, faces
        (n, 3) and (m, 3).
    colors
        (n, 4) uint8 RGBA.
    uv, image
        (m, 3, 2) texture coordinates of corners, v upward, and a PNG file.
    labels
        (m,) int; .ply only.
    values
        (n,) or (n, k) numbers at the vertices by name; .ply only.
    comment
        A line of ASCII, written into the file; .ply and .glb only.

    Raises
    ------
    SettingsError
        If the format cannot hold what is given.
    """
    kind = path.suffix.lower()
    if kind not in MESH_ENDINGS:
        raise SettingsError(
            f"{path}: meshes are written as {', '.join(MESH_ENDINGS)}; give a name with one of these endings"
        )
    if (labels is not None or values) and kind != ".ply":
        raise SettingsError(
            f"{path}: labels and values can be written to .ply files (or .npz, .csv, .txt), not to {kind}"
        )
    if kind == ".glb" and colors is not None and uv is not None:
        raise SettingsError(f"{path}: a .glb file holds colours or a texture, not both; choose one, or another format")
    picture = path.with_suffix(".png")
    if kind == ".glb":
        return {path: _glb(vertices, faces, colors, uv, image, comment)}
    beside = {picture: image} if uv is not None and image is not None else {}
    if kind == ".ply":
        comments = [comment] if comment else []
        comments += [f"TextureFile {picture.name}"] if beside else []
        return {**beside, path: _ply(vertices, faces, colors, uv, comments, labels, values or {})}
    material = path.with_suffix(".mtl")
    if beside:
        beside[material] = f"newmtl surface\nKd 1 1 1\nmap_Kd {picture.name}\n".encode()
    return {**beside, path: _obj(vertices, faces, colors, uv, material.name if beside else "")}


def _ply(
    vertices: Floats,
    faces: Ints,
    colors: np.ndarray | None,
    uv: np.ndarray | None,
    comments: list[str],
    labels: np.ndarray | None,
    values: Mapping[str, np.ndarray],
) -> bytes:
    single = (vertices.astype(np.float32) == vertices).all()
    rows = [(name, "<f4" if single else "<f8", vertices[:, k]) for k, name in enumerate("xyz")]
    if colors is not None:
        rows += [(name, "<u1", colors[:, k]) for k, name in enumerate(("red", "green", "blue", "alpha"))]
    for name, column in values.items():
        flat = column.reshape(len(vertices), -1)
        plain = re.sub(r"\W", "_", name)
        kind = "<i4" if np.issubdtype(column.dtype, np.integer) else "<f8"
        rows += [(f"{plain}_{k}" if flat.shape[1] > 1 else plain, kind, part) for k, part in enumerate(flat.T)]
    table = np.empty(len(vertices), [(name, kind) for name, kind, _ in rows])
    for name, _, column in rows:
        table[name] = column
    lists: list[tuple[str, str, np.ndarray]] = [("vertex_indices", "<i4", faces)]
    if uv is not None:
        lists.append(("texcoord", "<f4", uv.reshape(-1, 6)))
    fields = [f for name, kind, part in lists for f in ((f"#{name}", "u1"), (name, kind, part.shape[1]))]
    corners = np.empty(len(faces), [*fields, *([("label", "<i4")] if labels is not None else [])])
    for name, _, part in lists:
        corners[f"#{name}"], corners[name] = part.shape[1], part
    if labels is not None:
        corners["label"] = labels
    words = {"<f4": "float", "<f8": "double", "<u1": "uchar", "<i4": "int"}
    header = ["ply", "format binary_little_endian 1.0", *(f"comment {line}" for line in comments)]
    header += [f"element vertex {len(vertices)}", *(f"property {words[kind]} {name}" for name, kind, _ in rows)]
    header += [f"element face {len(faces)}", *(f"property list uchar {words[kind]} {name}" for name, kind, _ in lists)]
    header += [*(["property int label"] if labels is not None else []), "end_header\n"]
    return "\n".join(header).encode() + table.tobytes() + corners.tobytes()


def _obj(vertices: Floats, faces: Ints, colors: np.ndarray | None, uv: np.ndarray | None, material: str) -> bytes:
    text = io.BytesIO()
    if material:
        text.write(f"mtllib {material}\nusemtl surface\n".encode())
    if colors is None:
        np.savetxt(text, vertices, "v %.17g %.17g %.17g")
    else:
        np.savetxt(text, np.hstack([vertices, colors[:, :3] / 255]), "v %.17g %.17g %.17g %.6f %.6f %.6f")
    if uv is None:
        np.savetxt(text, faces + 1, "f %d %d %d")
    else:
        places, number = np.unique(uv.reshape(-1, 2), axis=0, return_inverse=True)
        np.savetxt(text, places, "vt %.9g %.9g")
        pairs = np.stack([faces, number.reshape(-1, 3)], axis=2).reshape(-1, 6) + 1
        np.savetxt(text, pairs, "f %d/%d %d/%d %d/%d")
    return text.getvalue()


def _glb(
    vertices: Floats, faces: Ints, colors: np.ndarray | None, uv: np.ndarray | None, image: bytes | None, comment: str
) -> bytes:
    import trimesh

    metadata = {"comment": comment} if comment else None
    if uv is None:
        plain = trimesh.Trimesh(vertices, faces, vertex_colors=colors, process=False, metadata=metadata)
        return _bytes(plain)
    from PIL import Image

    origin, faces, at = split_seams(len(vertices), faces, uv)
    picture = None if image is None else Image.open(io.BytesIO(image))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=picture, metallicFactor=0.0, roughnessFactor=1.0)
    visual = trimesh.visual.TextureVisuals(uv=at, material=material)
    return _bytes(trimesh.Trimesh(vertices[origin], faces, visual=visual, process=False, metadata=metadata))


def _bytes(mesh: Any) -> bytes:
    return bytes(mesh.export(file_type="glb"))


def split_seams(n_vertices: int, faces: Ints, uv: np.ndarray) -> tuple[Ints, Ints, Floats]:
    """Vertices with one texture coordinate each: those on seams are duplicated, the copies placed after the others.

    Returns
    -------
    origin, faces, uv
        (n + k,) the vertex that each one is a copy of, the first n of themselves; (m, 3) faces; (n + k, 2) coordinates.
    """
    rows = np.column_stack([faces.ravel(), uv.reshape(-1, 2)])
    kinds, number = np.unique(rows, axis=0, return_inverse=True)
    vertex = kinds[:, 0].astype(np.int64)
    first = np.ones(len(kinds), bool)
    first[1:] = vertex[1:] != vertex[:-1]
    place = np.where(first, vertex, n_vertices + np.cumsum(~first) - 1)
    origin = np.concatenate([np.arange(n_vertices), vertex[~first]])
    at = np.zeros((len(origin), 2))
    at[place] = kinds[:, 1:]
    return origin, place[number.reshape(-1, 3)], at
