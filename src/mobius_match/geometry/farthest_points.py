"""Farthest point sampling: each point is as far as possible from all points before it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np


def farthest_points(
    distances_from: Callable[[int], np.ndarray], distances: np.ndarray, count: int
) -> Iterator[tuple[int, np.ndarray]]:
    """Choose, again and again, the point with the largest distance from those chosen.

    Parameters
    ----------
    distances_from
        Takes the number of a point and gives a new array (n,) of the distances of all points from it.
    distances
        (n,) distances from the points that are already chosen: infinite where there are none, -infinity for points
        that must not be chosen. It is updated; points chosen here get -infinity.
    count
        Number of points to choose.

    Yields
    ------
    point, row
        The number of the chosen point, the lowest of equally far ones, and its distances (n,), 0 from itself.
    """
    for _ in range(count):
        point = int(distances.argmax())
        row = distances_from(point)
        row[point] = 0.0
        np.minimum(distances, row, out=distances)
        distances[point] = -np.inf
        yield point, row
