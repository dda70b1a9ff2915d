"""Closest points on the faces around a vertex, against hand-made ones and a dense search."""

import numpy as np
import pytest
from trimesh.triangles import closest_point

from mobius_match.geometry.points import closest_points
from tests.shapes import lump

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def test_points_of_a_square():
    queries = np.array([[0.75, 0.25, 0.3], [0.25, 0.75, -1.0], [-1.0, -1.0, 0.0], [2.0, 0.5, 0.0]])
    found = closest_points(SQUARE, HALVES, queries, np.array([0, 2, 0, 1]))
    np.testing.assert_array_equal(found.faces[[0, 1, 3]], [0, 1, 0])
    places = np.einsum("qk,qkd->qd", found.barycentric, SQUARE[found.corners])
    np.testing.assert_allclose(places, [[0.75, 0.25, 0], [0.25, 0.75, 0], [0, 0, 0], [1, 0.5, 0]], atol=1e-12)
    assert found.nearest[2] == 0


def test_a_short_text():
    points = closest_points(SQUARE, HALVES, SQUARE, np.arange(4))
    assert repr(points) == "<SurfacePoints: faces (4,), corners (4, 3), barycentric (4, 3)>"


def test_points_on_the_surface_are_their_own():
    vertices, faces = lump(2)
    generator = np.random.default_rng(0)
    chosen = generator.integers(len(faces), size=200)
    weights = generator.dirichlet(np.ones(3), 200)
    queries = np.einsum("qk,qkd->qd", weights, vertices[faces[chosen]])
    found = closest_points(vertices, faces, queries, faces[chosen, weights.argmax(axis=1)])
    np.testing.assert_array_equal(found.faces, chosen)
    np.testing.assert_allclose(found.barycentric, weights, atol=1e-9)
    np.testing.assert_array_equal(found.nearest, faces[chosen, weights.argmax(axis=1)])


def test_faces_without_area_give_their_vertex():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    found = closest_points(vertices, np.array([[0, 1, 2]]), np.array([[0.4, 1.0, 0]]), np.array([1]))
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1)
    assert np.isfinite(found.barycentric).all()


@pytest.mark.parametrize("flatness", [1.0, 1e-3, 0.0])
def test_closest_points_of_triangles_are_those_of_trimesh(flatness):
    """Queries above, beside and beyond all corners and edges; triangles may be slivers or lie on a line."""
    generator = np.random.default_rng(3)
    triangles = generator.normal(size=(3000, 3, 3))
    triangles[:, 2] = triangles[:, 0] + 0.4 * (triangles[:, 1] - triangles[:, 0]) + flatness * triangles[:, 2]
    queries = 2 * generator.normal(size=(3000, 3))
    corners = np.arange(9000)
    found = closest_points(triangles.reshape(-1, 3), corners.reshape(-1, 3), queries, corners[::3])
    weights, places = found.barycentric, found.values(triangles.reshape(-1, 3))
    np.testing.assert_array_equal(found.faces, np.arange(3000))
    assert weights.min() >= 0
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(places, closest_point(triangles, queries), atol=1e-9)
    if flatness == 1:
        assert set((weights > 0).sum(axis=1)) == {1, 2, 3}


def test_the_closest_point_of_a_triangle_that_is_a_point():
    found = closest_points(np.ones((3, 3)), np.array([[0, 1, 2]]), np.array([[1.0, 1, 3]]), np.array([2]))
    assert found.barycentric.sum() == 1
    assert found.faces == [0]


def test_the_search_moves_over_the_surface_and_never_to_another_sheet():
    """A strip folded like a U: from one arm the other is nearer in space, but the bend is far."""
    along = np.linspace(0, 10, 41)
    arm = np.stack([along, 0 * along, 0 * along], axis=1)
    rows = np.concatenate([arm[::-1], arm + np.array([0, 0, 0.2])])
    vertices = np.concatenate([rows, rows + np.array([0, 1, 0])])
    low = np.arange(len(rows) - 1)
    high = low + len(rows)
    faces = np.concatenate([np.stack([low, low + 1, high], axis=1), np.stack([low + 1, high + 1, high], axis=1)])
    query = np.array([[3.05, 0.5, 0.15]])  # nearer to the upper arm
    found = closest_points(vertices, faces, query, np.array([0]))  # from the far end of the lower one
    np.testing.assert_allclose(found.values(vertices), [[3.05, 0.5, 0.0]], atol=1e-12)
