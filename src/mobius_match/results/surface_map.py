"""A dense map between two surfaces: a point of the other for every vertex, in both directions."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from .._core.display import html_table, shortened
from .._core.files import write_atomically
from ..geometry.points import SurfacePoints, points_at
from ..mesh import Mesh
from .functional import Eigenbasis, check_count, in_file_order, map_of_functions, repaired_eigenbasis
from .map_file import read_npz, to_npz
from .transferred import mapped_points, transferred_labels, transferred_values


@dataclass(frozen=True, eq=False)
class SurfaceMap:
    """A dense map: a point of the target for each vertex of the source, and the reverse.

    Vertices and faces are numbered as in the repaired meshes. In :attr:`vertex_map`, in what is transferred and in
    eigenbases they are numbered as in the user's own files.

    Parameters
    ----------
    source, target
        The repaired meshes.
    target_points
        (n1,) points of the target, one for each vertex of the source.
    source_points
        (n2,) points of the source, one for each vertex of the target.
    source_mapped, target_mapped
        (n1,) and (n2,) bool: which vertices have a counterpart. The points of the others have no meaning.
    source_carried, target_carried
        (n1, 3) and (n2, 3) float64, or None: positions beside the other surface, in its units, of the vertices of
        pieces that are not matched and are carried along with what they lie next to; NaN for all others. The points of
        these vertices are the images of the nearest points of the matched pieces.
    reflected
        Whether the map takes the mirror image of the source to the target, and so reverses orientation.
    """

    source: Mesh
    target: Mesh
    target_points: SurfacePoints
    source_points: SurfacePoints
    source_mapped: np.ndarray
    target_mapped: np.ndarray
    source_carried: np.ndarray | None = None
    target_carried: np.ndarray | None = None
    reflected: bool = False

    def __repr__(self) -> str:
        return f"<SurfaceMap {self._title}: {self._mapped(self.source_mapped)}>"

    def _repr_html_(self) -> str:
        rows = [
            (side, shortened(mesh.name), mesh.n_file_vertices, self._mapped(mapped))
            for side, mesh, mapped in (
                ("source", self.source, self.source_mapped),
                ("target", self.target, self.target_mapped),
            )
        ]
        return html_table(f"Dense map {self._title}", ("", "mesh", "vertices", "with a counterpart"), rows)

    @property
    def _title(self) -> str:
        return f"{shortened(self.source.name)} -> {shortened(self.target.name)}"

    @staticmethod
    def _mapped(mapped: np.ndarray) -> str:
        return f"{int(mapped.sum())} of {len(mapped)} vertices"

    @cached_property
    def inverse(self) -> SurfaceMap:
        """The map from the target to the source."""
        return SurfaceMap(
            self.target,
            self.source,
            self.source_points,
            self.target_points,
            self.target_mapped,
            self.source_mapped,
            self.target_carried,
            self.source_carried,
            self.reflected,
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
        """The images of the source's vertices, (n1, 3) float64 in the target's units; NaN without a counterpart.

        Vertices of pieces that are carried along lie beside the target as they lie beside the source.
        """
        places = self.target_points.values(self.target.vertices)
        if self.source_carried is not None:
            places = np.where(np.isnan(self.source_carried), places, self.source_carried)
        places[~self.source_mapped] = np.nan
        return places

    def map_points(self, points: SurfacePoints) -> tuple[SurfacePoints, np.ndarray]:
        """The images of points of the source on the target.

        Parameters
        ----------
        points
            (q,) points of the source.

        Returns
        -------
        images : SurfacePoints
            (q,) points of the target: the nearest to the weighted mean of the positions of the corners' images.
        mapped : numpy.ndarray
            (q,) bool: whether every corner whose weight is not zero has a counterpart.
        """
        return mapped_points(self.source_mapped, self.target, self.target_points, points)

    def with_pairs(self, here: np.ndarray, there: np.ndarray) -> SurfaceMap:
        """This map with the images of some vertices replaced by given ones, in both directions.

        Parameters
        ----------
        here, there
            (k,) int64 vertices of the repaired source and target: each maps to the other.

        Returns
        -------
        SurfaceMap
            The new map.
        """
        found, back_found = self.source_mapped.copy(), self.target_mapped.copy()
        found[here] = back_found[there] = True
        points = self.target_points.replaced(here, points_at(self.target.faces, there))
        back = self.source_points.replaced(there, points_at(self.source.faces, here))
        return replace(self, target_points=points, source_points=back, source_mapped=found, target_mapped=back_found)

    def transfer(self, values: np.ndarray) -> np.ndarray:
        """Transfer values at the source's vertices to the target's, interpolated linearly within faces.

        Parameters
        ----------
        values
            (n1, ...) numbers, vectors or colours, one row for each vertex of the source's file.

        Returns
        -------
        numpy.ndarray
            (n2, ...) float64, one row for each vertex of the target's file; NaN where nothing corresponds.

        Raises
        ------
        SettingsError
            If there is not one row for each vertex of the source's file.
        """
        return transferred_values(self.source, self.target, self.source_points, self.target_mapped, values)

    def transfer_labels(self, labels: np.ndarray) -> np.ndarray:
        """Transfer labels of the source's faces to the target's; a label is never interpolated.

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
        faces = self.target.faces
        centres = SurfacePoints(np.arange(len(faces)), faces, np.full((len(faces), 3), 1 / 3))
        return transferred_labels(self.source, self.target, *self.inverse.map_points(centres), labels)

    def eigenbases(self, k: int) -> tuple[Eigenbasis, Eigenbasis]:
        """The first eigenfunctions of both meshes, in which :meth:`functional_map` is expressed.

        Parameters
        ----------
        k
            Number of eigenfunctions, the constant one included.

        Returns
        -------
        source, target : Eigenbasis
            Eigenvalues (k,), eigenfunctions (n1, k) and (n2, k), and areas (n1,) and (n2,) of the vertices of the
            user's own files, in the units of each mesh. Eigenfunctions are orthonormal with respect to the areas. The
            same ``k`` always gives the same functions; the first functions for a larger ``k`` may differ in sign.

        Raises
        ------
        SettingsError
            If ``k`` is no whole number from 1 to the number of vertices less 2.
        """
        source, target = self._repaired_eigenbases(k)
        return in_file_order(source, self.source), in_file_order(target, self.target)

    def functional_map(self, k: int) -> np.ndarray:
        """The functional map of this map: functions on the source to functions on the target, as a matrix.

        If ``a`` (k,) are the coefficients of a function on the source in the basis ``source`` of :meth:`eigenbases`,
        then ``functional_map(k) @ a`` are those of the function on the target with the same values at corresponding
        points, in the basis ``target``. This is the convention of pyFM (``FM`` of shape (k2, k1), made from the
        point-to-point map of the target's vertices to the source, ``p2p_21``).

        Parameters
        ----------
        k
            Number of eigenfunctions on either side.

        Returns
        -------
        numpy.ndarray
            (k, k) float64: the area-weighted least-squares solution over the target's vertices that have a counterpart.
            Where all have one it is ``Phi2.T @ A2 @ P @ Phi1``, with the eigenfunctions Phi1 and Phi2, the target's
            areas A2, and P the interpolation at ``source_points``. For shapes that are isometric up to scale it
            is sqrt(area of target / area of source) times an orthogonal matrix.

        Raises
        ------
        SettingsError
            If ``k`` is no whole number from 1 to the number of vertices less 2, or fewer than ``k`` vertices of the
            target have a counterpart.

        References
        ----------
        M. Ovsjanikov, M. Ben-Chen, J. Solomon, A. Butscher and L. Guibas, "Functional Maps: A Flexible Representation
        of Maps Between Shapes", ACM Transactions on Graphics 31 (4), 2012.
        """
        source, target = self._repaired_eigenbases(k)
        return map_of_functions(source, target, self.source_points, self.target_mapped)

    def _repaired_eigenbases(self, k: int) -> tuple[Eigenbasis, Eigenbasis]:
        check_count(k, self.source, self.target)
        return repaired_eigenbasis(self.source, k), repaired_eigenbasis(self.target, k)

    def text(self) -> str:
        """The text that :meth:`save` writes.

        Returns
        -------
        str
            :attr:`vertex_map`, a line for each vertex of the source's file.
        """
        return "\n".join(map(str, self.vertex_map.tolist())) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the map to a file; an existing file is replaced at once or not at all.

        Parameters
        ----------
        path
            A name that ends in ``.npz`` for all of the map, which :meth:`load` reads. Any other name gets
            :attr:`vertex_map` as text; :func:`mobius_match.export` writes other formats.
        """
        path = Path(path)
        write_atomically(path, self.to_npz() if path.suffix.lower() == ".npz" else self.text().encode())

    def to_npz(self) -> bytes:
        """The content of the .npz file: the points in both directions, and both meshes.

        Returns
        -------
        bytes
            What :meth:`save` writes.
        """
        return to_npz(
            (self.source, self.target),
            (self.target_points, self.source_points),
            (self.source_mapped, self.target_mapped),
            (self.source_carried, self.target_carried),
            self.reflected,
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SurfaceMap:
        """Read a map that :meth:`save` wrote to a .npz file.

        Parameters
        ----------
        path
            The file.

        Returns
        -------
        SurfaceMap
            The map.

        Raises
        ------
        FormatError
            If the file cannot be read or is none of this version.
        """
        return cls(*read_npz(path))
