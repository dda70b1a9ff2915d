"""Errors of maps whose errors are known analytically."""

from pathlib import Path

import numpy as np
import pytest

from mobius_match.errors import FormatError
from mobius_match.evaluation.datasets import Case, Truth
from mobius_match.evaluation.metrics import diameter, geodesic_distances
from mobius_match.evaluation.scoring import Scorer
from mobius_match.mesh import Mesh, repair
from tests.shapes import grid, icosphere, lump

TOLERANCE = {"exact": 0.006, "heat": 0.05}
"""Of distances on the unit sphere and its polyhedron."""


def scorer(source, target, truth, method="exact", size=None):
    case = Case("a-b", "", Path("a"), Path("b"), truth)
    return Scorer(case, source, target, method, diameter(target, method) if size is None else size)


def identity(count, mirrored=None, landmarks=False):
    return Truth(np.arange(count), np.arange(count), mirrored, landmarks)


def fifth_of_a_turn(vertices):
    """Number of the vertex to which a turn by 72 degrees takes each, and the great-circle distance between both."""
    axis = vertices[0]
    angle = 2 * np.pi / 5
    turned = (
        vertices * np.cos(angle)
        + np.cross(axis, vertices) * np.sin(angle)
        + np.outer(vertices @ axis, axis) * (1 - np.cos(angle))
    )
    image = np.argmax(turned @ vertices.T, axis=1)
    assert np.linalg.norm(vertices[image] - turned, axis=1).max() < 1e-6  # the mesh has this symmetry
    height = vertices @ axis
    return image, np.arccos(np.clip(height**2 + (1 - height**2) * np.cos(angle), -1, 1))


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_a_turned_sphere(method):
    vertices, faces = icosphere(3)
    image, expected = fifth_of_a_turn(vertices)
    mesh = Mesh(3 * vertices, faces)
    known = scorer(mesh, mesh, identity(len(vertices)), method, size=3 * np.pi)
    found = known.score_map(image)
    assert np.abs(found["direct"] * np.pi - expected).max() < TOLERANCE[method] * expected.max()
    assert found["mirrored"] is None
    assert found["unmapped"] == 0
    matches = np.stack([np.arange(0, 60), image[:60]], axis=1)
    sparse = known.score(matches, np.linspace(1, 0, 60))
    assert sparse["direct"] == pytest.approx(found["direct"][:60], abs=1e-12)


def test_a_shifted_flat_grid():
    vertices, faces = grid(20, 15)
    mesh = Mesh(vertices, faces)
    inside = np.flatnonzero((vertices[:, 0] < 17) & (vertices[:, 1] < 11))
    shifted = np.full(len(vertices), -1)
    shifted[inside] = inside + 3 + 4 * 21  # three to the right and four up
    found = scorer(mesh, mesh, identity(len(vertices)), size=25.0).score_map(shifted)
    assert found["direct"] == pytest.approx(np.full(len(inside), 5 / 25), abs=1e-9)
    assert found["unmapped"] == len(vertices) - len(inside)


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_the_true_map_has_no_error_and_the_mirrored_map_no_mirrored_error(method):
    vertices, faces = icosphere(2)
    mirror = np.argmax((vertices * [-1, 1, 1]) @ vertices.T, axis=1)
    mesh = Mesh(vertices, faces)
    known = scorer(mesh, mesh, identity(len(vertices), mirror), method)
    off_plane = np.abs(vertices[:, 0]) > 0.1
    for image, right, wrong in ((np.arange(len(vertices)), "direct", "mirrored"), (mirror, "mirrored", "direct")):
        dense = known.score_map(image)
        sparse = known.score(np.stack([np.arange(len(vertices)), image], axis=1), np.linspace(1, 0, len(vertices)))
        for found in (dense, sparse):
            assert not found[right].any()
            assert (found[wrong][off_plane] > 0.05).all()


def test_a_random_map_of_a_sphere_has_a_mean_error_of_a_quarter_circumference():
    vertices, faces = icosphere(3)
    mesh = Mesh(vertices, faces)
    image = np.random.default_rng(5).integers(0, len(vertices), len(vertices))
    found = scorer(mesh, mesh, identity(len(vertices)), "heat", size=1.0).score_map(image)["direct"]
    # Angles between random points have the mean pi/2 and the variance pi**2/4 - 2; heat is some percent off.
    error = 3 * np.sqrt((np.pi**2 / 4 - 2) / len(vertices))
    assert found.mean() == pytest.approx(np.pi / 2, abs=error + 0.02)
    assert found.std() == pytest.approx(np.sqrt(np.pi**2 / 4 - 2), abs=error)


def test_a_match_is_compared_with_the_nearest_known_point():
    vertices, faces = grid(20, 15)
    mesh = Mesh(vertices, faces)
    listed = np.flatnonzero((vertices[:, 0] % 5 == 0) & (vertices[:, 1] % 5 == 0))
    start = 4 + 4 * 21  # at (4, 4), so the point (5, 5) counts
    known = scorer(mesh, mesh, Truth(listed, listed), size=1.0)
    found = known.score(np.array([[start, start], [start, 5 + 5 * 21], [start, 5 + 8 * 21]]), np.array([0.9, 0.8, 0.1]))
    assert found["direct"] == pytest.approx([np.sqrt(2), 0, 3], abs=1e-9)


