"""Meshes of other libraries, recognised by their attributes: none of these libraries is imported."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import MeshError
from .cells import from_cells
from .raw import RawMesh, from_polygons
from .scenes import concatenated, placed_parts

REMEDY = "Correct the faces or add the missing vertices."


def arrays_of(thing: Any) -> tuple[Any, Any] | RawMesh | None:
    """The mesh that an object of another library holds; None if it is no mesh.

    trimesh (``vertices``, ``faces``; scenes), Open3D (``vertices``, ``triangles``; tensors in ``vertex.positions`` and
    ``triangle.indices``), PyVista (``points``, ``faces`` or ``regular_faces``), meshio (``points``, ``cells``).

    Returns
    -------
    tuple or RawMesh or None
        Unchecked vertices and triangles; or, where polygons are cut into triangles or parts are left out, a raw mesh
        with the numbers of the faces and notes.

    Raises
    ------
    MeshError
        If the object holds cells that are no surface.
    """
    if _has(thing, "graph", "geometry"):
        return _scene(thing)
    if _has(thing, "points") and (_has(thing, "faces") or _has(thing, "regular_faces")):
        return _pyvista(thing)
    if _has(thing, "vertices", "faces"):
        return to_array(thing.vertices), to_array(thing.faces)
    if _has(thing, "vertices", "triangles"):
        return to_array(thing.vertices), to_array(thing.triangles)
    if _has(thing, "vertex", "triangle"):
        return to_array(thing.vertex.positions), to_array(thing.triangle.indices)
    if _has(thing, "points", "celltypes"):
        raise MeshError(f"{type(thing).__name__!r} is a grid of cells: give its extract_surface().")
    if _has(thing, "points", "cells"):
        blocks = [(block.type, to_array(block.data)) for block in thing.cells]
        return from_cells(_coordinates(thing.points), blocks, REMEDY)
    return None


def to_array(values: Any) -> Any:
    """Tensors as arrays, from whatever device; other values as they are."""
    for step in ("detach", "cpu", "numpy"):
        if not isinstance(values, np.ndarray) and hasattr(values, step):
            values = getattr(values, step)()
    return values


def _has(thing: Any, *names: str) -> bool:
    return all(hasattr(thing, name) for name in names)


def _coordinates(points: Any) -> NDArray[np.float64]:
    """Points (n, 3); points in the plane get z = 0, as meshio has them in files of plane meshes."""
    array = np.asarray(points, dtype=np.float64)
    if array.ndim == 2 and array.shape[1] == 2:
        array = np.column_stack([array, np.zeros(len(array))])
    return array


def _scene(scene: Any) -> RawMesh:
    left_out = sum(not hasattr(scene.geometry[scene.graph[node][1]], "faces") for node in scene.graph.nodes_geometry)
    notes = [f"{left_out} part(s) of points or lines left out."] if left_out else []
    return concatenated(list(placed_parts(scene)), notes)


def _pyvista(mesh: Any) -> RawMesh:
    """Polygons of PolyData; ``faces`` is a list of sizes, each followed by as many vertex numbers."""
    if getattr(mesh, "n_strips", 0):
        raise MeshError(f"{mesh.n_strips} triangle strip(s) are not read: give triangulate() of the mesh.")
    flat = np.asarray(mesh.faces if hasattr(mesh, "faces") else np.zeros((0, 0)))
    if flat.ndim == 1:
        sizes, corners = _unpadded(flat)
    else:
        polygons = np.asarray(mesh.regular_faces)
        sizes, corners = np.full(len(polygons), polygons.shape[1]), polygons.ravel()
    left_out = {"point": getattr(mesh, "n_verts", 0), "line": getattr(mesh, "n_lines", 0)}
    notes = [f"{number} {kind} cell(s) left out." for kind, number in left_out.items() if number]
    return from_polygons(np.asarray(mesh.points), sizes, corners.astype(np.int64), notes, remedy=REMEDY)


def _unpadded(flat: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[Any]]:
    """Sizes (F,) and all corners in a row of polygons stored as size, corners, size, corners, ..."""
    at, starts = 0, []
    while at < len(flat):
        starts.append(at)
        at += int(flat[at]) + 1
    sizes = flat[starts].astype(np.int64) if starts else np.zeros(0, np.int64)
    return sizes, np.delete(flat, starts)
