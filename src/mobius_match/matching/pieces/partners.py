"""Pieces that both shapes have, besides the main one: told apart by place, size and shape, and matched."""

from __future__ import annotations

import numpy as np

from ...errors import MobiusError
from ...results.surface_map import SurfaceMap
from .copies import laid_on
from .groups import Comparison, groups_of, settled, touching
from .maps import best_map
from .riding import PieceMap, map_of_all_pieces
from .search import PiecePair, PieceSearch
from .sides import Side

MOST_PARTNERS = 200
"""Pieces of a shape for which partners are looked for, at most: the largest."""


def piece_map(pair: PiecePair, source: Side, target: Side) -> PieceMap:
    """The map of two pieces within the meshes of all pieces."""
    return PieceMap(pair.dense, source.rows(pair.source), target.rows(pair.target))


def find_partners(
    source: Side, target: Side, main: SurfaceMap, known: list[PiecePair], search: PieceSearch
) -> list[PiecePair]:
    """Pairs of pieces, besides the main ones, that belong together.

    In rounds: what is not matched yet is carried along with what is, groups of pieces that touch are laid onto groups
    that are alike, pieces are assigned to each other, and the least ambiguous quarter of the pairs below the largest
    cost is matched. So a comb follows a head once the head has been found.

    Parameters
    ----------
    source, target
        The pieces of both shapes.
    main
        The dense map of the main pieces.
    known
        Pairs that are matched already.
    search
        What else is needed.
    """
    pairs = [PiecePair(source.main, target.main, None, main), *known]
    parameters = search.parameters
    left = [
        _candidates(source, {pair.source for pair in pairs}),
        _candidates(target, {pair.target for pair in pairs}),
    ]
    touch = [touching(source), touching(target)]
    while all(left):
        maps = [piece_map(pair, source, target) for pair in pairs]
        carried = map_of_all_pieces(source.whole, target.whole, maps, parameters, search.controls).source_carried
        if carried is None:
            break
        groups = [groups_of(one, numbers) for one, numbers in zip(touch, left, strict=True)]
        carried = settled(source, target, groups, carried, parameters.alike, search.normal)
        comparison = Comparison(source, target, *([[k] for k in numbers] for numbers in left))
        likely = comparison.assigned(carried, parameters.alike)
        if not likely:
            break
        found = [(left[0][row], left[1][column]) for row, column in likely[: -(-len(likely) // 4)]]
        pairs += [_matched(source, target, i, j, carried[source.rows(i)[0]], search) for i, j in found]
        left = [[k for k in numbers if k not in {pair[side] for pair in found}] for side, numbers in enumerate(left)]
    return pairs[1:]


def _candidates(side: Side, taken: set[int]) -> list[int]:
    """The pieces that are still to be matched, the largest first."""
    order = np.argsort(-side.pieces.areas, kind="stable")
    left = [int(k) for k in order if k not in taken and not side.pieces.cavities[k]]
    return left[:MOST_PARTNERS]


def _matched(source: Side, target: Side, i: int, j: int, carried: np.ndarray, search: PieceSearch) -> PiecePair:
    """The match of two pieces that belong together: the best of the maps that may be made of them."""
    meshes = source.part(i), target.part(j)
    large = all(
        side.pieces.areas[k] >= search.parameters.own * side.pieces.areas[side.main]
        for side, k in ((source, i), (target, j))
    )
    surfaces = [
        search.prepare(mesh, side.settings)
        for mesh, side, k in zip(meshes, (source, target), (i, j), strict=True)
        if (large or search.settings.pieces == "all") and side.fine_enough(k)
    ]
    if len(surfaces) < 2:
        return PiecePair(i, j, None, laid_on(meshes[0], meshes[1], carried, search.normal))
    first, second = surfaces
    try:
        whole = search.match(first, second)
    except MobiusError:  # without features, such as a ball
        whole = None
    if any(len(one.whole_mesh.vertices) != len(mesh.vertices) for one, mesh in zip(surfaces, meshes, strict=True)):
        # Cut open along handles, so that vertices count otherwise.
        return PiecePair(i, j, whole, laid_on(*meshes, carried, search.normal) if whole is None else whole.dense())
    dense, result = best_map(first, second, carried, whole, search)
    return PiecePair(i, j, result, dense)