def test_nearest_is_along_the_surface_not_across_a_gap():
    """A strip folded in two, its halves closer to each other than the listed points of one half."""
    vertices, faces = grid(20, 3)
    folded = vertices.copy()
    folded[vertices[:, 0] > 10, 0] = 20 - vertices[vertices[:, 0] > 10, 0]
    folded[vertices[:, 0] > 10, 2] = 0.5
    below, above, listed = 4 + 21, 16 + 21, np.array([2 + 21, 16 + 21])  # (4, 1), the point over it, and (2, 1)
    mesh = Mesh(folded, faces)
    found = scorer(mesh, mesh, Truth(listed, listed), size=1.0).score(np.array([[below, below]]), np.ones(1))
    assert np.linalg.norm(folded[below] - folded[above]) < np.linalg.norm(folded[below] - folded[listed[0]])
    assert found["direct"] == pytest.approx([2.0], abs=1e-9)


def test_landmarks_are_compared_with_the_nearest_match():
    vertices, faces = grid(20, 15)
    mesh = Mesh(vertices, faces)

    def at(x, y):
        return x + 21 * y

    truth = Truth(
        np.array([at(2, 2), at(3, 2), at(15, 10)]), np.array([at(4, 2), at(9, 2), at(15, 10)]), landmarks=True
    )
    matches = np.array([[at(8, 14), at(8, 14)], [at(2, 3), at(4, 2)], [at(15, 11), at(15, 12)]])
    found = scorer(mesh, mesh, truth, size=1.0).score(matches, np.array([0.9, 0.8, 0.7]))
    assert found["direct"] == pytest.approx([np.nan, (0 + 5) / 2, 2], abs=1e-9, nan_ok=True)
    assert found["ranking"] is None  # two known errors


def test_difference_between_exact_and_heat():
    mesh = Mesh(*lump(3))
    rng = np.random.default_rng(0)
    pairs = np.stack([np.arange(40), rng.integers(0, len(mesh.vertices), 40)], axis=1)
    found = scorer(mesh, mesh, identity(len(mesh.vertices)), size=2.0).score(pairs, np.linspace(1, 0, 40))
    exact, heat = (geodesic_distances(mesh, pairs[:, 1], pairs[:, 0], method) / 2 for method in ("exact", "heat"))
    assert found["heat_difference"] == pytest.approx(np.abs(exact - heat).mean(), rel=1e-9)
    assert found["heat_difference"] > 0
    quick = scorer(mesh, mesh, identity(len(mesh.vertices)), "heat", 2.0).score(pairs, np.linspace(1, 0, 40))
    assert quick["heat_difference"] is None
    assert quick["direct"] == pytest.approx(heat, rel=1e-9)


def test_vertex_numbers_are_those_of_the_file():
    vertices, faces = grid(10, 8)
    extra = np.vstack([[[50.0, 50, 0], [60, 60, 0]], vertices])  # in no face
    mesh = repair(Mesh(extra, faces + 2))
    assert len(mesh.vertices) == len(vertices)
    known = scorer(mesh, mesh, identity(len(extra)), size=1.0)
    found = known.score(np.array([[2, 2], [3, 4]]), np.array([1.0, 0.5]))
    assert found["direct"] == pytest.approx([0, 1], abs=1e-9)
    dense = np.arange(len(extra))
    dense[5] = 0  # a vertex that is in no face is no place on the surface
    assert known.score_map(dense)["unmapped"] == 1
    assert len(known.score_map(dense)["direct"]) == len(vertices) - 1
    # So is a mirrored truth there, and its point does not count at all.
    mirrored = np.arange(len(extra))
    mirrored[7:10] = 1
    found = scorer(mesh, mesh, identity(len(extra), mirrored), size=1.0).score_map(np.arange(len(extra)))
    assert [len(found[name]) for name in ("direct", "mirrored")] == [len(vertices) - 3] * 2
    assert found["unmapped"] == 0


def test_numbers_of_another_mesh_are_refused():
    mesh = Mesh(*grid(4, 4))
    mesh_of_25 = identity(25)
    pairs = np.array([[0, 0]])
    with pytest.raises(FormatError, match=r"vertex 25 .* the file has 25 vertices"):
        scorer(mesh, mesh, identity(26), size=1.0).score(pairs, np.ones(1))
    with pytest.raises(FormatError, match="the map has 24 entries and array has 25 vertices"):
        scorer(mesh, mesh, mesh_of_25, size=1.0).score_map(np.arange(24))
    with pytest.raises(FormatError, match="vertex 30"):
        scorer(mesh, mesh, mesh_of_25, size=1.0).score_map(np.full(25, 30))
    with pytest.raises(FormatError, match="no point of known correspondence"):
        scorer(mesh, mesh, mesh_of_25, size=1.0).score_map(np.full(25, -1))
