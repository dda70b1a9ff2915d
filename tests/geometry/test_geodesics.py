"""Geodesic distances on shapes where they are known."""

import numpy as np
import pytest

from mobius_match.geometry.geodesics import geodesic_solver
from tests.shapes import bent, grid, icosphere, tube


@pytest.mark.parametrize(("method", "mean_error"), [("exact", 0.002), ("heat", 0.02), ("dijkstra", 0.1)])
def test_sphere(method, mean_error):
    vertices, faces = icosphere(4)
    found = geodesic_solver(vertices, faces, method)(0)
    expected = np.arccos(np.clip(vertices @ vertices[0], -1, 1))
    others = expected > 0.2
    assert found[0] == pytest.approx(0, abs=1e-6)
    assert np.abs(found[others] / expected[others] - 1).mean() < mean_error


def test_exact_is_exact_on_a_flat_sheet_and_dijkstra_never_shorter():
    vertices, faces = grid(9, 7)
    expected = np.linalg.norm(vertices - vertices[17], axis=1)
    np.testing.assert_allclose(geodesic_solver(vertices, faces, "exact")(17), expected, atol=1e-9)
    along_edges = geodesic_solver(vertices, faces, "dijkstra")(17)
    assert (along_edges >= expected - 1e-12).all()
    assert along_edges[17 + 1] == 1.0


def test_distances_go_around_a_hole_and_along_a_tube():
    vertices, faces = grid(9, 9, holes=tuple((x, y) for x in range(3, 6) for y in range(1, 8)))
    start, end = 4 * 10 + 2, 4 * 10 + 7  # either side of the hole, nearest way around its corner
    found = geodesic_solver(vertices, faces, "exact")(start)[end]
    assert found == pytest.approx(2 * np.hypot(1, 3) + 3, rel=1e-9)
    vertices, faces = tube(around=48, along=40)
    assert geodesic_solver(vertices, faces, "exact")(0)[24] == pytest.approx(np.pi, rel=0.01)


def test_unknown_method_is_named():
    with pytest.raises(ValueError, match="'magic'"):
        geodesic_solver(*bent(grid()), "magic")
