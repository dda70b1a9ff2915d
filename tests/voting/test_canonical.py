"""The kernel's maps to the canonical plane against the Möbius group of mobius.py."""

import numpy as np
import pytest

from mobius_match.voting.canonical import TURN, coordinates, to_canonical_plane
from mobius_match.voting.kernel import mutual_pairs
from mobius_match.voting.mobius import CANONICAL_TRIANGLE, INFINITY, apply, from_three_points, homogeneous


def canonical(z, triplet):
    """Images of points (p,) under the kernel's map, complex."""
    samples = coordinates(homogeneous(z))
    image = np.zeros((3, samples.shape[1]), np.float32)
    assert to_canonical_plane(samples, np.array([triplet]), 0, image)
    np.testing.assert_array_equal(image[:, len(z) :], image[:, [len(z) - 1]] * np.ones(samples.shape[1] - len(z)))
    return image[0, : len(z)] + 1j * image[1, : len(z)]


def test_to_canonical_is_the_group_element_and_a_rotation():
    """The kernel's map is the one that mobius.py finds, infinity in and out included."""
    rng = np.random.default_rng(3)
    z = np.append(rng.normal(size=20) + 1j * rng.normal(size=20), INFINITY)
    assert abs(TURN) == pytest.approx(1)
    for triplet in ([0, 5, 9], [20, 3, 4], [7, 20, 2], [1, 8, 20]):
        expected = TURN * apply(from_three_points(z[triplet], CANONICAL_TRIANGLE), z)
        np.testing.assert_allclose(canonical(z, triplet), expected, rtol=1e-5, atol=1e-6)


def test_two_points_that_differ_in_the_tenth_digit_stay_apart():
    """Flattened samples may be that close; the canonical frame must pull them apart, as it does in exact arithmetic."""
    z = 0.7 + np.array([0, 1e-10, 2.5e-10j, -1e-10, 0.3, 1e-10 + 1e-10j])
    exact = apply(from_three_points((z[:3] - 0.7) * 1e10, CANONICAL_TRIANGLE), (z - 0.7) * 1e10)
    np.testing.assert_allclose(canonical(z, [0, 1, 2]), TURN * exact, rtol=1e-5, atol=1e-5)


def test_a_pole_in_the_canonical_plane_is_far_and_pairs_with_another():
    """Points that go to infinity on both sides are each other's nearest."""
    z = np.array([1, -1, 1j, 0.2, -0.4j])
    pole = apply(np.linalg.inv(from_three_points(z[:3], CANONICAL_TRIANGLE)), np.array([INFINITY]))
    image = canonical(np.append(z, pole), [0, 1, 2])
    assert abs(image[5]) > 1e6
    points = homogeneous(np.append(z, pole))
    pairs = mutual_pairs(points, points, np.array([[0, 1, 2]]), np.array([[0, 1, 2]]))
    np.testing.assert_array_equal(pairs, [range(6)])
