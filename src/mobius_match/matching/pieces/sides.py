"""The pieces of one shape, as they are compared with those of another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..._core.display import one_line
from ...errors import MeshError
from ...mesh import Mesh
from ...mesh.pieces import MIN_FACES, MIN_VERTICES, Pieces, joined, part_of_mesh, pieces_of
from ...mesh.report import require_matchable
from ...settings import PrepareSettings
from ...surface.surface import Surface


@dataclass(frozen=True, eq=False)
class Side:
    """All pieces of one shape.

    Parameters
    ----------
    mesh
        The main piece, with the others beside it.
    settings
        The settings that it was prepared with.
    """

    mesh: Mesh
    settings: PrepareSettings

    def __repr__(self) -> str:
        return one_line(self)

    @classmethod
    def of(cls, surface: Surface) -> Side:
        """The pieces of the shape that a surface is the main piece of."""
        return cls(surface.whole_mesh, surface.settings)

    @cached_property
    def _joined(self) -> tuple[Mesh, tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        return joined(self.mesh)

    @property
    def whole(self) -> Mesh:
        """The mesh of all pieces."""
        return self._joined[0]

    @cached_property
    def pieces(self) -> Pieces:
        """The pieces of the whole."""
        return pieces_of(self.whole)

    @cached_property
    def main(self) -> int:
        """The number of the main piece."""
        return int(self.pieces.vertices[self._joined[1][0][0]])

    @cached_property
    def matchable(self) -> np.ndarray:
        """Which pieces (k,) bool may be matched by themselves, as far as their size tells."""
        return (self.pieces.sizes >= (MIN_VERTICES, MIN_FACES)).all(axis=1) & ~self.pieces.cavities

    def rows(self, piece: int) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and faces of a piece, as numbers in the whole."""
        return np.flatnonzero(self.pieces.vertices == piece), np.flatnonzero(self.pieces.faces == piece)

    def part(self, piece: int) -> Mesh:
        """The mesh of one piece alone."""
        return part_of_mesh(self.whole, self.pieces.vertices == piece, self.pieces.faces == piece)

    def without(self, piece: int) -> Mesh | None:
        """The mesh of all pieces but one; None if there are no others."""
        vertices = self.pieces.vertices != piece
        return part_of_mesh(self.whole, vertices, self.pieces.faces != piece) if vertices.any() else None

    def fine_enough(self, piece: int) -> bool:
        """Whether a piece can be matched by itself."""
        try:
            require_matchable(self.part(piece))
        except MeshError:
            return False
        return True

    def largest(self, share: float, most: int) -> list[int]:
        """The pieces of at least a share of the largest one's area, the largest first; else the main one."""
        areas = np.where(self.matchable, self.pieces.areas, 0.0)
        order = np.argsort(-areas, kind="stable")
        kept = [int(k) for k in order[areas[order] >= share * areas.max()][:most] if areas[k] > 0]
        return kept if self.main in kept else [self.main]
