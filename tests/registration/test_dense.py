"""Dense maps of copies: renumbered, rotated, scaled and remeshed, they give the identity."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.alignment import Alignment
from mobius_match.alignments.dense import dense_map_of_alignment
from mobius_match.alignments.parameters import AlignmentParameters
from mobius_match.evaluation.quality import isometric_distance, quality
from mobius_match.mesh.topology import edges_of
from mobius_match.registration.dense import dense_map
from mobius_match.registration.sparse import register
from tests.shapes import lump, rotation, true_places

PARAMETERS = AlignmentParameters()


@pytest.fixture(scope="module")
def surface(lump_surface):
    return lump_surface


@pytest.fixture(scope="module")
def short_and_long(person):
    """The person with legs of half their length, and the person."""
    long = person[0]
    vertices, faces = long.mesh.vertices.copy(), long.mesh.faces
    up = np.ptp(vertices, axis=0).argmax()
    hip = vertices[:, up].min() + 0.45 * np.ptp(vertices[:, up])
    vertices[:, up] = np.where(vertices[:, up] < hip, (vertices[:, up] + hip) / 2, vertices[:, up])
    return mm.prepare((vertices, faces)), long


def test_a_rotated_scaled_and_renumbered_copy_gives_the_identity():
    vertices, faces = lump(4)
    order = np.random.default_rng(0).permutation(len(vertices))
    number = np.argsort(order)
    copy = (5 * vertices @ rotation(1).T + 3)[order], number[faces]
    found = mm.match((vertices, faces), copy, seed=0).dense()
    np.testing.assert_array_equal(found.vertex_map, number)
    np.testing.assert_array_equal(found.inverse.vertex_map, order)
    assert quality(found).orientation == 1.0


def test_another_triangulation_gives_the_identity_to_within_an_edge(surface):
    """Every face cut in four and most of the new vertices moved along the surface's planes."""
    vertices, faces = lump(4)
    middle, cut = _cut_in_four(vertices, faces)
    other = mm.prepare((middle, cut))
    ends = vertices[np.searchsorted(np.arange(len(vertices)), surface.proxy)]
    image = np.linalg.norm(other.mesh.vertices[:, None] - ends, axis=2).argmin(axis=0)
    found = dense_map(
        surface,
        other,
        register(surface, other, image, PARAMETERS.registration),
        PARAMETERS.registration,
    )
    edge = np.linalg.norm(np.diff(vertices[edges_of(faces)], axis=1), axis=2).mean()
    assert np.linalg.norm(found.positions - vertices, axis=1).max() < edge
    assert np.linalg.norm(found.inverse.positions - middle, axis=1).max() < edge


def test_another_pose_is_mapped_to_its_true_places(person, shipped_dense):
    found = shipped_dense("person")
    apart = np.linalg.norm(found.positions - true_places("person"), axis=1) / np.sqrt(person[1].area)
    assert apart.mean() < 0.015
    assert np.mean(apart < 0.05) > 0.97
    report = quality(found)
    assert report.orientation > 0.97
    assert report.coverage > 0.99
    assert report.summary()["round_trip"] < 0.01
    assert 0.005 < isometric_distance(found) < 0.05
    assert isometric_distance(found) == pytest.approx(isometric_distance(found.inverse))


def test_the_slimmer_surface_is_deformed_onto_the_other(short_and_long):
    """The person with legs of half their length, to the person: its feet are not stretched over the shins."""
    short, long = short_and_long
    found = mm.match(short, long, seed=0, jobs=1).dense()
    assert np.linalg.norm(found.positions - long.mesh.vertices, axis=1).mean() < 0.03 * np.sqrt(long.area)
    back = mm.match(long, short, seed=0, jobs=1).dense().inverse
    assert np.linalg.norm(back.positions - long.mesh.vertices, axis=1).mean() < 0.03 * np.sqrt(long.area)


def test_the_reverse_registration_begins_with_the_forward_one(short_and_long):
    """Not with the alignment's image, which may have torn off an arm that the registration put right."""
    short, long = short_and_long
    good = register(short, long, short.proxy, PARAMETERS.registration)
    astray = Alignment(np.roll(short.proxy, 300), {}, 0.0, 1.0, registration=good)
    found = dense_map_of_alignment(short, long, astray, PARAMETERS)
    assert np.linalg.norm(found.positions - long.mesh.vertices, axis=1).mean() < 0.03 * np.sqrt(long.area)


def test_each_edge_is_listed_once():
    np.testing.assert_array_equal(edges_of(np.array([[2, 0, 1], [1, 3, 2]])), [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]])


def _cut_in_four(vertices, faces):
    edges = edges_of(faces)
    number = {tuple(edge): len(vertices) + i for i, edge in enumerate(edges.tolist())}
    middles = vertices[edges].mean(axis=1)
    cut = []
    for a, b, c in faces.tolist():
        ab, bc, ca = (number[tuple(sorted(pair))] for pair in ((a, b), (b, c), (c, a)))
        cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.array(cut)
