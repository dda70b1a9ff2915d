"""Confidence as a chance: sure of a copy, less so where a place is wrong, and right as often as it says."""

from dataclasses import replace

import numpy as np
import pytest
from mobius_match.registration.register import register
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.geometry.interpolation import interpolate_nearby
from mobius_match.registration.confidence import confidence_features, distances_to_images, match_probabilities
from tests.shapes import lump


@pytest.fixture(scope="module")
def copy():
    surface = mm.prepare(lump(4))
    return surface, register(surface, surface, surface.proxy)


def test_a_copy_has_nothing_against_it(copy):
    surface, registration = copy
    distances = distances_to_images(surface, surface, registration)
    np.testing.assert_allclose(distances, surface.distances, atol=0.02 * surface.diameter)
    found = confidence_features(surface, surface, registration, distances)
    for kind in ("distances", "residual", "stretch"):
        assert found[kind].max() < 0.015, kind
    assert match_probabilities(surface, surface, registration, distances).min() > 0.98


def test_a_wrong_place_is_doubted_and_the_others_are_not(copy):
    surface, registration = copy
    sample = 20
    here = int(np.searchsorted(surface.proxy, surface.samples[sample]))
    image = registration.image.copy()
    image[here] = surface.samples[np.argmax(surface.distances[sample])]
    positions = registration.positions.copy()
    positions[here] = surface.mesh.vertices[image[here]]
    wrong = replace(registration, image=image, positions=positions)
    found = match_probabilities(surface, surface, wrong, distances_to_images(surface, surface, wrong))
    # The doubt spreads to what lies around.
    assert (found < found[here]).mean() < 0.01
    assert surface.proxy_geodesics[here, np.argmin(found)] < 0.1
    assert np.median(found) > 0.95


@pytest.mark.parametrize("size", [3, 200])
def test_values_between_points_come_from_the_four_nearest(size):
    generator = np.random.default_rng(0)
    points, queries, values = generator.random((size, 3)), generator.random((50, 3)), generator.random((7, size))
    queries[0] = points[0]
    apart, near = cKDTree(points).query(queries, min(4, size))
    weights = 1 / (apart + 1e-3 * apart.mean()) ** 2
    wanted = np.einsum("nqk,qk->nq", values[:, near], weights / weights.sum(axis=1, keepdims=True))
    found = interpolate_nearby(points, queries, values)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    np.testing.assert_allclose(found[:, 0], values[:, 0], atol=1e-4)


@pytest.mark.parametrize("name", examples.names())
def test_nine_of_ten_matches_of_confidence_09_are_right(name):
    source, target = examples.paths(name)
    result = mm.match(source, target)
    mesh = mm.read_mesh(target)
    faces, barycentric = examples.truth(name)
    places = np.einsum("ijk,ij->ik", mesh.vertices[mesh.faces[faces]], barycentric)[result.pairs[:, 0]]
    points = result.target_points
    found = np.einsum("qk,qkd->qd", points.barycentric, mesh.vertices[points.corners])
    right = np.linalg.norm(found - places, axis=1) < 0.05 * result.target_info["diameter"]
    sure = result.confidence >= 0.9
    assert sure.sum() >= 30
    assert right[sure].mean() >= 0.9
