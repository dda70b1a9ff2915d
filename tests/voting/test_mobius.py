"""The laws of the Möbius group, for points anywhere in the extended plane."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mobius_match.voting.mobius import (
    CANONICAL_TRIANGLE,
    INFINITY,
    apply,
    compose,
    cross_ratio,
    from_three_points,
    homogeneous,
    inverse,
    to_zero_one_infinity,
)

finite = st.complex_numbers(max_magnitude=100, allow_nan=False, allow_infinity=False)
extended = st.one_of(finite, st.just(INFINITY))


def sphere(points):
    """Points of the extended plane on the unit sphere, where all of them are near or far alike."""
    p, q = homogeneous(points)[..., 0], homogeneous(points)[..., 1]
    size = np.abs(p) ** 2 + np.abs(q) ** 2
    across = 2 * p * np.conj(q) / size
    return np.stack([across.real, across.imag, (np.abs(p) ** 2 - np.abs(q) ** 2) / size], axis=-1)


def assert_same_points(first, second, tolerance=1e-7):
    np.testing.assert_allclose(sphere(np.asarray(first)), sphere(np.asarray(second)), atol=tolerance)


def apart(points, least=0.05):
    on_sphere = sphere(np.array(points))
    return all(np.linalg.norm(on_sphere[i] - on_sphere[j]) > least for i in range(len(points)) for j in range(i))


cells = st.tuples(st.integers(-6, 6), st.integers(-6, 6))
offsets = st.complex_numbers(max_magnitude=0.2, allow_nan=False, allow_infinity=False)


@st.composite
def triples(draw, infinity=True):
    """Three points that lie apart: anywhere in different squares of a grid, or one of them at infinity."""
    found = [
        complex(*cell) / 2 + draw(offsets) / 2 for cell in draw(st.lists(cells, min_size=3, max_size=3, unique=True))
    ]
    if infinity and draw(st.booleans()):
        found[draw(st.integers(0, 2))] = INFINITY
    return np.array(found)


@given(triples(), triples())
def test_three_points_go_to_three_points(sources, targets):
    assert_same_points(apply(from_three_points(sources, targets), sources), targets)


@given(triples())
def test_zero_one_and_infinity(points):
    assert_same_points(apply(to_zero_one_infinity(points), points), [0, 1, INFINITY])


def test_infinity_is_met_exactly():
    transformation = to_zero_one_infinity(np.array([1, 2j, 3]))
    np.testing.assert_array_equal(apply(transformation, np.array([3])), [INFINITY])
    assert np.isfinite(apply(transformation, np.array([INFINITY])))[0]
    assert apply(np.eye(2), np.array([INFINITY]))[0] == INFINITY
    assert apply(np.array([[0, 1], [1, 0]]), np.array([0j]))[0] == INFINITY
    assert apply(np.array([[0, 1], [1, 0]]), np.array([INFINITY]))[0] == 0


@given(triples(), triples(), triples(), extended)
def test_composition_is_application_in_turn(a, b, c, z):
    first, second = from_three_points(a, b), from_three_points(b, c)
    points = np.array([z])
    assert_same_points(apply(compose(second, first), points), apply(second, apply(first, points)), 1e-5)


@given(triples(), triples(), triples())
def test_composition_is_associative(a, b, c):
    f, g, h = from_three_points(a, b), from_three_points(b, c), from_three_points(c, a)
    assert_same_points(apply(compose(compose(f, g), h), a), apply(compose(f, compose(g, h)), a), 1e-4)


@given(triples(), triples(), extended)
def test_inverse_undoes(a, b, z):
    transformation = from_three_points(a, b)
    points = np.array([z])
    assert_same_points(apply(compose(inverse(transformation), transformation), points), points, 1e-5)


@given(triples(), triples(), extended)
def test_cross_ratio_is_invariant(a, b, z):
    image = apply(from_three_points(a, b), np.array([z]))[0]
    assert_same_points([cross_ratio(z, *a)], [cross_ratio(image, *b)], 1e-5)


@given(triples(infinity=False), finite)
def test_cross_ratio_is_the_textbooks(points, z):
    z1, z2, z3 = points
    assume(apart([z, z3]))
    expected = (z - z1) * (z2 - z3) / ((z - z3) * (z2 - z1))
    assert cross_ratio(z, *points) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_equal_points_are_refused():
    with pytest.raises(ValueError, match="three distinct points"):
        from_three_points(np.array([1, 1, 2]), CANONICAL_TRIANGLE)
    with pytest.raises(ValueError, match="three distinct points"):
        to_zero_one_infinity(np.array([INFINITY, 0, INFINITY]))


def test_canonical_triangle_is_equilateral():
    sides = np.abs(CANONICAL_TRIANGLE - np.roll(CANONICAL_TRIANGLE, 1))
    np.testing.assert_allclose(sides, np.sqrt(3), rtol=1e-15)
