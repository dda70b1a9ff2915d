"""The nearest rotations against the singular value decomposition."""

import numpy as np

from mobius_match.geometry.rotations import nearest_rotations


def by_decomposition(matrices):
    left, _, right = np.linalg.svd(matrices)
    left[np.linalg.det(left @ right) < 0, :, 2] *= -1
    return left @ right


def test_equal_to_those_of_the_decomposition():
    generator = np.random.default_rng(0)
    matrices = generator.standard_normal((2000, 3, 3))
    matrices[:500] *= 10.0 ** generator.uniform(-9, 9, (500, 1, 1))
    matrices[500:1000, 2] = 0  # flat neighbourhoods
    matrices[1000:1500] = by_decomposition(matrices[1000:1500])
    found = nearest_rotations(matrices)
    np.testing.assert_allclose(found, by_decomposition(matrices), atol=1e-5)
    np.testing.assert_allclose(found[1000:1500], matrices[1000:1500], atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-9)


def test_half_turns_and_small_turns():
    for axis in range(3):
        half = -np.eye(3)
        half[axis, axis] = 1
        np.testing.assert_allclose(nearest_rotations(half[None])[0], half, atol=1e-12)
    small = np.eye(3) + 1e-9 * np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]])
    np.testing.assert_allclose(nearest_rotations(small[None])[0], small, atol=1e-12)


def test_where_no_rotation_is_nearest_it_is_the_identity():
    line = np.outer([1.0, 2, 3], [3.0, 1, 2])
    for matrix in (np.zeros((3, 3)), -np.eye(3)):
        np.testing.assert_array_equal(nearest_rotations(matrix[None])[0], np.eye(3))
    found = nearest_rotations(line[None])[0]
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-6)
