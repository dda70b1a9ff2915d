"""All maps between two discs: the right one is the best, whatever the mesh, the units and the bend."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.discs import disc_maps, disc_matches, distance_error, rigid_error
from mobius_match.alignments.parameters import AlignmentParameters
from tests.shapes import cap, disc, rotation

PARAMETERS = AlignmentParameters()
CLUSTERS, DISCS = PARAMETERS.clusters, PARAMETERS.discs


@pytest.fixture(scope="module")
def source():
    return mm.prepare(cap(0))


def turned(arrays):
    """The same elsewhere in space and in another unit."""
    vertices, faces = arrays
    return 30 * vertices @ rotation(3) + (5, -8, 2), faces


def errors(matches, source, target, seed, count=1500):
    """Distances in the flat disc between the samples that are matched (q, 2)."""
    one, two = disc(count, seed=0)[0], disc(count, seed=seed)[0]
    return np.linalg.norm(one[source.samples[matches[:, 0]]] - two[target.samples[matches[:, 1]]], axis=1)


@pytest.mark.parametrize("bend", [0.0, 1.0])
def test_the_best_map_of_a_disc_to_another_mesh_of_it_is_the_right_one(source, bend):
    target = mm.prepare(turned(cap(1, bend=bend)))
    matches = disc_matches(source, target, DISCS, CLUSTERS)
    assert len(matches[0]) >= 50
    # Samples are about 0.18 apart.
    assert np.mean(errors(matches[0], source, target, 1) < 0.2) > 0.9
    assert all(np.mean(errors(other, source, target, 1)) > 0.25 for other in matches[1:])


def test_the_mirror_image_is_not_among_the_maps(source):
    vertices, faces = cap(1)
    _, right = disc_maps(source, mm.prepare((vertices, faces)), DISCS)
    pairs, weights = disc_maps(source, mm.prepare((vertices * (-1, 1, 1), faces[:, ::-1])), DISCS)
    assert weights[0] < 0.8 * right[0]
    assert (np.diff(weights) <= 0).all()
    assert all(len(np.unique(row[row >= 0])) == (row >= 0).sum() for row in pairs[:50])


def test_closed_surfaces_and_small_holes_are_no_discs(source, lump_surface):
    assert disc_matches(source, lump_surface, DISCS, CLUSTERS) == []
    assert disc_matches(lump_surface, source, DISCS, CLUSTERS) == []


def test_errors_of_pairs_are_those_of_a_plain_computation():
    rng = np.random.default_rng(0)
    rows, columns = rng.permutation(40)[:25], rng.permutation(30)[:25]
    one, two = rng.random((40, 40)), rng.random((30, 30))
    one, two = one + one.T, two + two.T
    between = [d[np.ix_(p, p)][np.triu_indices(25, 1)] for d, p in ((one, rows), (two, columns))]
    assert distance_error(25, rows, columns, one, two) == pytest.approx(np.abs(between[0] - between[1]).mean())
    x, y = rng.random((40, 3)), rng.random((30, 3))
    a, b = (points[p] - points[p].mean(axis=0) for points, p in ((x, rows), (y, columns)))
    u, s, v = np.linalg.svd(a.T @ b)
    trace = s[0] + s[1] + s[2] * np.sign(np.linalg.det(u @ v))
    rotated = trace / (a**2).sum() * a @ (u * (1, 1, np.sign(np.linalg.det(u @ v)))) @ v
    assert rigid_error(25, rows, columns, x, y) == pytest.approx(np.sqrt(((rotated - b) ** 2).sum(axis=1).mean()))


def test_a_rigid_motion_with_a_scale_leaves_no_error():
    points = np.random.default_rng(1).random((20, 3))
    same = np.arange(20)
    assert rigid_error(20, same, same, points, 4 * points @ rotation(2) + 3) < 1e-6
    assert rigid_error(20, same, same, points, points * (1, 1, -1)) > 0.05
