"""Description of a mesh, and the check whether it can be matched."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import MeshError, TopologyError
from .measure import areas, box_scale, cross_products, twins, unit_box
from .mesh import Ints, Mesh
from .pieces import MIN_FACES, MIN_VERTICES, joined, main_piece, pieces_named, pieces_of, unreached_vertices
from .repair import repair, repeated
from .slivers import MANY, is_flat
from .topology import (
    EdgeTable,
    boundary_lengths,
    components,
    edge_table,
    euler_characteristic,
    fans,
    genus,
    nonmanifold_edges,
    nonmanifold_vertices,
    sides,
    used_vertices,
)


def require_matchable(mesh: Mesh) -> None:
    """Refuse a mesh that cannot be flattened; to be called on the :func:`.main_piece` of a repaired mesh.

    The flattening of section 5 needs one connected orientable surface, with any number of holes. Handles are cut open
    for it, see :func:`.handles.handle_loops`.

    Raises
    ------
    MeshError
        If there are too few vertices or faces, or many faces without area.
    TopologyError
        If there is a surface with one side only.
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
            f"({table.counts[many[0]]} faces). Repair the mesh first."
        )
    if sides(faces, table)[2].any():
        raise TopologyError(
            f"{name}: the surface has only one side, like a Klein bottle, and a cut that makes it orientable would be "
            "long. Cut it open or give another mesh."
        )
    if fans(faces, table)[0] != len(used_vertices(faces)):
        raise TopologyError(f"{name}: parts of the surface touch at single vertices. Repair the mesh first.")
    flat = int(is_flat(unit_box(mesh.vertices), faces).sum())
    if flat > MANY * len(faces):
        raise MeshError(
            f"{name}: {flat} of {len(faces)} faces have no area (corners on one line or in one point). "
            "Check the coordinates, or remesh the surface."
        )


def describe(mesh: Mesh) -> dict[str, Any]:
    """All that ``mobius info`` shows, as a dictionary for JSON.

    Counts of defects (unused and duplicate vertices, degenerate faces, ...), components, sizes and orientation describe
    the mesh as given. After repair ``pieces`` describes each piece, the main one first and then by area; Euler
    characteristic, genus, boundary and quality describe the main piece.

    Returns
    -------
    dict
        ``nonmanifold_edge_places`` and ``nonmanifold_vertex_places`` have the user's vertex numbers, coordinates (of an
        edge its middle) and number of faces; ``handle_places`` has for each handle the user's vertex numbers along the
        loop where it can be cut, its middle and its length; ``unreached_vertices`` lists the vertices of the file that
        are on no face after repair, and so in no map; ``notes`` lists the changes made on reading and repair;
        ``usable`` is whether the mesh can be matched, ``reason`` why not (None if it can). Lengths and areas are in the
        user's units; undefined ones are None.
    """
    from .handles import is_wild, number_of_handles  # compiled

    repaired = main_piece(repair(mesh))
    reason, handles, notes = None, list[dict[str, Any]](), list(repaired.notes)
    try:
        require_matchable(repaired)
        number = number_of_handles(repaired.faces)
        if is_wild(number):
            notes.append(f"{number} handles; an envelope will stand for the surface.")
        else:
            handles = _handles(repaired, number)
    except MeshError as error:
        reason = str(error)
    return {
        "name": mesh.name,
        "path": None if mesh.path is None else str(mesh.path),
        "sha256": mesh.sha256,
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "file_faces": mesh.n_file_faces,
        **_defects(mesh),
        **_shape(repaired),
        "handle_places": handles,
        **_sizes(mesh),
        "quality": _quality(repaired),
        "pieces": _pieces(repaired),
        "unreached_vertices": unreached_vertices(repaired).tolist(),
        "notes": notes,
        "usable": reason is None,
        "reason": reason,
    }


def _defects(mesh: Mesh) -> dict[str, Any]:
    double = (mesh.faces == mesh.faces[:, [1, 2, 0]]).any(axis=1)
    faces = mesh.faces[~double]
    table = edge_table(faces)
    flat = is_flat(unit_box(mesh.vertices), faces)
    _, turned, twisted = sides(faces, table)
    return {
        "unused_vertices": len(mesh.vertices) - len(used_vertices(mesh.faces)),
        "duplicate_vertices": int((twins(mesh.vertices) != np.arange(len(mesh.vertices))).sum()),
        "degenerate_faces": int(double.sum() + flat.sum()),
        "duplicate_faces": int(repeated(np.sort(faces, axis=1)).sum()),
        "components": components(faces, table)[0],
        **_nonmanifold(mesh, faces, table),
        "consistently_oriented": not (turned.any() or twisted.any()),
    }


