"""Appearance of a mesh file: colours, texture coordinates with their image, and labels of faces.

The file is read by trimesh, which may split vertices and change the order of faces. So all values are first assigned to
the corners of triangles, which are then matched by their coordinates.
"""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError
from .files import read_mesh
from .measure import box_scale
from .mesh import Mesh

LABELS = ("label", "labels", "segment", "part", "class", "category")
"""Properties of faces in a PLY file that are read as labels."""

TOLERANCE = 1e-5
"""Distance up to which two corners are the same, as a fraction of half the mesh's extent."""


@dataclass(frozen=True, eq=False)
class Appearance:
    """Colours, texture and labels of a mesh file, in the numbering of the file.

    Parameters
    ----------
    mesh
        The unrepaired mesh of the file.
    colors
        (n, 4) uint8 RGBA at the vertices, from the texture where the vertices have none; None without either.
    uv
        (m, 3, 2) float64 texture coordinates of the corners of ``mesh.faces``, v upward, or None.
    image
        The texture as a PNG file, or None.
    labels
        (n_file_faces,) int64, one for each face of the file, or None.
    sampled
        Whether the colours were sampled from the texture.
    """

    mesh: Mesh
    colors: np.ndarray | None = None
    uv: np.ndarray | None = None
    image: bytes | None = None
    labels: np.ndarray | None = None
    sampled: bool = False


def read_appearance(path: Path) -> Appearance:
    """Read colours, texture and labels.

    Raises
    ------
    FormatError
        If the file cannot be read, or its faces cannot be identified.
    """
    import trimesh

    mesh = read_mesh(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            loaded: Any = trimesh.load(path, process=False, force="mesh")
            colors, uv, image, sampled = _visual(loaded)
            own = _own_colors(path, loaded, len(mesh.vertices))
    except Exception as error:  # readers of many formats fail in many ways; users get one error
        raise FormatError(f"{path}: its colours and textures cannot be read ({error}). Export it again.") from error
    labels = _labels(loaded, mesh)
    if colors is None and uv is None:
        return Appearance(mesh, own, labels=labels)
    corners = _corners(mesh, loaded)
    if colors is not None:
        of_corners, colors = colors[corners], np.full((len(mesh.vertices), 4), 255, np.uint8)
        colors[mesh.faces[::-1]] = of_corners[::-1]  # backwards: of several corners the first is used
    if own is not None:
        colors = own
    return Appearance(mesh, colors, None if uv is None else uv[corners], image, labels, sampled and own is None)


def _visual(loaded: Any) -> tuple[np.ndarray | None, np.ndarray | None, bytes | None, bool]:
    """Colours and texture coordinates at trimesh's vertices, the image, and whether the colours come from it."""
    visual = loaded.visual
    if visual.kind == "vertex":
        return np.asarray(visual.vertex_colors, np.uint8), None, None, False
    if visual.kind != "texture" or visual.uv is None:
        return None, None, None, False
    own = visual.vertex_attributes.get("color")
    colors = None if own is None else np.asarray(own, np.uint8)
    uv, material = np.asarray(visual.uv, np.float64)[:, :2], visual.material
    picture = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    if picture is None:
        return colors, uv, None, False
    buffer = io.BytesIO()
    picture.save(buffer, "PNG")
    sampled = np.asarray(visual.to_color().vertex_colors, np.uint8)
    return sampled if colors is None else colors, uv, buffer.getvalue(), colors is None


def _own_colors(path: Path, loaded: Any, size: int) -> np.ndarray | None:
    """Colours (size, 4) of the vertices in .ply and .obj files, which trimesh drops where there is a texture."""
    colors = np.full((size, 4), 255, np.uint8)
    if path.suffix.lower() == ".ply":
        element = loaded.metadata["_ply_raw"]["vertex"]
        names = [name for name in ("red", "green", "blue", "alpha") if "u1" in element["properties"].get(name, "")]
        for k, name in enumerate(names):
            colors[:, k] = np.asarray(element["data"][name]).reshape(-1)
        return colors if len(names) >= 3 else None
    if path.suffix.lower() == ".obj":
        rows = [line.split()[1:] for line in path.read_text("latin-1").splitlines() if line.startswith(("v ", "v\t"))]
        if len(rows) == size and all(len(row) == 6 for row in rows):
            colors[:, :3] = np.round(np.clip([[float(x) for x in row[3:]] for row in rows], 0, 1) * 255)
            return colors
    return None


def _corners(mesh: Mesh, loaded: Any) -> np.ndarray:
    """Trimesh's vertex (m, 3) at each corner of the mesh."""
    scale = box_scale(mesh.vertices)
    faces = np.asarray(loaded.faces)
    ours, theirs = mesh.vertices[mesh.faces] / scale, np.asarray(loaded.vertices)[faces] / scale
    if ours.shape == theirs.shape and np.abs(ours - theirs).max() < TOLERANCE:
        return faces
    from scipy.spatial import cKDTree

    tree = cKDTree(theirs.reshape(-1, 9))
    # A face may begin at another of its corners.
    results = [tree.query(np.roll(ours, -turn, axis=1).reshape(-1, 9)) for turn in range(3)]
    distances = np.stack([distance for distance, _ in results])
    turn = distances.argmin(axis=0)
    missing = np.flatnonzero(distances.min(axis=0) > 3 * TOLERANCE)
    if len(missing):
        raise FormatError(
            f"{mesh.path}: the colours and textures of {len(missing)} faces cannot be assigned, the first is face "
            f"{missing[0]}. Export it again, as triangles."
        )
    rows = np.stack([row for _, row in results])[turn, np.arange(len(ours))]
    return faces[rows[:, None], (np.arange(3) - turn[:, None]) % 3]


def _labels(loaded: Any, mesh: Mesh) -> np.ndarray | None:
    element = loaded.metadata.get("_ply_raw", {}).get("face", {"properties": {}})
    name = next((name for name in LABELS if name in element["properties"]), None)
    if name is None:
        return None
    labels = np.asarray(element["data"][name]).reshape(-1)
    return labels.astype(np.int64) if len(labels) == mesh.n_file_faces and (labels % 1 == 0).all() else None
