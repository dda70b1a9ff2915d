"""Farthest point sampling on a line, where the order is known, and its covering bound."""

import numpy as np

from mobius_match.geometry.farthest_points import farthest_points


def chosen(places, distances, count):
    found = farthest_points(lambda point: np.linalg.norm(places - places[point], axis=1), distances, count)
    return [point for point, _ in found]


LINE = np.array([[0.0], [1], [10], [9], [5], [4]])


def test_the_order_on_a_line():
    assert chosen(LINE, np.full(6, np.inf), 6) == [0, 2, 4, 1, 3, 5]


def test_points_already_chosen_and_points_left_out():
    assert chosen(LINE, np.abs(LINE[:, 0] - 9.0), 2) == [0, 4]
    assert chosen(LINE, np.where([1, 1, 0, 1, 1, 1], np.inf, -np.inf), 3) == [0, 3, 4]


def test_coincident_points_are_all_chosen_once():
    assert chosen(np.zeros((4, 3)), np.full(4, np.inf), 4) == [0, 1, 2, 3]


def test_every_gap_is_at_least_the_last_covering_radius():
    """Gonzalez 1985: the points chosen are at least as far apart as any point is from the nearest of them."""
    places = np.random.default_rng(0).random((500, 3))
    distances = np.full(500, np.inf)
    points = chosen(places, distances, 30)
    gaps = np.linalg.norm(places[points][:, None] - places[points], axis=2)[np.triu_indices(30, 1)]
    assert gaps.min() >= distances.max() > 0
    to_chosen = np.linalg.norm(places[:, None] - places[points], axis=2).min(axis=1)
    others = np.setdiff1d(np.arange(500), points)
    np.testing.assert_array_equal(distances[others], to_chosen[others])
