"""All constants of the method in one record."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.parameters import HAND, parameter
from ..alignments.parameters import AlignmentParameters
from ..surface.parameters import SurfaceParameters
from .partial.parameters import PartialParameters


@dataclass(frozen=True)
class ReportParameters:
    """Which matches are reported."""

    least_votes: float = parameter(
        0.1, "share of the votes below which a pair has to be supported by others", origin="section 8, as its S"
    )
    least_probability: float = parameter(
        0.5, "confidence below which matches are left out", origin="more likely than not"
    )
    incomplete_factor: float = parameter(
        0.5, "confidence is multiplied by this where each surface may lack what the other has", origin=HAND
    )


@dataclass(frozen=True)
class Parameters:
    """The constants of the method, one record a stage.

    They are not settings: the defaults are the method. Whoever studies it passes another record, as the ablation does.
    """

    surface: SurfaceParameters = SurfaceParameters()
    alignment: AlignmentParameters = AlignmentParameters()
    partial: PartialParameters = PartialParameters()
    report: ReportParameters = ReportParameters()
