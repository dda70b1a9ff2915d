"""Which piece of the target the source's main piece belongs to, where several are of similar size."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations, product

import numpy as np

from ...errors import MobiusError
from ...geometry.moving_least_squares import similarity
from ...mesh import Mesh
from ...results.correspondence import Correspondence
from ...settings import WHICH_PIECES
from ...surface.surface import Surface
from .maps import best_map
from .search import PiecePair, PieceSearch, map_cost, surfaces_of
from .sides import Side

MOST = 3
"""Pieces of a shape that might be the main one, at most: nine matches."""

POINTS = 200
"""Points of each piece at which an arrangement is compared."""


def arrangement_error(pairs: list[PiecePair]) -> float:
    """How far several matched pieces are from one similar copy of their arrangement: 0 for a copy.

    The root mean square deviation of images from the similarity without reflection that fits best, over that of the
    images from their centre.
    """
    rows = [np.flatnonzero(pair.dense.source_mapped) for pair in pairs]
    rows = [some[:: max(len(some) // POINTS, 1)] for some in rows]
    there = np.concatenate([pair.dense.positions[some] for pair, some in zip(pairs, rows, strict=True)])
    arranged = np.concatenate([one[some] for one, some in zip(_arranged(pairs), rows, strict=True)])
    spread = np.linalg.norm(there - there.mean(axis=0), axis=1)
    deviation = np.linalg.norm(arranged - there, axis=1)
    return float(np.sqrt((deviation**2).mean() / max((spread**2).mean(), np.finfo(float).tiny)))


def _arranged(pairs: list[PiecePair]) -> list[np.ndarray]:
    """Where the vertices of each source piece go by the one similarity that fits the maps of all pieces best."""
    before, after = [], []
    for pair in pairs:
        rows = np.flatnonzero(pair.dense.source_mapped)
        rows = rows[:: max(len(rows) // POINTS, 1)]
        before.append(pair.dense.source.vertices[rows])
        after.append(pair.dense.positions[rows])
    here, there = np.concatenate(before), np.concatenate(after)
    return [similarity(here, there, apply_to=pair.dense.source.vertices) for pair in pairs]


def choose_main_pair(
    first: Surface, second: Surface, search: PieceSearch
) -> tuple[Correspondence, list[PiecePair]] | None:
    """The match of the main pieces, where several pieces of either shape are large enough to be the main one.

    Every large piece of the source is matched with every one of the target. Of all ways to pair them that with the
    least sum of the mean cost of its maps and of the error of their arrangement is taken.

    Returns
    -------
    result
        The match of the two main pieces, whose surfaces have all other pieces beside them.
    others
        The matches of further large pieces. The whole is None where no other piece is nearly as large as the main one.
    """
    if search.settings.proposal != "guided" or search.settings.pieces not in WHICH_PIECES:
        return None
    sides = [Side.of(first), Side.of(second)]
    large = [side.largest(search.parameters.large, MOST) for side in sides]
    if max(map(len, large)) < 2:
        return None
    prepared = [
        {k: search.prepare(side.part(k), side.settings) for k in numbers if side.fine_enough(k)}
        for side, numbers in zip(sides, large, strict=True)
    ]
    pairs: dict[tuple[int, int], PiecePair] = {}
    costs: dict[tuple[int, int], float] = {}
    for (i, one), (j, two) in product(prepared[0].items(), prepared[1].items()):
        try:
            result = search.match(one, two)
        except MobiusError:  # nothing in common
            continue
        pairs[i, j] = PiecePair(i, j, result, result.dense())
        costs[i, j] = map_cost(*surfaces_of(result), result.dense(), search.alignment.cost)
    best, cost = _best_assignment(list(prepared[0]), list(prepared[1]), pairs, costs)
    if not best:
        return None
    best = [
        _with_best_map(pair, prepared[0][pair.source], prepared[1][pair.target], carried, search)
        for pair, carried in zip(best, _arranged(best), strict=True)
    ]
    main, *rest = sorted(best, key=lambda pair: -sides[0].pieces.areas[pair.source])
    if main.result is None:
        return None
    numbers = main.source, main.target
    source, target = (
        with_others(surface, side.without(number))
        for surface, side, number in zip(surfaces_of(main.result), sides, numbers, strict=True)
    )
    notes = [
        f"{side.whole.name}: the main piece is that of {side.pieces.sizes[number, 0]} vertices, which suits the other "
        "shape best"
        for side, number in zip(sides, numbers, strict=True)
        if side.main != number
    ]
    result = replace(
        main.result,
        source=source,
        target=target,
        source_info=source.info,
        target_info=target.info,
        warnings=(*main.result.warnings, *notes),
        _costs=lambda: {"pieces": cost},
        _make_dense=lambda: main.dense,
    )
    return result, rest


def _with_best_map(
    pair: PiecePair, first: Surface, second: Surface, carried: np.ndarray, search: PieceSearch
) -> PiecePair:
    """The pair, with a better map if there is one near where the arrangement of all pieces has it."""
    dense, result = best_map(first, second, carried, pair.result, search)
    return pair if result is None else replace(pair, dense=dense, result=result)


def with_others(surface: Surface, others: Mesh | None) -> Surface:
    """A surface with other pieces beside it."""
    if surface.detail is None:
        return replace(surface, mesh=replace(surface.mesh, others=others))
    return replace(surface, detail=replace(surface.detail, mesh=replace(surface.detail.mesh, others=others)))


def _best_assignment(
    here: list[int],
    there: list[int],
    pairs: dict[tuple[int, int], PiecePair],
    costs: dict[tuple[int, int], float],
) -> tuple[list[PiecePair], float]:
    """The pairs of the assignment of least cost, and the cost; none if there is no match at all."""
    swapped = len(here) > len(there)
    few, many = (there, here) if swapped else (here, there)
    best, least = list[PiecePair](), float("inf")
    for order in permutations(many, len(few)):
        keys = [(j, i) if swapped else (i, j) for i, j in zip(few, order, strict=True)]
        if not all(key in pairs for key in keys):
            continue
        chosen = [pairs[key] for key in keys]
        total = float(np.mean([costs[key] for key in keys])) + arrangement_error(chosen)
        if total < least:
            best, least = chosen, total
    return best, least
