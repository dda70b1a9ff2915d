"""The meshes of a result, and their vertices by the numbers that the result has for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import MeshError
from ..mesh import Mesh
from ..mesh.files import unchanged
from ..mesh.pieces import all_pieces
from ..surface.prepare import matchable_mesh


def mesh_of(surface: Any, info: dict[str, Any]) -> Mesh:
    """The repaired mesh of one side of a result, with all its pieces, read from its file if the result was loaded.

    Parameters
    ----------
    surface
        The prepared surface, or None.
    info
        What the result records of the mesh.
    """
    if surface is not None:
        return all_pieces(surface.whole_mesh)
    return all_pieces(matchable_mesh(unchanged(info.get("path"), info.get("sha256", ""))))


def vertices_numbered(mesh: Mesh, numbers: np.ndarray) -> np.ndarray:
    """Vertices of a repaired mesh by their numbers in the user's file; the first of those that share a number.

    Raises
    ------
    MeshError
        If no vertex has one of the numbers.
    """
    order = np.argsort(mesh.vertex_ids, kind="stable")
    place = np.searchsorted(mesh.vertex_ids[order], numbers).clip(max=len(order) - 1)
    vertices = order[place]
    wrong = numbers[mesh.vertex_ids[vertices] != numbers]
    if len(wrong):
        raise MeshError(f"{mesh.name}: has no vertex {wrong[0]}, which the result refers to; match again")
    return vertices
