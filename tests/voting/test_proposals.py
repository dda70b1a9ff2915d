"""How triplets are drawn."""

import numpy as np

from mobius_match.voting.proposals import guided_triplets, uniform_triplets


def test_uniform_triplets_are_distinct_and_even():
    first, second = uniform_triplets(np.random.default_rng(0), 60_000, 5, 4)
    for triplets, n in ((first, 5), (second, 4)):
        assert (triplets >= 0).all()
        assert (triplets < n).all()
        assert (np.sort(triplets, axis=1)[:, 1:] != np.sort(triplets, axis=1)[:, :-1]).all()
        code = triplets @ [n * n, n, 1]
        _, counts = np.unique(code, return_counts=True)
        assert len(counts) == n * (n - 1) * (n - 2), "every ordered triplet occurs"
        expected = 60_000 / len(counts)
        assert np.abs(counts - expected).max() < 5 * np.sqrt(expected)
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < 0.02


def guided(seed, count, points1, points2, allowed, spread=0.3, tolerance=0.1):
    distances = [np.linalg.norm(p[:, None] - p, axis=-1) for p in (points1, points2)]
    return guided_triplets(np.random.default_rng(seed), count, *distances, allowed, spread, tolerance), distances


def test_guided_triplets_keep_what_they_promise():
    rng = np.random.default_rng(1)
    points1, points2 = rng.random((40, 2)), rng.random((30, 2))
    allowed = rng.random((40, 30)) < 0.4
    (first, second), (d1, d2) = guided(3, 500, points1, points2, allowed)
    assert len(first) == len(second) == 500
    assert allowed[first, second].all()
    for a, b in ((0, 1), (0, 2), (1, 2)):
        length1, length2 = d1[first[:, a], first[:, b]], d2[second[:, a], second[:, b]]
        assert (length1 >= 0.3).all()
        assert (np.abs(length1 - length2) <= 0.1 * length1).all()


def test_same_stream_same_triplets_other_stream_others():
    points = np.random.default_rng(1).random((30, 2))
    allowed = np.ones((30, 30), bool)
    (first, again), _ = guided(5, 50, points, points, allowed)
    (first_again, again_again), _ = guided(5, 50, points, points, allowed)
    np.testing.assert_array_equal(first, first_again)
    np.testing.assert_array_equal(again, again_again)
    assert (guided(6, 50, points, points, allowed)[0][0] != first).any()


def test_where_nothing_fits_nothing_is_drawn():
    points = np.random.default_rng(1).random((20, 2))
    (first, second), _ = guided(0, 10, points, points, np.zeros((20, 20), bool))
    assert first.shape == second.shape == (0, 3)
    (first, _), _ = guided(0, 10, points, 100 * points, np.ones((20, 20), bool))
    assert len(first) == 0
