"""The unrepaired mesh of the user's file, and its numbers on the repaired one."""

from __future__ import annotations

import numpy as np

from .files import read_mesh, unchanged
from .measure import twins
from .mesh import Mesh


def user_mesh(mesh: Mesh) -> Mesh:
    """The unrepaired mesh of the user's file, with the numbers of the file.

    Raises
    ------
    MeshError
        If the file is missing or has changed since, and repair dropped part of the mesh.
    """
    if mesh.path is not None and (mesh.path.exists() or not _whole(mesh)):
        return read_mesh(unchanged(mesh.path, mesh.sha256))
    # No face uses the vertices that repair dropped, so their coordinates do not matter.
    vertices = np.tile(mesh.vertices[:1], (mesh.n_file_vertices, 1))
    vertices[mesh.vertex_ids] = mesh.vertices
    return Mesh(
        vertices,
        mesh.vertex_ids[mesh.faces],
        name=mesh.name,
        sha256=mesh.sha256,
        face_ids=mesh.face_ids,
        n_file_faces=mesh.n_file_faces,
    )


def _whole(mesh: Mesh) -> bool:
    """Whether repair dropped nothing."""
    return len(mesh.vertices) == mesh.n_file_vertices and np.array_equal(mesh.face_ids, np.arange(mesh.n_file_faces))


def repaired_numbers(mesh: Mesh, file: Mesh) -> np.ndarray:
    """The repaired vertex of each vertex of the user's mesh (n,) int64, -1 for none; merged ones have the same."""
    number = np.full(len(file.vertices), -1, np.int64)
    number[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertices))[::-1]
    twin = twins(file.vertices)
    shared = np.full(len(number), -1, np.int64)
    np.maximum.at(shared, twin, number)
    used = np.zeros(len(number), bool)
    used[file.faces] = True
    return np.where((number < 0) & used, shared[twin], number)
