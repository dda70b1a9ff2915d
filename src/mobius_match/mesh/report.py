"""What can be said about a mesh, and whether it can be matched."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import MeshError, TopologyError
from .measure import areas
from .mesh import Mesh
from .repair import repair
from .topology import components, count_boundary_loops, edge_table, euler_characteristic, fans, sides

MIN_FACES, MIN_VERTICES = 20, 12


def require_matchable(mesh: Mesh) -> None:
    """Refuse a mesh that the method cannot work on; call it on a repaired mesh.

    The flattening of section 5 needs one connected orientable piece of a sphere: any number of holes, no
    handles.

    Raises
    ------
    MeshError
        Too few vertices or faces, or no area.
    TopologyError
        Edges with more than two faces, surfaces with one side, several pieces, handles.
    """
    name, faces = mesh.name, mesh.faces
    if len(faces) < MIN_FACES or len(mesh.vertices) < MIN_VERTICES:
        raise MeshError(
            f"{name}: {len(faces)} usable faces and {len(mesh.vertices)} vertices are too few for a match; "
            f"at least {MIN_FACES} faces and {MIN_VERTICES} vertices are needed. Use a finer mesh."
        )
    table = edge_table(faces)
    many = np.flatnonzero(table.counts > 2)
    if len(many):
        a, b = mesh.vertex_ids[table.edges[many[0]]]
        raise TopologyError(
            f"{name}: {len(many)} edge(s) have more than two faces, the first joins vertices {a} and {b} "
            f"({table.counts[many[0]]} faces). Remove the extra faces (in a mesh editor: select "
            "non-manifold edges)."
        )
    if sides(faces, table)[2].any():
        raise TopologyError(
            f"{name}: the surface has only one side, like a Moebius strip, and cannot be oriented. "
            "Cut it open or give another mesh."
        )
    number, label = components(faces, table)
    if number > 1:
        size = sorted(np.bincount(label).tolist(), reverse=True)
        listed = ", ".join(map(str, size[:5])) + (", ..." if number > 5 else "")
        raise TopologyError(
            f"{name}: {number} separate pieces (with {listed} faces); one is needed. "
            "Split the file into its pieces, or keep the largest alone."
        )
    if fans(faces, table)[0] != len(np.unique(faces)):
        raise TopologyError(f"{name}: parts of the surface touch at single vertices. Repair the mesh first.")
    handles = (2 - count_boundary_loops(table) - euler_characteristic(faces, table)) // 2
    if handles:
        raise TopologyError(
            f"{name}: the surface has {handles} handle(s) (genus {handles}), but only spheres, with or "
            "without holes, "
            "can be flattened. Cut or fill the handles (often: touching parts that a scan has fused)."
        )
    if not areas(mesh.vertices, faces).sum() > 0:
        raise MeshError(
            f"{name}: the surface has no area, all its vertices lie on one line. Check the coordinates."
        )


def describe(mesh: Mesh) -> dict[str, Any]:
    """Everything that ``mobius info`` shows, ready for JSON."""
    repaired = repair(mesh)
    return {"name": mesh.name, "notes": list(repaired.notes)}
