"""The constants of finding the mirror symmetry of one surface."""

from __future__ import annotations

from dataclasses import dataclass

from ..._core.parameters import AREA, HAND, parameter


@dataclass(frozen=True)
class SymmetryParameters:
    """Constants of :func:`mobius_match.matching.symmetry.symmetry.symmetry`, besides those of the voting."""

    radius: float = parameter(
        0.1,
        "distance at which two points have ceased to be the same: of a point from its image in the voting, of a vote "
        "from the image under the map, and error of distances at which a confidence falls to 1 / e",
        unit=AREA,
        origin=HAND,
    )
    similarity_width: float = parameter(
        1.5,
        "width of the similarity of signatures, in medians of the difference to the most similar other sample",
        origin=HAND,
    )
    least_confidence: float = parameter(0.4, "confidence below which a pair is left out", origin=HAND)
    stationary_pairs: int = parameter(30, "best pairs that determine the stationary vertices", origin=HAND)
    stationary_tolerance: float = parameter(
        0.01, "tolerance of stationary vertices on meshes with shorter edges", unit=AREA, origin=HAND
    )
    low_score: float = parameter(
        0.65,
        "score below which a warning is given",
        origin="docs/symmetry.md: of 69 bodies in many poses, none has less than 0.77",
    )
