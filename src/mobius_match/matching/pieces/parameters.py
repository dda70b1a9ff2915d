"""The constants of matching several pieces."""

from __future__ import annotations

from dataclasses import dataclass

from ..._core.parameters import HAND, parameter


@dataclass(frozen=True)
class PiecesParameters:
    """Constants of :mod:`mobius_match.matching.pieces`."""

    solid: float = parameter(
        0.1,
        "mean deviation from a similar copy, as a fraction of its size, up to which a piece that is carried along "
        "keeps its shape",
        origin=HAND,
    )
