"""Both searches for mutually nearest points against whole matrices of distances."""

import numpy as np
import pytest

from mobius_match.voting import nearest
from mobius_match.voting.canonical import FAR
from mobius_match.voting.sweep import SEEDS, sweep
from tests.voting.twins import pairs_twin, sphere_twin, squared_twin


def padded(points):
    """Points (2 or 3, N) as the search takes them: three rows, whole blocks."""
    result = np.zeros((3, nearest.padded(points.shape[1])), np.float32)
    result[: len(points)] = points[:, np.minimum(np.arange(result.shape[1]), points.shape[1] - 1)]
    return result


def search(first, second, sweeping=False, least_pairs=0):
    """The pairs that the search finds, {(row, column, squared distance)}; all points are compared, or it sweeps.

    None where it is given up.
    """
    (dimension, n1), n2 = first.shape, second.shape[1]
    minima, pairs = nearest.empty_minima(n1, n2), nearest.empty_pairs(2, n2)
    pairs.counts[:] = 99
    sets = padded(first), n1, padded(second), n2, dimension == 3
    if sweeping:
        sweep(*sets, minima, pairs, 1)
    else:
        nearest.mutually_nearest(*sets, least_pairs, minima, pairs, 1)
    assert pairs.counts[0] == 99, "only the triplet that was asked for is written"
    n = pairs.counts[1]
    if n < least_pairs:
        return None
    found = list(zip(*(array[1, :n].tolist() for array in pairs[1:]), strict=True))
    assert len(set(found)) == n
    return set(found)


def scattered(kind, rng, n, dimension):
    """Points as triplets leave them: all around, in clumps, on a line across the sweep, a few at infinity."""
    points = rng.normal(size=(2, n))
    if kind == "clumps":
        points = 0.002 * points + rng.normal(size=(2, 5))[:, rng.integers(0, 5, n)]
    elif kind == "line":
        points[0] = 0.3
    elif kind == "tails":
        points = points / rng.random(n) ** 3
        points[:, 3] = FAR, 0
    points = points.astype(np.float32)
    return points if dimension == 2 else sphere_twin(points)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", ["around", "clumps", "line", "tails"])
@pytest.mark.parametrize("sizes", [(1, 1), (5, 9), (64, 33), (401, 353), (350, 500)])
def test_search_finds_the_mutually_nearest(dimension, kind, sizes):
    """Both ways to search find what the twin finds, squared distances to the last bit."""
    rng = np.random.default_rng([*sizes, dimension])
    first, second = (scattered("around" if n < 9 else kind, rng, n, dimension) for n in sizes)
    expected = set(pairs_twin(first, second))
    assert search(first, second) == expected
    if min(sizes) > SEEDS:
        assert search(first, second, sweeping=True) == expected


@pytest.mark.parametrize("sweeping", [False, True])
def test_of_equally_near_points_each_is_in_one_pair(sweeping):
    """On a coarse grid, where most points are doubled, what is found is mutually nearest and no point comes twice."""
    rng = np.random.default_rng(5)
    first, second = (rng.integers(-6, 6, (2, n)).astype(np.float32) for n in (200, 190))
    found = search(first, second, sweeping)
    squared = squared_twin(first, second)
    assert len(found) > 50
    assert len({k for k, _, _ in found}) == len({j for _, j, _ in found}) == len(found)
    for k, j, distance in found:
        assert distance == squared[k, j] == squared[k].min() == squared[:, j].min()


def test_of_equally_near_points_the_lowest_number_is_taken():
    first = np.array([[0, 0], [0, 0]], np.float32)
    second = np.array([[1, -1, 1], [0, 0, 0]], np.float32)
    assert search(first, second) == {(0, 0, 1.0)}


@pytest.mark.parametrize("sizes", [(70, 70), (66, 128), (130, 90)])
def test_search_is_given_up_only_where_there_are_too_few_pairs(sizes):
    """Whatever number of pairs is asked for, sets that have it are found to, and all their pairs, and no others."""
    rng = np.random.default_rng(sizes)
    n1, n2 = sizes
    first = rng.normal(size=(2, n1))
    for noise in (0.01, 0.1, 1.0):  # from most points being in a pair to what chance pairs
        second = np.resize(first.T, (n2, 2)).T + noise * rng.normal(size=(2, n2))
        sets = [points.astype(np.float32) for points in (first, second)]
        expected = set(pairs_twin(*sets))
        for least_pairs in range(min(sizes) + 1):
            found = search(*sets, least_pairs=least_pairs)
            assert found == (expected if len(expected) >= least_pairs else None)
