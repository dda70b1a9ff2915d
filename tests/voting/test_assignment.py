"""Section 8 on matrices small enough to work out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mobius_match.voting.assignment import (
    feature_vectors,
    linear_assignment,
    max_row_column,
    normalized,
    recover,
    relative_distances,
)

C = np.array([[0.9, 0.8, 0.0], [0.85, 0.1, 0.0], [0.3, 0.0, 0.0]])


def test_greedy_by_hand():
    """0.9 strikes row 0 and column 0; of what is left 0.1 is the largest; row 2 has nothing left."""
    pairs, confidence = max_row_column(C)
    np.testing.assert_array_equal(pairs, [[0, 0], [1, 1]])
    np.testing.assert_array_equal(confidence, [0.9, 0.1])


def test_linear_assignment_by_hand():
    """Globally 0.8 + 0.85 = 1.65 beats 0.9 + 0.1; pairs of value zero are left out."""
    pairs, confidence = linear_assignment(C)
    np.testing.assert_array_equal(pairs, [[1, 0], [0, 1]])
    np.testing.assert_array_equal(confidence, [0.85, 0.8])


def test_equal_entries_are_taken_in_reading_order():
    pairs, _ = max_row_column(np.ones((2, 3)))
    np.testing.assert_array_equal(pairs, [[0, 0], [1, 1]])


@given(arrays(float, st.tuples(st.integers(1, 7), st.integers(1, 7)), elements=st.sampled_from([0, 0.1, 0.5, 0.7, 1])))
def test_greedy_is_a_maximal_matching_in_falling_order(matrix):
    pairs, confidence = max_row_column(matrix)
    rows, columns = pairs.T
    assert len(set(rows)) == len(rows)
    assert len(set(columns)) == len(columns)
    assert (np.diff(confidence) <= 0).all()
    np.testing.assert_array_equal(matrix[rows, columns], confidence)
    left = matrix.copy()
    left[rows], left[:, columns] = 0, 0
    assert not left.any(), "an entry above zero could still be taken"
    for k, (row, column) in enumerate(pairs):
        rest = np.delete(np.delete(matrix, rows[:k], axis=0), columns[:k], axis=1)
        assert rest.max() == matrix[row, column]


@given(arrays(float, (5, 6), elements=st.floats(0, 1)))
def test_linear_assignment_is_never_worse_in_sum(matrix):
    assert linear_assignment(matrix)[1].sum() >= max_row_column(matrix)[1].sum() - 1e-12


def test_normalized():
    np.testing.assert_array_equal(normalized(np.array([[2.0, 8.0]])), [[0.25, 1.0]])
    np.testing.assert_array_equal(normalized(np.zeros((2, 2))), np.zeros((2, 2)))


def test_feature_vectors_do_not_change_with_scale():
    rng = np.random.default_rng(0)
    points = rng.random((8, 2))
    distances = np.linalg.norm(points[:, None] - points, axis=-1)
    trusted = np.array([0, 2, 5])
    np.testing.assert_allclose(feature_vectors(distances, trusted), feature_vectors(7.5 * distances, trusted))
    np.testing.assert_allclose(np.median(feature_vectors(distances, trusted)[1]), 1.0)


def test_relative_distance_by_hand():
    """|(3, 4) - (0, 5)|^2 / (5 * 5) = 10 / 25."""
    np.testing.assert_allclose(relative_distances(np.array([[3.0, 4.0]]), np.array([[0.0, 5.0]])), [[0.4]])


@pytest.fixture
def line():
    """Ten points on a line with uneven gaps, and their distances."""
    x = np.array([0.0, 1.0, 2.1, 3.3, 4.2, 5.6, 6.4, 7.7, 8.5, 10.0])
    return np.abs(x[:, None] - x)


def test_recovery_keeps_a_true_weak_pair_and_drops_a_false_one(line):
    trusted = np.array([True, True, True, True, False, False])
    pairs = np.array([[0, 0], [9, 9], [3, 3], [6, 6], [4, 4], [1, 8]])
    np.testing.assert_array_equal(recover(pairs, trusted, line, line, 0.5, 0.5), [0, 0, 0, 0, 1, 0])


def test_recovery_takes_a_neighbour_within_delta_only(line):
    """Weak pair 4 -> 5: in feature space 4's twin is 4, which lies 1.4 from 5."""
    trusted = np.array([True, True, True, True, False])
    pairs = np.array([[0, 0], [9, 9], [3, 3], [6, 6], [4, 5]])
    assert not recover(pairs, trusted, line, line, 1.3, 1.3)[4]
    assert recover(pairs, trusted, line, line, 1.5, 1.5)[4]
    assert not recover(pairs, trusted, line, line, 1.5, 1.3)[4], "both directions must agree"
    assert not recover(pairs, trusted, line, line, 1.3, 1.5)[4], "both directions must agree"


def test_two_trusted_pairs_recover_nothing(line):
    pairs = np.array([[0, 0], [9, 9], [4, 4]])
    assert not recover(pairs, np.array([True, True, False]), line, line, 5, 5).any()
