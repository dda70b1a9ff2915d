"""Sixteen numbers at a time against numpy."""

import numba
import numpy as np

from mobius_match.voting import lanes


@numba.njit
def arithmetic(a, b, c, out):
    """``out``, sixteen from the third on: (a - b) * b + c, each lane by itself."""
    one, other = lanes.load(a, 1), lanes.load(b, 0)
    lanes.store(out, 2, (one - other) * other + lanes.spread(c))


@numba.njit
def comparison(a, b, out):
    """Lesser numbers, b where a < b and -9 elsewhere; the least, whether and where they are equal."""
    one, other = lanes.load(a, 0), lanes.load(b, 0)
    lanes.store(out, 0, lanes.minimum(one, other))
    lanes.store(out, 16, lanes.where_less(one, other, other, lanes.spread(np.int32(-9))))
    return lanes.least_lane(one), lanes.any_equal(one, other), lanes.first_equal(one, other)


@numba.njit
def as_bits(a, out):
    lanes.store(out, 0, lanes.bits(lanes.load(a, 0)))


def test_arithmetic_is_that_of_numbers():
    rng = np.random.default_rng(0)
    a, b, c = rng.normal(size=20).astype(np.float32), rng.normal(size=(4, 4)).astype(np.float32), np.float32(0.3)
    out = np.zeros(20, np.float32)
    arithmetic(a, b, c, out)
    np.testing.assert_array_equal(out[2:18], (a[1:17] - b.ravel()) * b.ravel() + c)
    assert not out[[0, 1, 18, 19]].any()


def test_comparisons_are_those_of_numbers():
    rng = np.random.default_rng(0)
    out = np.zeros(32, np.int32)
    for _ in range(50):
        a, b = rng.integers(-20, 20, (2, 16)).astype(np.int32)
        least, equal, first = comparison(a, b, out)
        np.testing.assert_array_equal(out, np.concatenate([np.minimum(a, b), np.where(a < b, b, -9)]))
        assert (least, equal) == (a.min(), (a == b).any())
        assert first == np.argmax(a == b)  # 0 where none is


def test_bits_are_those_of_the_numbers():
    a, out = np.random.default_rng(0).normal(size=16).astype(np.float32), np.zeros(16, np.int32)
    as_bits(a, out)
    np.testing.assert_array_equal(out, a.view(np.int32))
