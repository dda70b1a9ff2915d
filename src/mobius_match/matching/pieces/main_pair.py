"""Which piece of the target the source's main piece belongs to, where several are of similar size."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from ...errors import MobiusError
from ...geometry.moving_least_squares import similarity
from ...mesh.pieces import piece_with_others
from ...results.correspondence import Correspondence
from ...surface.surface import Surface
from .search import PiecePair, PieceSearch, map_cost
from .sides import Side


def arrangement_error(pairs: list[PiecePair], points: int) -> float:
    """How far several matched pieces are from one similar copy of their arrangement: 0 for a copy.

    The root mean square deviation of images from the similarity without reflection that fits best, over that of the
    images from their centre.
    """
    before, after = [], []
    for pair in pairs:
        dense = pair.dense
        rows = np.flatnonzero(dense.source_mapped)
        rows = rows[:: max(len(rows) // points, 1)]
        before.append(dense.source.vertices[rows])
        after.append(dense.target_points[rows].values(dense.target.vertices))
    here, there = np.concatenate(before), np.concatenate(after)
    spread = np.linalg.norm(there - there.mean(axis=0), axis=1)
    deviation = np.linalg.norm(similarity(here, there) - there, axis=1)
    return float(np.sqrt((deviation**2).mean() / max((spread**2).mean(), np.finfo(float).tiny)))


def choose_main_pair(
    first: Surface,
    second: Surface,
    search: PieceSearch,
) -> tuple[Surface, Surface, Correspondence | None, list[PiecePair], list[str]]:
    """The surfaces whose main pieces correspond, where several pieces of either shape might be the main one.

    Every large piece of the source is matched with every one of the target. Of all ways to pair them that with the
    least sum of the mean cost of its maps and of the error of their arrangement is taken.

    Returns
    -------
    first, second
        The surfaces; the same where no other piece is nearly as large as the main one.
    result
        The match of the two pieces; None if they are still to be matched.
    others
        The matches of further large pieces.
    notes
        A line where the main piece of a shape is not its largest.
    """
    surfaces = first, second
    sides = [Side(surface.whole_mesh) for surface in surfaces]
    large = [side.largest(search.parameters.large, search.parameters.most_large) for side in sides]
    if max(map(len, large)) < 2:
        return first, second, None, [], []
    prepared: list[dict[int, Surface]] = [{}, {}]
    for side, surface, numbers, found in zip(sides, surfaces, large, prepared, strict=True):
        for number in numbers:
            if side.fine_enough(number):
                found[number] = search.prepare(side.part(number), surface.settings)
    pairs: dict[tuple[int, int], PiecePair] = {}
    costs: dict[tuple[int, int], float] = {}
    for i, one in prepared[0].items():
        for j, two in prepared[1].items():
            try:
                result = search.match(one, two)
                pairs[i, j] = PiecePair(i, j, result, result.dense())
                costs[i, j] = map_cost(one, two, result.dense(), search.alignment.cost)
            except MobiusError:  # nothing in common
                continue
    best = _best_assignment(list(prepared[0]), list(prepared[1]), pairs, costs, search.parameters.arrangement_points)
    if not best:
        return first, second, None, [], []
    best.sort(key=lambda pair: -sides[0].pieces.areas[pair.source])
    main, *rest = best
    chosen = [
        surface
        if side.main == number
        else search.prepare(piece_with_others(side.whole, side.pieces, number), surface.settings)
        for surface, side, number in zip(surfaces, sides, (main.source, main.target), strict=True)
    ]
    notes = [
        f"{side.whole.name}: the main piece is that of {side.pieces.sizes[number, 0]} vertices, which suits the other "
        "shape best"
        for side, number in zip(sides, (main.source, main.target), strict=True)
        if side.main != number
    ]
    return chosen[0], chosen[1], main.result, rest, notes


def _best_assignment(
    here: list[int],
    there: list[int],
    pairs: dict[tuple[int, int], PiecePair],
    costs: dict[tuple[int, int], float],
    points: int,
) -> list[PiecePair]:
    """The pairs of the assignment of least cost; none if there is no match at all."""
    swapped = len(here) > len(there)
    few, many = (there, here) if swapped else (here, there)
    best, least = list[PiecePair](), np.inf
    for order in permutations(many, len(few)):
        keys = [(j, i) if swapped else (i, j) for i, j in zip(few, order, strict=True)]
        if not all(key in pairs for key in keys):
            continue
        chosen = [pairs[key] for key in keys]
        total = float(np.mean([costs[key] for key in keys])) + arrangement_error(chosen, points)
        if total < least:
            best, least = chosen, total
    return best
