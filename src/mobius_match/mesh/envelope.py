"""A closed envelope that stands for a mesh with very many handles, such as an isosurface of bone.

Hundreds of tunnels leave less surface between them than the samples can tell apart. The envelope is the outer part of
an offset surface: the points outside that have one distance from the mesh. Narrower tunnels, pits and gaps are closed,
cavities and what lies in them are gone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_edt, label

from .._core.display import one_line
from .handles import is_wild, number_of_handles
from .measure import areas, box_scale, unit_box
from .mesh import Floats, Ints, Mesh
from .parameters import EnvelopeParameters
from .repair import repair
from .topology import components

MOST_CELLS = 4_000_000
"""Cells of the grid at most, for memory: about 200 MB."""

BLOCK = 1_000_000
"""Sample points that are made at a time."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """An envelope of a mesh.

    Parameters
    ----------
    mesh
        A closed surface in one piece; wide handles are left. ``vertex_ids`` are those of the closest faces' closest
        vertices, ``face_ids`` -1. A note has the distance of the user's vertices from it.
    offset
        Its distance from the mesh, in units of the square root of the area of the mesh.
    """

    mesh: Mesh
    offset: float

    def __repr__(self) -> str:
        return one_line(self)


def envelopes(mesh: Mesh, parameters: EnvelopeParameters = EnvelopeParameters()) -> list[Envelope]:
    """The close and the wide envelope of a mesh; the wide one alone where the close one is wild as well.

    A tunnel that is open in one shape may be closed in another one, and a cavity behind it comes or goes with it. Which
    envelope is the better one shows when two shapes are matched.

    Parameters
    ----------
    mesh
        A repaired mesh in one piece.
    parameters
        The constants of the method.
    """
    close, wide = (_envelope(mesh, offset, parameters.close / 2) for offset in (parameters.close, parameters.wide))
    too_close = is_wild(number_of_handles(close.mesh.faces), parameters) or close.offset >= wide.offset
    return [wide] if too_close else [close, wide]


def _envelope(mesh: Mesh, offset: float, step: float) -> Envelope:
    import igl  # only meshes with very many handles need it

    unit = unit_box(mesh.vertices)
    scale = float(np.sqrt(areas(mesh.vertices, mesh.faces).sum()))
    made_at, vertices, faces = _offset_surface(unit, mesh.faces, offset * scale, step * scale)
    made = _largest_piece(repair(Mesh(vertices, faces)))
    _, face, point = igl.point_mesh_squared_distance(made.vertices, unit, mesh.faces)
    corners = mesh.faces[face]
    nearest = ((unit[corners] - point[:, None]) ** 2).sum(axis=2).argmin(axis=1)
    ids = mesh.vertex_ids[corners[np.arange(len(corners)), nearest]]
    distance = np.sqrt(igl.point_mesh_squared_distance(unit, made.vertices, made.faces)[0])
    size = float(np.sqrt(areas(made.vertices, made.faces).sum())) * box_scale(made.vertices)
    note = (
        f"{number_of_handles(mesh.faces)} handles are more than the samples can tell apart; an envelope with "
        f"{number_of_handles(made.faces)} handles stands for the surface (distance of the vertices from it per "
        f"sqrt(area): mean {distance.mean() / size:.2g}, at most {distance.max() / size:.2g})."
    )
    outer = replace(
        mesh,
        vertices=made.vertices * box_scale(mesh.vertices)
        + (mesh.vertices.min(axis=0) / 2 + mesh.vertices.max(axis=0) / 2),
        faces=made.faces,
        vertex_ids=ids,
        face_ids=np.full(len(made.faces), -1),
        notes=(*mesh.notes, note),
    )
    return Envelope(outer, made_at / scale)


def _largest_piece(mesh: Mesh) -> Mesh:
    number, piece = components(mesh.faces)
    if number == 1:
        return mesh
    largest = np.bincount(piece, areas(mesh.vertices, mesh.faces)).argmax()
    return repair(Mesh(mesh.vertices, mesh.faces[piece == largest]))


def _offset_surface(vertices: Floats, faces: Ints, offset: float, step: float) -> tuple[float, Floats, Ints]:
    """The outer surface at a distance from a mesh, by marching cubes on a grid of that step.

    The distance, at least two steps, is raised where the grid would be too large, and returned with the surface.
    """
    import igl  # only meshes with very many handles need it

    low, size = vertices.min(axis=0), np.ptp(vertices, axis=0)
    while np.prod((size + 2 * offset) / step + 6) > MOST_CELLS:
        step *= 1.1
        offset = max(offset, 2 * step)
    low = low - offset - 2 * step
    shape = np.ceil((size + 2 * offset + 4 * step) / step).astype(np.int64) + 1
    free = np.ones(shape, dtype=bool)
    for points in _points_on(vertices, faces, step):
        free[tuple(np.round((points - low) / step).astype(np.int64).T)] = False
    distance = distance_transform_edt(free) * step
    # Distances from cell to cell are right to less than two steps; next to the surface exact ones are needed.
    near = np.nonzero(np.abs(distance - offset) <= 2 * step)
    place = low + step * np.stack(near, axis=1)
    distance[near] = np.sqrt(igl.point_mesh_squared_distance(place, vertices, faces)[0])
    outside = label(distance > offset)[0]
    field = np.where((outside > 0) & (outside != outside[0, 0, 0]), -step, distance - offset)
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    made = igl.marching_cubes(
        np.ascontiguousarray(field.transpose(2, 1, 0)).ravel(), low + step * grid, *shape.tolist(), 0.0
    )
    return offset, made[0], made[1].astype(np.int64)


def _points_on(vertices: Floats, faces: Ints, spacing: float) -> list[Floats]:
    """Points of a mesh (p, 3), in blocks, such that none of it is farther from one of them than the spacing."""
    longest = np.max([np.linalg.norm(vertices[faces[:, k]] - vertices[faces[:, k - 1]], axis=1) for k in range(3)], 0)
    parts = np.ceil(longest / spacing).astype(np.int64)
    blocks = [vertices]
    for part in np.unique(parts[parts > 1]).tolist():
        i, j = (x.ravel() for x in np.meshgrid(np.arange(part + 1), np.arange(part + 1), indexing="ij"))
        weights = np.stack([i, j, part - i - j], axis=1)[i + j <= part] / part
        rows = np.flatnonzero(parts == part)
        chunks = np.array_split(rows, -(-len(rows) * len(weights) // BLOCK))
        blocks += [np.einsum("pk,fkd->fpd", weights, vertices[faces[chunk]]).reshape(-1, 3) for chunk in chunks]
    return blocks
