"""The two readings of a surface with handles: parts of a body that touch, or a handle that is real.

Where parts touch, distances along the surface must not take the way across, and so the surface is cut open. The handle
of a mug belongs to its shape: there distances and eigenfunctions are those of the whole surface, and only the
flattening, which knows spheres with holes alone, is that of the surface cut open.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .._core.display import one_line
from ..mesh import Mesh
from ..mesh.handles import cut_along, handle_loops, handles_note, loop_lengths
from ..mesh.measure import areas, unit_box


@dataclass(frozen=True, eq=False)
class HandleReadings:
    """What a mesh with handles may be.

    Parameters
    ----------
    meshes
        The mesh cut open along all loops; then, if some of the loops can be handles, the mesh with these kept.
    loops
        Vertices of the user's mesh (l,) int64 of each loop.
    kept
        Of the mesh with handles kept, vertices (l,) int64 of their loops; empty if other loops are cut open there,
        which changes the numbers of its vertices.
    """

    meshes: tuple[Mesh, ...]
    loops: list[np.ndarray]
    kept: list[np.ndarray] = field(default_factory=list)

    def __repr__(self) -> str:
        return one_line(self)


def handle_readings(mesh: Mesh, number: int, proxy_size: int) -> HandleReadings:
    """The readings of a mesh with so many handles; one without handles has a single one, itself.

    A loop is that of a contact if it is shorter than the circumference of a disc with the area that one point of the
    proxy stands for: what is thinner than that is no part of the shape at the resolution at which it is compared.
    """
    loops = handle_loops(mesh, number)
    if not loops:
        return HandleReadings((mesh,), [])
    lengths = loop_lengths(unit_box(mesh.vertices), loops) / np.sqrt(areas(mesh.vertices, mesh.faces).sum())
    thin = lengths < 2 * np.sqrt(np.pi / proxy_size)
    contacts, handles = ([loop for loop, one in zip(loops, thin, strict=True) if one == t] for t in (True, False))
    meshes = [_cut(mesh, loops, [])]
    if handles:
        meshes.append(_cut(mesh, contacts, handles))
    return HandleReadings(tuple(meshes), [mesh.vertex_ids[loop] for loop in loops], [] if contacts else handles)


def _cut(mesh: Mesh, cut: list[np.ndarray], kept: list[np.ndarray]) -> Mesh:
    """The mesh with some handles cut open, and a note on all."""
    notes = list(mesh.notes)
    if cut:
        notes.append(handles_note(mesh, cut, "cut open, as where parts of a shape touch"))
    if kept:
        notes.append(handles_note(mesh, kept, "kept, and cut open in the flattening alone"))
    return replace(cut_along(mesh, cut)[0] if cut else mesh, notes=tuple(notes))
