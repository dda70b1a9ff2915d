"""All constants of the method in one record."""

from __future__ import annotations

from dataclasses import dataclass

from ..alignments.parameters import AlignmentParameters
from ..surface.parameters import SurfaceParameters
from .partial.parameters import PartialParameters
from .pieces.parameters import PiecesParameters


@dataclass(frozen=True)
class Parameters:
    """The constants of the method, one record a stage.

    They are not settings: the defaults are the method. Whoever studies it passes another record, as the ablation does.
    """

    surface: SurfaceParameters = SurfaceParameters()
    alignment: AlignmentParameters = AlignmentParameters()
    partial: PartialParameters = PartialParameters()
    pieces: PiecesParameters = PiecesParameters()
