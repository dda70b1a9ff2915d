"""What a mesh file holds besides its shape: colours, texture coordinates with their picture, and labels of faces.

The file is read by trimesh, which may split vertices and change the order of faces; so everything is first given to the
corners of triangles, which are found again by where they lie.
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
"""Names that a property of faces may have in a PLY file to be taken for labels."""

TOLERANCE = 1e-5
"""How far apart two corners that are one may lie, per half of the mesh's extent."""


@dataclass(frozen=True, eq=False)
class Appearance:
    """What a mesh file holds besides its shape, in the numbers of the file.

    Parameters
    ----------
    mesh
        The mesh as the file has it.
    colors
        (n, 4) uint8 RGBA at the vertices, from the texture where the vertices have none; None without either.
    uv
        (m, 3, 2) float64 texture coordinates of the corners of ``mesh.faces``, v upward, or None.
    image
        The texture as a PNG file, or None.
    labels
        (n_file_faces,) int64, one for each face of the file, or None.
    sampled
        Whether the colours are the texture's.
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
        If the file cannot be read, or its faces cannot be found again.
    """
    import trimesh

    mesh = read_mesh(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            loaded: Any = trimesh.load(path, process=False, force="mesh")
            colors, uv, image, sampled = _visual(loaded)
            own = _own_colors(path, loaded, len(mesh.vertices))
    except Exception as error:  # readers of many formats fail in countless ways; users get one error
        raise FormatError(f"{path}: its colours and textures cannot be read ({error}). Export it again.") from error
    labels = _labels(loaded, mesh)
    if colors is None and uv is None:
        return Appearance(mesh, own, labels=labels)
    corners = _corners(mesh, loaded)
    if colors is not None:
        of_corners, colors = colors[corners], np.full((len(mesh.vertices), 4), 255, np.uint8)
        colors[mesh.faces[::-1]] = of_corners[::-1]  # backwards, so that of several corners the first decides
    if own is not None:
        colors = own
    return Appearance(mesh, colors, None if uv is None else uv[corners], image, labels, sampled and own is None)


def _visual(loaded: Any) -> tuple[np.ndarray | None, np.ndarray | None, bytes | None, bool]:
    """Colours and texture coordinates at trimesh's vertices, the picture, and whether the colours are the picture's."""
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
    """Colours (size, 4) of the vertices in .ply and .obj files, which trimesh forgets where there is a texture."""
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
    there, faces = np.asarray(loaded.vertices) / scale, np.asarray(loaded.faces)
    ours, theirs = mesh.vertices[mesh.faces] / scale, there[faces]
    if ours.shape == theirs.shape and np.abs(ours - theirs).max() < TOLERANCE:
        return faces
    from scipy.spatial import cKDTree

    tree = cKDTree(theirs.reshape(-1, 9))
    found = [tree.query(np.roll(ours, -turn, axis=1).reshape(-1, 9)) for turn in range(3)]
    apart = np.stack([one[0] for one in found])
    turn = apart.argmin(axis=0)
    missing = np.flatnonzero(apart.min(axis=0) > 3 * TOLERANCE)
    if len(missing):
        raise FormatError(
            f"{mesh.path}: the colours and textures of {len(missing)} faces, the first is face {missing[0]}, cannot be "
            "told apart. Export it again, as triangles."
        )
    rows = np.stack([one[1] for one in found])[turn, np.arange(len(ours))]
    return faces[rows[:, None], (np.arange(3) - turn[:, None]) % 3]


def _labels(loaded: Any, mesh: Mesh) -> np.ndarray | None:
    element = loaded.metadata.get("_ply_raw", {}).get("face", {"properties": {}})
    name = next((name for name in LABELS if name in element["properties"]), None)
    if name is None:
        return None
    labels = np.asarray(element["data"][name]).reshape(-1)
    return labels.astype(np.int64) if len(labels) == mesh.n_file_faces and (labels % 1 == 0).all() else None
