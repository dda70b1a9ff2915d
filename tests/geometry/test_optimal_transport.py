"""Transport plans: permutations found, nothing left over, and the extension to further points."""

import numpy as np
import pytest

from mobius_match.geometry.optimal_transport import Transport


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(0).random((300, 3))


def test_rows_are_shares_and_a_permutation_is_found(points):
    order = np.random.default_rng(1).permutation(len(points))
    plan = Transport(points, points[order]).plan
    np.testing.assert_allclose(plan.sum(axis=1), 1, rtol=1e-4)
    assert (plan >= 0).all()
    assert np.mean(order[plan.argmax(axis=1)] == np.arange(len(points))) > 0.98


def test_no_part_is_left_over():
    """Two legs, and a first set that is shifted so far that most of it is nearest to one leg of the second."""
    generator = np.random.default_rng(0)
    legs = np.repeat([[0.0, 0.0], [0.3, 0.0]], 20, axis=0) + generator.normal(0, 0.08, (40, 2))
    shifted = legs - [0.16, 0.0]
    late = [Transport(shifted, legs, balance=balance).plan[:, 20:].sum() / 40 for balance in (0.0, 0.8, 1.0)]
    assert late[0] < 0.32
    assert late[0] + 0.02 < late[1] < late[2] - 0.05


def test_further_points_go_where_their_neighbours_go(points):
    flat = points * [1, 1, 0]
    dense = np.concatenate([flat, np.random.default_rng(2).random((2000, 3)) * [1, 1, 0]])
    transport = Transport(flat, flat)
    np.testing.assert_array_equal(transport.images(flat, flat), transport.plan.argmax(axis=1))
    assert np.linalg.norm(dense[transport.images(dense, dense)] - dense, axis=1).mean() < 0.04


def test_balanced_transport_has_both_marginals(points):
    plan = Transport(points, points[:200], balance=1.0, iterations=500).plan
    np.testing.assert_allclose(plan.sum(axis=1), 1, rtol=1e-4)
    np.testing.assert_allclose(plan.sum(axis=0), 300 / 200, rtol=1e-2)


def test_a_sharper_plan_is_closer_to_a_permutation(points):
    largest = [Transport(points, points, sharpness=sharpness).plan.max(axis=1).mean() for sharpness in (0.1, 0.45, 2.0)]
    assert largest[0] > largest[1] + 0.1 > largest[2] + 0.2
