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
