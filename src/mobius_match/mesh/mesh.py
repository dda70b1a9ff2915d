"""The `Mesh`: vertices and faces, checked and read-only, with the numbers that they have in the user's file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MIRROR = np.array([-1.0, 1.0, 1.0])
"""Factors of the coordinates of a mirror image."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    Only `vertices` and `faces` are required. The arrays are read-only; they are copied if the caller could still write
    to them.

    Parameters
    ----------
    vertices
        (n, 3) float64 coordinates, in the user's units.
    faces
        (m, 3) int64 vertex numbers of each triangle, from 0.
    name
        Short name for messages, such as ``cat0.off``.
    path
        The file it was read from; None for arrays.
    sha256
        Digest of the file's bytes, or of the two arrays where there is no file.
    vertex_ids
        (n,) int64 number of each vertex in the user's own file; two vertices share a number where repair cut one in
        two.
    face_ids
        (m,) int64 number of each triangle's face in the user's own list (before polygons were cut into triangles).
    n_file_vertices, n_file_faces
        Numbers of vertices and faces of the user's file.
    notes
        One line for each change made on reading and repair.
    names
        The faces of each group, object or material of an OBJ file, and of each node or mesh of a scene: pairs of a name
        and face numbers of the file.
    others
        The other pieces of the file, repaired, if this mesh is one of several; else None. Its vertices and faces have
        the user's numbers too.

    Raises
    ------
    MeshError
        If shapes or types are wrong, coordinates are not finite, or vertex numbers are out of range.
    """

    vertices: Floats
    faces: Ints
    name: str = "array"
    path: Path | None = None
    sha256: str = ""
    vertex_ids: Ints = None  # type: ignore[assignment]  # filled in below
    face_ids: Ints = None  # type: ignore[assignment]
    n_file_vertices: int = -1
    n_file_faces: int = -1
    notes: tuple[str, ...] = ()
    names: tuple[tuple[str, Ints], ...] = ()
    others: Mesh | None = None

    def __post_init__(self) -> None:
        vertices = _check_vertices(self.vertices, self.name)
        faces = _check_faces(self.faces, len(vertices), self.name)
        fill: dict[str, Any] = {"vertices": vertices, "faces": faces, "notes": tuple(self.notes)}
        for field, length in (("vertex_ids", len(vertices)), ("face_ids", len(faces))):
            given = getattr(self, field)
            ids = np.arange(length) if given is None else _as_array(given, field, self.name)
            if ids.shape != (length,) or ids.dtype.kind not in "iu":
                raise MeshError(f"{self.name}: {field} must be {length} integers, not {ids.dtype} {ids.shape}.")
            fill[field] = _frozen(ids, np.int64)
        if self.n_file_vertices < 0:
            fill["n_file_vertices"] = len(vertices)
        if self.n_file_faces < 0:
            fill["n_file_faces"] = len(faces)
        if not self.sha256:
            fill["sha256"] = _hash(vertices, faces)
        for field, value in fill.items():
            object.__setattr__(self, field, value)

    def reflected(self) -> Mesh:
        """The mirror image at the plane x = 0, with the same numbers and faces that point outward.

        Returns
        -------
        Mesh
            The mirror image. That of the mirror image is the mesh itself, to the last bit.
        """
        others = None if self.others is None else self.others.reflected()
        return replace(self, vertices=self.vertices * MIRROR, faces=self.faces[:, [0, 2, 1]], others=others)

    def __repr__(self) -> str:
        return f"Mesh({self.name!r}, {len(self.vertices)} vertices, {len(self.faces)} faces)"


def _as_array(values: Any, what: str, name: str) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except Exception as error:  # ragged lists, objects with a broken __array__
        raise MeshError(f"{name}: {what} cannot be converted to an array ({error}). Give a plain array.") from error


def _transposed(array: NDArray[Any], what: str) -> str:
    """The remedy for an array of shape (3, n), else an empty text."""
    return f" If the array is transposed, give {what}.T." if array.ndim == 2 and array.shape[0] == 3 else ""


def _frozen(values: NDArray[Any], dtype: type) -> NDArray[Any]:
    """A read-only array of that dtype that no one else can write to."""
    if (type(values) is np.ndarray and values.dtype == dtype and values.flags.c_contiguous
            and not values.flags.writeable and values.flags.owndata):  # fmt: skip
        return values
    out: NDArray[Any] = np.array(values, dtype=dtype, order="C", subok=False)
    out.flags.writeable = False
    return out


def _check_vertices(values: Any, name: str) -> Floats:
    array = _as_array(values, "vertices", name)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "fiu":
        raise MeshError(
            f"{name}: vertices must be numbers of shape (n, 3), not {array.dtype} of shape "
            f"{array.shape}.{_transposed(array, 'vertices')}"
        )
    with np.errstate(over="ignore"):
        vertices = _frozen(array, np.float64)
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{name}: {count(len(bad), 'vertex has', 'vertices have')} a coordinate that is not a finite number, "
            f"the first is vertex {bad[0]} (counting from 0). Correct or remove them."
        )
    return vertices


def _check_faces(values: Any, n_vertices: int, name: str) -> Ints:
    array = _as_array(values, "faces", name)
    if array.size == 0:
        array = np.zeros((0, 3), dtype=np.int64)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "fiu":
        raise MeshError(
            f"{name}: faces must be vertex numbers of shape (m, 3), not {array.dtype} of shape {array.shape}."
            f"{_transposed(array, 'faces')}{'' if array.shape[1:] > (4,) else ' Cut polygons into triangles first.'}"
        )
    # Compared in the caller's own type: 2**64 - 1 or 1e300 must not wrap around into range.
    inside = (array >= 0) & (array < n_vertices)
    if array.dtype.kind == "f":
        inside &= array == np.floor(array)
    bad = np.flatnonzero(~inside.all(axis=1))
    if len(bad):
        face = bad[0]
        wrong = array[face][~inside[face]][0]
        hint = "" if array.min() < 1 else " If these faces number the vertices from 1, subtract 1."
        raise MeshError(
            f"{name}: face {face} (counting from 0) names vertex {wrong}, but the mesh has {n_vertices} vertices, "
            f"numbered 0 to {n_vertices - 1}; {count(len(bad), 'face is', 'faces are')} wrong in this way. "
            f"Correct the faces or add the missing vertices.{hint}"
        )
    return _frozen(array, np.int64)


def count(number: int, singular: str, plural: str) -> str:
    """A number with its noun."""
    return f"{number} {singular if number == 1 else plural}"


def _hash(vertices: Floats, faces: Ints) -> str:
    digest = hashlib.sha256(f"{vertices.shape}{faces.shape}".encode())
    digest.update(vertices.astype("<f8").tobytes())
    digest.update(faces.astype("<i8").tobytes())
    return digest.hexdigest()
