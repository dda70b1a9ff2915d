"""Pieces that both shapes have, besides the main one: told apart by place, size and shape, and matched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...alignments.alignment import Alignment
from ...alignments.dense import dense_map_of_alignment
from ...errors import MobiusError
from ...results.correspondence import Correspondence
from ...results.surface_map import SurfaceMap
from .copies import laid_on, size_of
from .groups import Comparison, groups_of, settled, touching
from .riding import PieceMap, map_of_all_pieces
from .search import PiecePair, PieceSearch, map_cost, proxy_image
from .sides import Side

CLOSE = 0.05
"""Error of a match, as a fraction of the target's diameter, that confidence is the probability of not exceeding."""

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
    that are alike, pieces are assigned to each other, and the surest quarter of the pairs below the largest cost is
    matched. So a comb follows a head once the head has been found.

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
    meshes = [source.part(i), target.part(j)]
    copy, _ = laid_on(meshes[0], meshes[1], carried, search.normal)
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
        return PiecePair(i, j, None, copy)
    first, second = surfaces
    if any(len(one.whole_mesh.vertices) != len(mesh.vertices) for one, mesh in zip(surfaces, meshes, strict=True)):
        return PiecePair(i, j, None, copy)  # cut open, so its vertices count otherwise
    alignment = Alignment(proxy_image(first, second, copy), {}, 0.0, 0.0)
    found: list[tuple[SurfaceMap, Correspondence | None]] = [
        (copy, None),
        (dense_map_of_alignment(first, second, alignment, search.alignment), None),
    ]
    try:
        whole = search.match(first, second)
        found.append((whole.dense(), whole))
    except MobiusError:  # without features, such as a ball
        pass
    size = size_of(meshes[1].vertices)

    def total(dense: SurfaceMap) -> float:
        away = np.linalg.norm(dense.target_points.values(dense.target.vertices) - carried, axis=1)[dense.source_mapped]
        place = float(away.mean()) / size if len(away) else np.inf
        return map_cost(first, second, dense, search.alignment.cost) + place

    dense = min((one for one, _ in found), key=total)
    result = found[-1][1]
    return PiecePair(i, j, None if result is None else _agreeing(result, dense), dense)


def _agreeing(result: Correspondence, dense: SurfaceMap) -> Correspondence | None:
    """The matches that a dense map of the same pieces confirms; None if there are none.

    It does if they end within 5 % of the target's diameter, the error that their confidence is about.
    """
    rows = [np.zeros(mesh.n_file_vertices, np.int64) for mesh in (dense.source, dense.target)]
    for row, mesh in zip(rows, (dense.source, dense.target), strict=True):
        row[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertices))[::-1]
    here, there = rows[0][result.pairs[:, 0]], rows[1][result.pairs[:, 1]]
    away = np.linalg.norm(dense.positions[here] - dense.target.vertices[there], axis=1)
    kept = np.flatnonzero(away <= CLOSE * result.target_info["diameter"])
    if not len(kept):
        return None
    points = result.target_points
    return replace(
        result,
        pairs=result.pairs[kept],
        confidence=result.confidence[kept],
        kind=result.kind[kept],
        target_points=None if points is None else points[kept],
    )
