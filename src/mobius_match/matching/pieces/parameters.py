"""The constants of matching several pieces."""

from __future__ import annotations

from dataclasses import dataclass

from ..._core.parameters import HAND, parameter


@dataclass(frozen=True)
class PiecesParameters:
    """Constants of :mod:`mobius_match.matching.pieces`."""

    large: float = parameter(
        0.5, "share of the largest piece's area from which a piece might be the main one as well", origin=HAND
    )
    own: float = parameter(
        0.2, "share of the main piece's area from which another piece is matched by the whole method", origin=HAND
    )
    alike: float = parameter(
        1.0,
        "largest cost of place, and of shape, of pieces that belong together: a turn to the other side, or a factor e",
        origin="one unit of each term of the cost",
    )
    solid: float = parameter(
        0.1,
        "mean deviation from a similar copy, as a fraction of its size, up to which a piece that is carried along "
        "keeps its shape",
        origin=HAND,
    )
