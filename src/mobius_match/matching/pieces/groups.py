"""Pieces, and groups of pieces that touch, compared by place, size and shape."""

from __future__ import annotations

import numpy as np
import scipy

from ...mesh.pieces import part_of_mesh
from ...mesh.topology import edges_of, labels_of
from .copies import laid_positions, size_of
from .sides import Side

TURNED = 4.0
"""Sizes by which a piece is displaced if it is turned to the other side of its end: twice its length, which is about
twice its root mean square radius."""


class Comparison:
    """Pieces of two shapes compared by place, size and shape.

    Parameters
    ----------
    source, target
        The pieces of both.
    here, there
        The groups of pieces that are compared: their numbers; single pieces are groups of one.
    """

    def __init__(self, source: Side, target: Side, here: list[list[int]], there: list[list[int]]) -> None:
        sides = tuple(zip((source, target), (here, there), strict=True))
        self.rows = [np.flatnonzero(np.isin(source.pieces.vertices, group)) for group in here]
        self.points = [
            [side.whole.vertices[np.isin(side.pieces.vertices, group)] for group in groups] for side, groups in sides
        ]
        # Lengths are compared per sqrt(area) of the main pieces.
        scale = [float(np.sqrt(side.pieces.areas[side.main])) for side in (source, target)]
        self.extents = [
            [_extents(points) / one for points in of_side] for of_side, one in zip(self.points, scale, strict=True)
        ]
        self.lengths = [
            [float(np.sqrt(side.pieces.areas[group].sum())) / one for group in groups]
            for (side, groups), one in zip(sides, scale, strict=True)
        ]
        self.spreads = [[_spread(points) for points in of_side] for of_side in self.points]
        self.trees = [scipy.spatial.cKDTree(points) for points in self.points[1]]

    def assigned(self, carried: np.ndarray, most: float) -> list[tuple[int, int]]:
        """Pairs of groups of least total cost, without those off by more in place or shape; the least ambiguous first.

        A pair is the less ambiguous the further its cost is below all others of its row and of its column.
        """
        shape = len(self.points[0]), len(self.points[1])
        costs = np.array([[self.cost(i, j, carried, most) for j in range(shape[1])] for i in range(shape[0])])
        rows, columns = scipy.optimize.linear_sum_assignment(costs.reshape(shape))
        others = costs.copy()
        others[rows, columns] = np.inf
        nearest = np.minimum(others.min(axis=1)[rows], others.min(axis=0)[columns])
        margins = np.minimum(nearest, costs.max()) - costs[rows, columns]
        order = np.argsort(-margins, kind="stable")
        return [(int(rows[k]), int(columns[k])) for k in order if costs[rows[k], columns[k]] <= 2 * most]

    def cost(self, i: int, j: int, carried: np.ndarray, most: float) -> float:
        """The cost of group i of the source as group j of the target: 0 for one that is alike and in its place.

        The mean distance between the carried piece and the other one, over the largest that a turn can make; and the
        logarithms of the ratios of sqrt(area), of the extents along the principal axes, and of the distances from the
        centre (Osada et al. 2002). Place and shape may be ``most`` each; else the cost is three times that.
        """
        extents = [extent[k] for extent, k in zip(self.extents, (i, j), strict=True)]
        # A sheet has no thickness.
        least = 0.1 * max(extent[0] for extent in extents)
        shape = abs(np.log(self.lengths[1][j] / self.lengths[0][i]))
        shape += float(np.abs(np.log((extents[1] + least) / (extents[0] + least))).mean())
        shape += float(np.abs(np.log(self.spreads[1][j] / self.spreads[0][i])).mean())
        positions = carried[self.rows[i]]
        if not shape <= most or np.isnan(positions).any():
            return 3 * most
        points = self.points[1][j]
        distance = self.trees[j].query(positions)[0].mean() + scipy.spatial.cKDTree(positions).query(points)[0].mean()
        place = float(distance / 2 / size_of(points) / TURNED)
        return shape + place if place <= most else 3 * most


def _extents(points: np.ndarray) -> np.ndarray:
    """Root mean square extents (3,) along the principal axes, the largest first."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:3] / np.sqrt(len(points))


def _spread(points: np.ndarray) -> np.ndarray:
    """Quantiles (5,) of the distances from the centre over their root mean square, and a tenth."""
    distances = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return np.asarray(np.quantile(distances, (0.1, 0.3, 0.5, 0.7, 0.9)) / size_of(points) + 0.1)


def touching(side: Side) -> np.ndarray:
    """Pairs (t, 2) of pieces that touch: vertices of theirs are no farther apart than an edge is long (the median)."""
    mesh, piece = side.whole, side.pieces.vertices
    edges = edges_of(mesh.faces)
    length = float(np.median(np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)))
    others = np.flatnonzero((piece != side.main) & (piece >= 0))
    near = scipy.spatial.cKDTree(mesh.vertices[others]).query_pairs(length, output_type="ndarray")
    pairs = np.unique(np.sort(piece[others][near], axis=1), axis=0)
    return pairs[pairs[:, 0] != pairs[:, 1]]


def groups_of(pairs: np.ndarray, left: list[int]) -> list[list[int]]:
    """Groups of two or more of the pieces that are left, which hang together where they touch."""
    inside = pairs[np.isin(pairs, left).all(axis=1)]
    number, label = labels_of(max(left) + 1, inside[:, 0], inside[:, 1])
    numbers = np.array(left)
    groups = [numbers[label[numbers] == k].tolist() for k in range(number)]
    return [group for group in groups if len(group) > 1]


def settled(
    source: Side, target: Side, groups: list[list[list[int]]], carried: np.ndarray, most: float, normal: float
) -> np.ndarray:
    """Carried positions (n1, 3), once groups of pieces have been laid onto groups of the other shape that are alike.

    Feathers side by side cannot be told apart one by one, where a tail is carried with an error of their distance.
    """
    if not all(groups):
        return carried
    comparison = Comparison(source, target, *groups)
    carried = carried.copy()
    for i, j in comparison.assigned(carried, most):
        here, there = (
            part_of_mesh(side.whole, np.isin(side.pieces.vertices, group), np.isin(side.pieces.faces, group))
            for side, group in ((source, groups[0][i]), (target, groups[1][j]))
        )
        carried[comparison.rows[i]] = laid_positions(here, there, carried[comparison.rows[i]], normal)
    return carried
