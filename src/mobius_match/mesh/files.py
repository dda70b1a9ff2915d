"""Reading meshes from files and arrays: every failure is one error of the family, naming the file."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import FormatError, MeshError
from .formats.gltf import read_gltf
from .formats.obj import read_obj
from .formats.objects import arrays_of, to_array
from .formats.off import read_off
from .formats.ply import read_ply
from .formats.raw import HOW_TO_MESH, RawMesh
from .formats.stl import read_stl
from .formats.vtk import read_vtk, read_vtkxml
from .mesh import Mesh

READERS: dict[str, Callable[[bytes, Path], RawMesh]] = {
    ".off": lambda data, _: read_off(data),
    ".obj": lambda data, _: read_obj(data),
    ".ply": lambda data, _: read_ply(data),
    ".stl": lambda data, _: read_stl(data),
    ".glb": read_gltf,
    ".gltf": read_gltf,
    ".vtk": lambda data, _: read_vtk(data),
    ".vtp": lambda data, _: read_vtkxml(data),
    ".vtu": lambda data, _: read_vtkxml(data),
}


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a triangle or polygon mesh, keeping the vertex and face numbers of the file.

    Parameters
    ----------
    path : str or path-like
        A file ending in .off, .obj, .ply, .stl, .glb, .gltf, .vtk, .vtp or .vtu.

    Returns
    -------
    Mesh
        Unrepaired: polygons are cut into triangles (`Mesh.face_ids` has the polygon of each), STL corners with equal
        coordinates are merged (the format has no vertex numbers), nothing else is changed.

    Raises
    ------
    FormatError
        If the file does not exist, is a folder, is empty, has an unknown ending, is damaged or cut short.
    MeshError
        If there are no vertices or no faces, or coordinates are not finite.
    """
    path, data = _load(path)
    reader = READERS[path.suffix.lower()]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of numpy, on unusual numbers: checked below
            # numpy only warns where a text of numbers ends in something else; the libraries ignore it.
            warnings.filterwarnings("error", message="string or file could not be read")
            raw = reader(data, path)
    except MeshError as error:
        raise type(error)(f"{path}: {error}") from error
    except Exception as error:
        # Damaged files make the readers fail in many ways; users get one error.
        kind = path.suffix[1:].upper()
        raise FormatError(
            f"{path}: cannot be read as {kind} ({type(error).__name__}: {error}). "
            "The file is damaged, cut short, or of another format than its ending says: export it again."
        ) from error
    if not len(raw.vertices) or not raw.n_faces:
        raise MeshError(
            f"{path}: {len(raw.vertices)} vertices and {raw.n_faces} faces; a surface needs both. {HOW_TO_MESH}"
        )
    return Mesh(
        raw.vertices,
        raw.faces,
        name=path.name,
        path=path,
        sha256=hashlib.sha256(data).hexdigest(),
        face_ids=raw.face_ids,
        n_file_faces=raw.n_faces,
        notes=tuple(raw.notes),
        names=tuple(raw.names.items()),
    )


def _load(given: str | os.PathLike[str]) -> tuple[Path, bytes]:
    """The path and bytes of a file with a known ending."""
    path = Path(given)
    endings = ", ".join(READERS)
    try:
        if not path.exists():
            raise FormatError(f"{path}: no such file. Check the path.")
        if not path.is_file():
            raise FormatError(f"{path}: is a folder or a device, not a file. Give the path of one mesh file.")
        if path.suffix.lower() not in READERS:
            raise FormatError(
                f"{path}: unknown ending {path.suffix!r}. Supported are {endings}: export to one of these."
            )
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, MeshError):
            raise
        raise FormatError(f"{path}: cannot be opened ({error}). Check path and permissions.") from error
    if not data.strip():
        raise FormatError(f"{path}: the file is empty. Export it again.")
    return path, data


def unchanged(path: str | os.PathLike[str] | None, sha256: str) -> Path:
    """The path of a mesh file, checked to have the same content as when it was read.

    Raises
    ------
    MeshError
        If there is no path (the mesh was given as arrays), or the file has changed since.
    FormatError
        If the file does not exist.
    """
    if path is None:
        raise MeshError("a mesh was given as arrays, so there is no file to read it from; match again from files.")
    if not Path(path).exists():
        raise FormatError(f"{path}: no such file. Put it back, or run this from the folder in which it was matched.")
    path, data = _load(path)
    if hashlib.sha256(data).hexdigest() != sha256:
        raise MeshError(f"{path}: the file has changed since the match. Match again, or restore the old file.")
    return path


def as_mesh(thing: Any) -> Mesh:
    """Convert a file, arrays or a mesh of another library to a `Mesh`.

    Parameters
    ----------
    thing : Mesh, path, (vertices, faces), or a mesh of another library
        Arrays are taken as they are: (n, 3) coordinates and (m, 3) vertex numbers from 0. Of other libraries: trimesh
        meshes and scenes (whose parts are placed by their transforms), PyVista's PolyData, Open3D's TriangleMesh,
        legacy or tensor, and meshio's Mesh. Polygons are cut into triangles; points and lines are left out and
        counted in `Mesh.notes`.

    Raises
    ------
    MeshError
        If the thing is none of these, or the mesh is not valid (`FormatError` where it is a file).
    """
    if isinstance(thing, Mesh):
        return thing
    if isinstance(thing, str | os.PathLike):
        return read_mesh(thing)
    if isinstance(thing, tuple | list) and len(thing) == 2:
        return Mesh(*map(to_array, thing))
    found = arrays_of(thing)
    if isinstance(found, RawMesh):
        return Mesh(
            found.vertices,
            found.faces,
            face_ids=found.face_ids,
            n_file_faces=found.n_faces,
            notes=tuple(found.notes),
            names=tuple(found.names.items()),
        )
    if found is not None:
        return Mesh(*found)
    raise MeshError(
        f"{type(thing).__name__!r} is not a mesh: give a path, a pair (vertices, faces), or a mesh of trimesh, "
        "PyVista, Open3D or meshio."
    )
