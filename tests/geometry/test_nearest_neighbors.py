"""The nearest rows against all distances: where leaves tell much, where they tell nothing, and among equals."""

import numpy as np
import pytest

from mobius_match.geometry.nearest_neighbors import WIDTH, NearestNeighbors, nearest_neighbors, spatial_order


def by_all_distances(queries, rows):
    squared = [((rows.astype(np.float64) - query) ** 2).sum(axis=1) for query in queries.astype(np.float64)]
    return np.array(squared), np.argmin(squared, axis=1)


@pytest.mark.parametrize(("n", "columns"), [(1, 3), (5, 2), (23, 70), (24, 8), (25, 9), (700, 6), (1500, 68)])
@pytest.mark.parametrize("falling", [0.0, 2.0])
def test_equal_to_all_distances(n, columns, falling):
    """Columns that are alike, or that tell less and less."""
    generator = np.random.default_rng(n)
    size = (1 + np.arange(columns)) ** -falling
    rows = generator.standard_normal((n, columns)) * size
    queries = np.concatenate([rows[:5] + 1e-3 * size, generator.standard_normal((200, columns)) * size])
    squared, nearest = by_all_distances(queries, rows)
    found = nearest_neighbors(queries, rows)
    everyone = np.arange(len(queries))
    np.testing.assert_allclose(squared[everyone, found], squared[everyone, nearest], rtol=1e-5, atol=1e-12)
    assert np.mean(found == nearest) > 0.99
    np.testing.assert_array_equal(nearest_neighbors(rows, rows), np.arange(n))


def test_the_lowest_of_equal_ones_whatever_the_leaves():
    generator = np.random.default_rng(0)
    rows = generator.integers(0, 4, (250, 3)).astype(np.float64)
    rows = np.concatenate([rows, 3 - rows])  # the mean is a number without rounding, and so are all differences
    queries = generator.integers(0, 8, (300, 3)) / 2
    nearest = by_all_distances(queries, rows)[1]
    np.testing.assert_array_equal(nearest_neighbors(queries, rows), nearest)
    order = generator.permutation(504)
    order[order >= 500] = 499
    np.testing.assert_array_equal(NearestNeighbors(rows, order.reshape(-1, WIDTH)).nearest(queries), nearest)


def test_far_from_the_origin():
    generator = np.random.default_rng(0)
    rows, queries = generator.random((400, 6)), generator.random((100, 6))
    np.testing.assert_array_equal(nearest_neighbors(queries + 1e5, rows + 1e5), by_all_distances(queries, rows)[1])


def test_leaves_hold_every_point_and_lie_together():
    points = np.random.default_rng(0).random((1000, 3))
    order = spatial_order(points)
    assert order.shape == (42, WIDTH)
    np.testing.assert_array_equal(np.unique(order), np.arange(1000))
    assert np.ptp(points[order], axis=1).max(axis=1).mean() < 0.5