def _nonmanifold(mesh: Mesh, faces: Ints, table: EdgeTable) -> dict[str, Any]:
    """How many edges have more than two faces and at how many vertices parts of the surface touch, and where."""
    edges, vertices = nonmanifold_edges(table), nonmanifold_vertices(faces, table)
    ends = table.edges[edges]
    middles = mesh.vertices[ends[:, 0]] / 2 + mesh.vertices[ends[:, 1]] / 2
    return {
        "nonmanifold_edges": len(edges),
        "nonmanifold_edge_places": [
            {"vertices": pair, "faces": number, "place": place}
            for pair, number, place in zip(
                mesh.vertex_ids[ends].tolist(), table.counts[edges].tolist(), middles.tolist(), strict=True
            )
        ],
        "nonmanifold_vertices": len(vertices),
        "nonmanifold_vertex_places": [
            {"vertex": vertex, "place": place}
            for vertex, place in zip(mesh.vertex_ids[vertices].tolist(), mesh.vertices[vertices].tolist(), strict=True)
        ],
    }


def _shape(mesh: Mesh) -> dict[str, Any]:
    faces = mesh.faces
    table = edge_table(faces)
    loops = boundary_lengths(table)
    return {
        "euler_characteristic": euler_characteristic(faces, table),
        "genus": genus(faces, table),
        "boundary_loops": {"count": len(loops), "lengths": loops.tolist()},
        "closed": bool(len(faces)) and not len(loops),
        "orientable": not sides(faces, table)[2].any(),
    }


def _handles(mesh: Mesh, number: int) -> list[dict[str, Any]]:
    """The loops around so many handles of a mesh that can be matched."""
    from .handles import handle_loops, loop_lengths

    loops, scale = handle_loops(mesh, number), box_scale(mesh.vertices)
    return [
        {
            "vertices": mesh.vertex_ids[loop].tolist(),
            "place": mesh.vertices[loop].mean(axis=0).tolist(),
            "length": _finite(length, scale),
        }
        for loop, length in zip(loops, loop_lengths(unit_box(mesh.vertices), loops).tolist(), strict=True)
    ]


def _pieces(mesh: Mesh) -> list[dict[str, Any]]:
    """Each piece of a repaired mesh: the main one, and then the others, the largest first."""
    if not len(mesh.faces):
        return []
    whole, (vertices, _), _ = joined(mesh)
    pieces = pieces_of(whole)
    main = pieces.vertices[vertices[0]]
    names = [(name, pieces_named(whole, pieces, faces)) for name, faces in mesh.names]
    order = np.argsort(np.where(np.arange(len(pieces)) == main, -np.inf, -pieces.areas), kind="stable")
    return [
        {
            "vertices": int(pieces.sizes[k, 0]),
            "faces": int(pieces.sizes[k, 1]),
            "area": _finite(float(pieces.areas[k]), 1.0),
            "closed": bool(pieces.closed[k]),
            "cavity": bool(pieces.cavities[k]),
            "first_vertex": int(whole.vertex_ids[pieces.vertices == k].min()),
            "names": [name for name, of_name in names if of_name[k]],
        }
        for k in order.tolist()
    ]


def _sizes(mesh: Mesh) -> dict[str, Any]:
    used = mesh.vertices[used_vertices(mesh.faces)]
    scale = box_scale(used)
    unit = unit_box(mesh.vertices) * (box_scale(mesh.vertices) / scale)
    edges = edge_table(mesh.faces[(mesh.faces != mesh.faces[:, [1, 2, 0]]).all(axis=1)]).edges
    length = np.linalg.norm(unit[edges[:, 0]] - unit[edges[:, 1]], axis=1)
    box = None if not len(used) else {"min": used.min(axis=0).tolist(), "max": used.max(axis=0).tolist()}
    return {
        "area": _finite(float(areas(unit, mesh.faces).sum()) * box_scale(unit) ** 2, scale, 2),
        "bounding_box": box,
        "edge_length": {
            "min": _finite(float(length.min(initial=np.inf)), scale),
            "mean": _finite(float(length.mean()) if len(length) else np.inf, scale),
            "max": _finite(float(length.max(initial=0)) if len(length) else np.inf, scale),
        },
    }


def _finite(value: float, scale: float, power: int = 1) -> float | None:
    """A length or area in the user's units; None where it is undefined or too large for a float."""
    for _ in range(power):
        value *= scale
    return value if math.isfinite(value) else None


def _quality(mesh: Mesh) -> dict[str, Any] | None:
    """Percentiles of the triangles' smallest angles, and the share of edges with a negative cotangent weight."""
    unit, faces = unit_box(mesh.vertices), mesh.faces
    if not len(faces):
        return None
    table = edge_table(faces)
    height = np.linalg.norm(cross_products(unit, faces), axis=1)
    cosine = np.empty(faces.shape)
    for k in range(3):
        corner = unit[faces[:, k]]
        cosine[:, k] = ((unit[faces[:, k - 2]] - corner) * (unit[faces[:, k - 1]] - corner)).sum(axis=1)
    angles = np.degrees(np.arctan2(height[:, None], cosine).min(axis=1))
    proper = height > 0
    weight = np.zeros(len(table.edges))
    np.add.at(weight, table.face_edges[proper].ravel(), (cosine[proper] / height[proper, None]).ravel())
    percentiles = (0, 1, 5, 50, 95)
    values = np.percentile(angles, percentiles)
    return {
        "smallest_angle_degrees": {f"p{p}": float(v) for p, v in zip(percentiles, values, strict=True)},
        "negative_cotangent_fraction": float((weight < 0).mean()),
    }
