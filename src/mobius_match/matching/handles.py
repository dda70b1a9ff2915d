"""The choice between the readings of surfaces with handles, by what the best alignment costs.

Contact or handle; of a surface with very many, the close or the wide envelope.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TypeVar

from ..alignments.alignment import Alignment
from ..alignments.cost import cost_terms, total_cost
from ..surface.surface import Surface
from .parameters import Parameters

Found = TypeVar("Found")


def best_reading(
    source: Surface,
    target: Surface,
    align: Callable[[Surface, Surface], tuple[list[Alignment], Found]],
    parameters: Parameters,
) -> tuple[Surface, Surface, Found, list[str]]:
    """Align two surfaces in each of their readings, at most four in all, and take the one of least cost.

    The cost is that of the map along the best alignment, once it is registered: its terms are distances, eigenfunctions
    and curvature, which depend on the reading. Strain does not: the shape in space is the same in all.

    Parameters
    ----------
    source, target
        The surfaces, in their first readings.
    align
        Gives the alignments of two readings, the best one first, which is registered, and what else was found. Without
        alignments nothing can be compared, and the first reading is taken.
    parameters
        The constants.

    Returns
    -------
    source, target
        The readings taken.
    found
        What was found for them.
    notes
        A line about the choice, if there was one.
    """
    runs: list[tuple[float, Surface, Surface, Found]] = []
    for one, two in product(source.readings, target.readings):
        alignments, found = align(one, two)
        if not alignments or (source.other is None and target.other is None):
            return one, two, found, []
        image = alignments[0].registered(one, two, parameters.alignment).image
        terms = cost_terms(one, two, two.nearest_proxy[image], parameters.alignment.cost)
        runs.append((total_cost(terms, parameters.alignment.cost.weights), one, two, found))

    def key(k: int) -> float:
        # What a wide envelope closes is lost to the map, so it has to be the better one beyond doubt.
        cost, one, two, _ = runs[k]
        wide = any(side.envelope and side is not first for side, first in ((one, source), (two, target)))
        return cost + parameters.alignment.selection.close_cost * wide

    order = sorted(range(len(runs)), key=key)
    cost, one, two, found = runs[order[0]]
    others = "; ".join(f"{_reading(*runs[k][1:3])}: {runs[k][0]:.2f}" for k in order[1:])
    best = cost <= min(run[0] for run in runs)
    verdict = "which fits best" if best else "which fits about as well as the best and closes less"
    return one, two, found, [f"{_reading(one, two)}, {verdict} (cost {cost:.2f}; {others})"]


def _reading(source: Surface, target: Surface) -> str:
    """How the two surfaces were read."""
    parts = []
    for name, one in (("source", source), ("target", target)):
        if one.envelope:
            parts.append(f"envelope at {one.envelope:.2g} sqrt(area) from the {name}")
        elif len(one.loops):
            parts.append(f"handles {'kept' if one.handles_kept else 'cut open'} on the {name}")
    return " and ".join(parts)
