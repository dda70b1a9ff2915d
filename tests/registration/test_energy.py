"""The as-rigid-as-possible energy: its sums against sums over all pairs, rigid motions, and torn pieces."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobius_match.mesh.topology import edges_of
from mobius_match.registration.energy import DeformationGraph, covariances, rotated_edge_sums
from tests.shapes import grid, icosphere, rotation

TOLERANCE = 0.07


def test_sums_are_those_over_all_pairs():
    generator = np.random.default_rng(0)
    joined = np.triu(generator.random((30, 30)) < 0.2, 1)
    joined[:, 7] = joined[7] = False  # a point without neighbours
    joined |= joined.T
    rest, moved = generator.standard_normal((2, 30, 3))
    turns = generator.standard_normal((30, 3, 3))
    start, end = np.nonzero(joined)
    starts = np.searchsorted(start, np.arange(31))
    edges = rest[start] - rest[end]
    before, after = (points[:, None] - points for points in (rest, moved))
    np.testing.assert_allclose(
        covariances(starts, end, edges, moved), np.einsum("ij,ija,ijb->iab", joined, before, after), atol=1e-12
    )
    means = (turns[:, None] + turns) / 2
    np.testing.assert_allclose(
        rotated_edge_sums(starts, end, edges, turns), np.einsum("ij,ija,ijab->ib", joined, before, means), atol=1e-12
    )


@pytest.fixture(scope="module")
def sphere():
    """A small sphere of radius 1, and its graph."""
    vertices, faces = icosphere(2)
    return vertices, DeformationGraph(vertices, edges_of(faces))


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), weight=st.floats(1e-3, 1e3))
def test_a_rigid_motion_costs_nothing_and_is_found_at_once(sphere, seed, weight):
    """Whatever the weight of the data, and although only some of the points have a target."""
    vertices, graph = sphere
    generator = np.random.default_rng(seed)
    turn, shift = rotation(seed), generator.normal(size=3)
    moved = vertices @ turn + shift
    weights = weight * (generator.random(len(vertices)) < 0.5)
    positions, rotations = graph.solve(moved, moved, weights, 1)
    np.testing.assert_allclose(positions, moved, atol=1e-6)
    np.testing.assert_allclose(rotations, np.broadcast_to(turn, rotations.shape), atol=1e-6)


def test_the_data_weight_decides_between_data_and_rigidity(sphere):
    """A sphere pulled to one of twice its size: light data leave the edges as they are, heavy data stretch them."""
    vertices, graph = sphere
    radii = [
        np.linalg.norm(graph.solve(vertices, 2 * vertices, np.full(len(vertices), weight), 4)[0], axis=1).mean()
        for weight in (1e-6, 1e-2, 1.0, 1e6)
    ]
    assert radii[0] == pytest.approx(1, abs=0.01)
    assert radii[-1] == pytest.approx(2, abs=0.01)
    assert (np.diff(radii) > 0.01).all()


def test_pieces_that_are_torn_off_are_found():
    """A sheet with a corner that is sent elsewhere; one next to a tear, but in its place, counts as continuous."""
    vertices, faces = grid(20, 10)
    points = 0.02 * vertices
    graph = DeformationGraph(points, edges_of(faces))
    corner = (vertices[:, 0] > 14) & (vertices[:, 1] > 5)
    assert 20 < corner.sum() < len(points) / 4
    for shift, torn in ((0.0, False), (0.5 * TOLERANCE, False), (3 * TOLERANCE, True)):
        images = points @ rotation(1) + shift * corner[:, None] * rotation(1)[0]
        np.testing.assert_array_equal(graph.continuous(images, TOLERANCE), ~(corner & torn))
    # A ring of points that are sent far away cuts the corner off, without moving it.
    ring = (vertices[:, :2] - [17.5, 8] @ np.eye(2)).round(9)
    ring = (np.abs(ring).max(axis=1) >= 3) & (np.abs(ring).max(axis=1) <= 4.5) & (vertices[:, 0] > 12)
    images = points + 9.0 * ring[:, None] * np.arange(len(points))[:, None]
    found = graph.continuous(images, TOLERANCE)
    inside = ~ring & (vertices[:, 0] > 14) & (vertices[:, 1] > 5)
    assert inside.sum() > 10
    assert not found[ring].any()
    assert found[~ring].all()
