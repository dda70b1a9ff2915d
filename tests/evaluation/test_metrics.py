"""Distances, coverage and ranking with analytic answers."""

import numpy as np
import pytest

from mobius_match.evaluation.metrics import coverage, diameter, geodesic_distances, ranking
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.mesh import Mesh
from tests.shapes import bent, grid, icosphere, lump, tube


def folded_sheet():
    """Two close layers joined at one edge: points that are near in space may be far apart along the surface."""
    vertices, faces = grid(20, 9)
    return np.stack([np.abs(vertices[:, 0] - 10), vertices[:, 1], 0.2 * (vertices[:, 0] > 10)], axis=1), faces


@pytest.mark.parametrize(
    "shape",
    [lump(3), bent(grid(16, 12)), grid(14, 11, holes=((5, 5), (6, 5), (2, 8))), tube(), icosphere(2), folded_sheet()],
)
def test_exact_distances_are_those_of_the_whole_mesh(shape):
    vertices, faces = shape
    mesh = Mesh(vertices * 1000, faces)
    rng = np.random.default_rng(0)
    sources = rng.integers(0, len(vertices), 4).repeat(40)
    targets = rng.integers(0, len(vertices), len(sources))
    solver = geodesic_solver(mesh.vertices, mesh.faces, "exact")
    expected = np.concatenate([solver(int(s))[targets[i * 40 : i * 40 + 40]] for i, s in enumerate(sources[::40])])
    # The solver merges what is closer than its own tolerance, in another order on a part of the mesh.
    assert geodesic_distances(mesh, sources, targets) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_a_vertex_has_no_distance_from_itself():
    mesh = Mesh(*lump(2))
    for method in ("exact", "heat"):
        assert geodesic_distances(mesh, np.array([5, 7]), np.array([5, 7]), method).tolist() == [0, 0]
    assert geodesic_distances(mesh, np.zeros(0, int), np.zeros(0, int)).shape == (0,)


@pytest.mark.parametrize(("method", "tolerance"), [("exact", 1e-9), ("heat", 0.08)])
def test_distances_on_a_flat_sheet_are_those_in_the_plane(method, tolerance):
    vertices, faces = grid(20, 15)
    rng = np.random.default_rng(1)
    sources, targets = rng.integers(0, len(vertices), (2, 60))
    expected = np.linalg.norm(vertices[sources] - vertices[targets], axis=1)
    assert geodesic_distances(Mesh(vertices, faces), sources, targets, method) == pytest.approx(
        expected, abs=15 * tolerance
    )


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_diameter_of_a_sphere_is_half_its_circumference(method):
    vertices, faces = icosphere(4)
    assert diameter(Mesh(50 * vertices, faces), method) == pytest.approx(50 * np.pi, rel=0.015)


def test_diameter_of_a_sheet_is_its_diagonal():
    assert diameter(Mesh(*grid(20, 15))) == pytest.approx(25, rel=1e-9)


def test_coverage_of_a_sphere():
    vertices, faces = icosphere(3)
    mesh = Mesh(7 * vertices, faces)
    everything = coverage(mesh, np.arange(len(vertices)))
    assert everything["mean"] == everything["largest"] == 0
    assert 0.98 < everything["evenness"] <= 1
    twelve = coverage(mesh, np.arange(12))  # the corners of the icosahedron
    assert twelve["evenness"] == pytest.approx(1, abs=0.02)
    # The farthest points are the centres of its faces, 0.6524 away on the unit sphere; edge paths are longer.
    assert 0.6524 < twelve["largest"] * np.sqrt(4 * np.pi) < 0.6524 * 1.12
    pole = coverage(mesh, np.array([0, 0]))
    # Mean and largest distance from a point of the unit sphere are pi/2 and pi.
    assert np.pi < pole["largest"] * np.sqrt(4 * np.pi) < np.pi * 1.15
    assert np.pi / 2 * 0.99 < pole["mean"] * np.sqrt(4 * np.pi) < np.pi / 2 * 1.15
    near = np.argsort(-vertices @ vertices[0])[:12]
    assert coverage(mesh, near)["evenness"] < 0.8
    assert coverage(mesh, near)["largest"] > twelve["largest"] * 3


def test_evenness_of_two_unequal_parts():
    vertices, faces = grid(40, 1)
    found = coverage(Mesh(vertices, faces), np.flatnonzero((vertices[:, 1] == 0) & np.isin(vertices[:, 0], (0, 20))))
    shares = np.array([0.25, 0.75])  # the border runs at x = 10
    assert found["evenness"] == pytest.approx(np.exp(-(shares @ np.log(shares))) / 2, abs=0.03)


def test_ranking():
    confidence = np.array([0.9, 0.7, 0.4, 0.2])
    assert ranking(confidence, np.array([0.1, 0.2, 0.3, 0.4])) == pytest.approx(1)
    assert ranking(confidence, np.array([0.4, 0.3, 0.2, 0.1])) == pytest.approx(-1)
    assert ranking(confidence, np.array([0.1, np.nan, 0.3, 0.4])) == pytest.approx(1)
    assert ranking(confidence, np.array([0.2, 0.1, 0.3, 0.4])) == pytest.approx(1 - 6 * 2 / (4 * 15))
    assert ranking(confidence, np.full(4, 0.1)) is None
    assert ranking(confidence[:2], np.array([0.1, 0.2])) is None
