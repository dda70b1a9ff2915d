"""The constants of repair; docs/method.md has the formulas."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.parameters import AREA, parameter


@dataclass(frozen=True)
class RepairParameters:
    """How far repair may change a mesh."""

    one_sided_cut: float = parameter(
        0.35,
        "longest cut through a one-sided surface whose boundary is not longer than that",
        unit=AREA,
        origin="circumference of one of 100 equal discs that make up the area, 2 sqrt(pi / 100): one sample's cell",
    )


@dataclass(frozen=True)
class EnvelopeParameters:
    """When and how an envelope stands for a mesh."""

    most_handles: int = parameter(
        50,
        "handles above which an envelope stands for a mesh",
        origin="half of 100 samples: cut along so many loops, a surface has a rim for each sample",
    )
    close: float = parameter(
        0.016,
        "distance of the close envelope from the mesh",
        unit=AREA,
        origin="radius of one of 1200 equal discs that make up the area, 1 / sqrt(1200 pi): one proxy vertex",
    )
    wide: float = parameter(
        0.056,
        "distance of the wide envelope from the mesh",
        unit=AREA,
        origin="radius of one of 100 equal discs, 1 / sqrt(100 pi): one sample's cell",
    )
