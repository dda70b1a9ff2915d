"""A dense map: every vertex of one surface to a point of another, both ways, and what is carried along it."""

from __future__ import annotations

import io
import json
import os
import zipfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from .._core.files import write_atomically
from ..errors import FormatError, SettingsError
from ..geometry.points import SurfacePoints, closest_points, points_at
from ..mesh import Mesh

FORMAT = "mobius-match/map"
VERSION = 1


@dataclass(frozen=True, eq=False)
class SurfaceMap:
    """Every vertex of the source to a point of the target, and every vertex of the target to a point of the source.

    Numbers of vertices and faces are those of the repaired meshes; :attr:`vertex_map` and all that is transferred count
    as the user's own files do.

    Parameters
    ----------
    source, target
        The repaired meshes.
    target_points
        (n1,) points of the target, one for each vertex of the source.
    source_points
        (n2,) points of the source, one for each vertex of the target.
    source_mapped, target_mapped
        (n1,) and (n2,) bool: which vertices have a counterpart. Points of the others have no meaning.
    """

    source: Mesh
    target: Mesh
    target_points: SurfacePoints
    source_points: SurfacePoints
    source_mapped: np.ndarray
    target_mapped: np.ndarray

    def __repr__(self) -> str:
        mapped = f"{int(self.source_mapped.sum())} of {len(self.source_mapped)} vertices"
        return f"<SurfaceMap {self.source.name} -> {self.target.name}: {mapped}>"

    @cached_property
    def inverse(self) -> SurfaceMap:
        """The map from the target to the source."""
        return SurfaceMap(
            self.target, self.source, self.source_points, self.target_points, self.target_mapped, self.source_mapped
        )

    @cached_property
    def vertex_map(self) -> np.ndarray:
        """The target vertex nearest to the image of each source vertex, (n_file_vertices,) int64; -1 for none.

        Numbers are those of the user's files.
        """
        images = np.full(self.source.n_file_vertices, -1, np.int64)
        images[self.source.vertex_ids[self.source_mapped]] = self.target.vertex_ids[
            self.target_points.nearest[self.source_mapped]
        ]
        return images

    @cached_property
    def positions(self) -> np.ndarray:
        """Where the source's vertices lie on the target, (n1, 3) float64; NaN for those without counterpart."""
        places = self.target_points.values(self.target.vertices)
        places[~self.source_mapped] = np.nan
        return places

    def map_points(self, points: SurfacePoints) -> tuple[SurfacePoints, np.ndarray]:
        """Where points of the source lie on the target.

        Parameters
        ----------
        points
            (q,) points of the source.

        Returns
        -------
        images
            (q,) points of the target: next to the weighted mean of the places of the corners.
        found
            (q,) bool: whether every corner that weighs anything has a counterpart.
        """
        target, size = self.target, float(np.ptp(self.target.vertices, axis=0).max())
        places = np.einsum("qc,qcd->qd", points.barycentric, self.target_points.values(target.vertices)[points.corners])
        near = self.target_points.nearest[points.nearest]
        images = closest_points(target.vertices / size, target.faces, places / size, near)
        # A vertex goes exactly where its image is, whatever a search among the faces around would round to.
        exact = np.flatnonzero(points.barycentric.max(axis=1) == 1.0)
        images = images.replaced(exact, self.target_points[points.nearest[exact]])
        return images, (self.source_mapped[points.corners] | (points.barycentric == 0)).all(axis=1)

    def with_pairs(self, here: np.ndarray, there: np.ndarray) -> SurfaceMap:
        """The map that takes vertices (k,) of the source to vertices (k,) of the target and back, else the same."""
        found, back_found = self.source_mapped.copy(), self.target_mapped.copy()
        found[here] = back_found[there] = True
        points = self.target_points.replaced(here, points_at(self.target.faces, there))
        back = self.source_points.replaced(there, points_at(self.source.faces, here))
        return SurfaceMap(self.source, self.target, points, back, found, back_found)

    def transfer(self, values: np.ndarray) -> np.ndarray:
        """Carry values at the source's vertices to the target's: numbers, vectors or colours, linear within faces.

        Parameters
        ----------
        values
            (n1, ...) numbers, one row for each vertex of the source's file.

        Returns
        -------
        numpy.ndarray
            (n2, ...) float64, one row for each vertex of the target's file; NaN where nothing corresponds.

        Raises
        ------
        SettingsError
            If there is not one row for each vertex of the source's file.
        """
        values = _rows(values, self.source.n_file_vertices, "vertices", self.source).astype(np.float64)
        at_vertices = self.source_points.values(values[self.source.vertex_ids])
        at_vertices[~self.target_mapped] = np.nan
        transferred = np.full((self.target.n_file_vertices, *values.shape[1:]), np.nan)
        # Backwards, so that of several vertices with one number in the file the first decides.
        transferred[self.target.vertex_ids[::-1]] = at_vertices[::-1]
        return transferred

    def transfer_labels(self, labels: np.ndarray) -> np.ndarray:
        """Carry labels of the source's faces to the target's; a label is never mixed with another.

        Parameters
        ----------
        labels
            (m1,) int, one for each face of the source's file.

        Returns
        -------
        numpy.ndarray
            (m2,) int64, one for each face of the target's file: that of the source's face that its centre lies in; -1
            where nothing corresponds.

        Raises
        ------
        SettingsError
            If there is not one whole number for each face of the source's file.
        """
        labels = _rows(labels, self.source.n_file_faces, "faces", self.source)
        if not np.issubdtype(labels.dtype, np.integer):
            raise SettingsError(f"{self.source.name}: labels are to be whole numbers, and are {labels.dtype}")
        mesh = self.target
        centres = SurfacePoints(np.arange(len(mesh.faces)), mesh.faces, np.full((len(mesh.faces), 3), 1 / 3))
        images, found = self.inverse.map_points(centres)
        carried = np.full(mesh.n_file_faces, -1, np.int64)
        # Backwards, so that of the triangles of one polygon the first decides.
        order = np.flatnonzero(found)[::-1]
        carried[mesh.face_ids[order]] = labels[self.source.face_ids[images.faces[order]]]
        return carried

    def text(self) -> str:
        """:attr:`vertex_map` as text, a line for each vertex of the source's file."""
        return "\n".join(map(str, self.vertex_map.tolist())) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map: its text, or all of it to a .npz file; an existing file is replaced or kept whole."""
        path = Path(path)
        write_atomically(path, self.to_npz() if path.suffix.lower() == ".npz" else self.text().encode())

    def to_npz(self) -> bytes:
        """The content of the .npz file: points both ways, and both meshes."""
        buffer = io.BytesIO()
        arrays = {
            f"{side}_{name}": getattr(points, name)
            for side, points in (("points", self.target_points), ("back", self.source_points))
            for name in ("faces", "corners", "barycentric")
        }
        for side, mesh in (("source", self.source), ("target", self.target)):
            arrays |= {
                f"{side}_{name}": getattr(mesh, name) for name in ("vertices", "faces", "vertex_ids", "face_ids")
            }
        head = {"format": FORMAT, "version": VERSION} | {
            side: {"name": mesh.name, "path": None if mesh.path is None else str(mesh.path), "sha256": mesh.sha256}
            | {"n_file_vertices": mesh.n_file_vertices, "n_file_faces": mesh.n_file_faces}
            for side, mesh in (("source", self.source), ("target", self.target))
        }
        arrays |= {"found": self.source_mapped, "back_found": self.target_mapped, "head": np.array(json.dumps(head))}
        np.savez(buffer, allow_pickle=False, **arrays)
        return buffer.getvalue()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SurfaceMap:
        """Read a map that :meth:`save` wrote to a .npz file.

        Raises
        ------
        FormatError
            If the file cannot be read or is none of this version.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                found = {name: file[name] for name in file.files}
            head = json.loads(str(found["head"]))
            if (head["format"], head["version"]) != (FORMAT, VERSION):
                raise FormatError(f"{path}: not a map of version {VERSION}; compute it again with this version")
            meshes = [
                Mesh(
                    **{name: found[f"{side}_{name}"] for name in ("vertices", "faces", "vertex_ids", "face_ids")},
                    **head[side] | {"path": None if head[side]["path"] is None else Path(head[side]["path"])},
                    notes=(),
                )
                for side in ("source", "target")
            ]
            points = [
                SurfacePoints(*(found[f"{side}_{name}"] for name in ("faces", "corners", "barycentric")))
                for side in ("points", "back")
            ]
            return cls(meshes[0], meshes[1], points[0], points[1], found["found"], found["back_found"])
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, FormatError):
                raise
            raise FormatError(f"{path}: not a readable map ({error}); compute it again") from error


def _rows(values: np.ndarray, number: int, what: str, mesh: Mesh) -> np.ndarray:
    values = np.asarray(values)
    if values.ndim == 0 or len(values) != number:
        length = 0 if values.ndim == 0 else len(values)
        raise SettingsError(f"{mesh.name} has {number} {what}, and {length} values were given: one is needed for each")
    return values
