"""Pieces that both shapes have, besides the main one: told apart by place, size and shape, and matched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from ...alignments.alignment import Alignment
from ...alignments.dense import dense_map_of_alignment
from ...errors import MobiusError
from ...results.correspondence import Correspondence
from ...results.surface_map import SurfaceMap
from .copies import laid_on, size_of
from .riding import PieceMap, map_of_all_pieces
from .search import PiecePair, PieceSearch, map_cost, proxy_image
from .sides import Side

TURNED = 4.0
"""Sizes by which a piece is displaced if it is turned to the other side of its end: twice its length, which is about
twice its root mean square radius."""


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

    In rounds: what is not matched yet is carried along with what is, pieces are assigned to each other, and the surest
    quarter of the pairs below the largest cost is matched. So a comb follows a head once the head has been found.

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
    comparison = Comparison(source, target, *left)
    while all(left):
        maps = [piece_map(pair, source, target) for pair in pairs]
        carried = map_of_all_pieces(source.whole, target.whole, maps, parameters, search.controls).source_carried
        if carried is None:
            break
        costs = np.array([[comparison.cost(i, j, carried, parameters.alike) for j in left[1]] for i in left[0]])
        rows, columns = linear_sum_assignment(costs)
        alike = costs[rows, columns] <= parameters.alike
        if not alike.any():
            break
        surest = np.argsort(-_margins(costs, rows, columns)[alike], kind="stable")[: -(-int(alike.sum()) // 4)]
        found = [(left[0][rows[alike][k]], left[1][columns[alike][k]]) for k in surest]
        pairs += [_matched(source, target, i, j, carried[source.rows(i)[0]], search) for i, j in found]
        left = [[k for k in numbers if k not in {pair[side] for pair in found}] for side, numbers in enumerate(left)]
    return pairs[1:]


class Comparison:
    """Pieces of two shapes compared by place, size and shape.

    Parameters
    ----------
    source, target
        The pieces of both.
    here, there
        The numbers of the pieces that are compared.
    """

    def __init__(self, source: Side, target: Side, here: list[int], there: list[int]) -> None:
        self.rows = {i: source.rows(i)[0] for i in here}
        self.points = (
            {i: source.whole.vertices[rows] for i, rows in self.rows.items()},
            {j: target.whole.vertices[target.rows(j)[0]] for j in there},
        )
        # Lengths are compared per sqrt(area) of the main pieces.
        scale = [float(np.sqrt(side.pieces.areas[side.main])) for side in (source, target)]
        self.extents = [
            {k: _extents(points) / one for k, points in of_side.items()}
            for of_side, one in zip(self.points, scale, strict=True)
        ]
        self.lengths = [np.sqrt(side.pieces.areas) / one for side, one in zip((source, target), scale, strict=True)]
        self.trees = {j: cKDTree(points) for j, points in self.points[1].items()}

    def cost(self, i: int, j: int, carried: np.ndarray, most: float) -> float:
        """The cost of piece i of the source as piece j of the target: 0 for one that is alike and in its place.

        The mean distance between the carried piece and the other one, over the largest that a turn can make; and the
        logarithms of the ratios of sqrt(area) and of the extents along the principal axes. At most twice ``most``, and
        inexact there.
        """
        extents = [extent[k] for extent, k in zip(self.extents, (i, j), strict=True)]
        # A sheet has no thickness.
        least = 0.1 * max(extent[0] for extent in extents)
        shape = abs(np.log(self.lengths[1][j] / self.lengths[0][i]))
        shape += float(np.abs(np.log((extents[1] + least) / (extents[0] + least))).mean())
        positions = carried[self.rows[i]]
        if not shape <= most or np.isnan(positions).any():
            return 2 * most
        points = self.points[1][j]
        distance = self.trees[j].query(positions)[0].mean() + cKDTree(positions).query(points)[0].mean()
        return float(min(shape + distance / 2 / size_of(points) / TURNED, 2 * most))


def _extents(points: np.ndarray) -> np.ndarray:
    """Root mean square extents (3,) along the principal axes, the largest first."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:3] / np.sqrt(len(points))


def _margins(costs: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """By how much each chosen entry (p,) is below all others of its row and of its column."""
    others = costs.copy()
    others[rows, columns] = np.inf
    nearest = np.minimum(others.min(axis=1)[rows], others.min(axis=0)[columns])
    return np.minimum(nearest, costs.max()) - costs[rows, columns]


def _candidates(side: Side, taken: set[int]) -> list[int]:
    """The pieces that are still to be matched, the largest first."""
    order = np.argsort(-side.pieces.areas, kind="stable")
    left = [int(k) for k in order if k not in taken and not side.pieces.cavities[k]]
    return left[:MOST_PARTNERS]


def _matched(source: Side, target: Side, i: int, j: int, carried: np.ndarray, search: PieceSearch) -> PiecePair:
    """The match of two pieces that belong together: the best of the maps that may be made of them."""
    normal = search.alignment.registration.dense_normal
    meshes = [source.part(i), target.part(j)]
    copy, _ = laid_on(meshes[0], meshes[1], carried, normal)
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
