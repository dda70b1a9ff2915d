"""Confidence as a probability: high for a copy, low where a match is wrong, and calibrated."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.geometry.interpolation import interpolate_nearby
from mobius_match.registration.confidence import (
    confidence_terms,
    distances_to_images,
    match_probabilities,
    stability,
)
from mobius_match.registration.parameters import ConfidenceParameters, RegistrationParameters
from mobius_match.registration.sparse import register
from tests.shapes import grid, icosphere, true_places, tube

PARAMETERS = ConfidenceParameters()


@pytest.fixture(scope="module")
def copy(lump_surface):
    return lump_surface, register(lump_surface, lump_surface, lump_surface.proxy, RegistrationParameters())


def test_a_copy_has_features_of_zero_and_a_probability_of_one(copy):
    surface, registration = copy
    distances = distances_to_images(surface, surface, registration)
    np.testing.assert_allclose(distances, surface.distances, atol=0.02 * surface.diameter)
    found = confidence_terms(surface, surface, registration, distances, PARAMETERS)
    for kind in ("distances", "residual", "strain"):
        assert getattr(found, kind).max() < 0.015, kind
    assert match_probabilities(surface, surface, registration, distances, PARAMETERS).min() > 0.98


def test_a_wrong_match_and_its_neighbours_are_the_least_probable(copy):
    surface, registration = copy
    sample = 20
    here = int(np.searchsorted(surface.proxy, surface.samples[sample]))
    image = registration.image.copy()
    image[here] = surface.samples[np.argmax(surface.distances[sample])]
    positions = registration.positions.copy()
    positions[here] = surface.mesh.vertices[image[here]]
    wrong = replace(registration, image=image, positions=positions)
    found = match_probabilities(surface, surface, wrong, distances_to_images(surface, surface, wrong), PARAMETERS)
    # The features of a vertex are means over its neighbourhood.
    assert (found < found[here]).mean() < 0.01
    assert surface.proxy_geodesics[here, np.argmin(found)] < 0.1
    assert np.median(found) > 0.95


def test_stability_is_zero_where_a_copy_can_slide_and_grows_with_the_cap_of_a_sphere():
    """A plane and a tube slide along themselves. On a cap of a sphere, from height h to 1, E[x^2] = E[1 - z^2] / 2."""
    radius = PARAMETERS.radius
    for shape in (grid(20, 16), tube(40, 60, length=12.0)):
        surface = mm.prepare(shape)
        middle = np.linalg.norm(surface.mesh.vertices - surface.mesh.vertices.mean(axis=0), axis=1)
        places = surface.mesh.vertices[np.argsort(middle)[:20]]
        np.testing.assert_allclose(stability(surface, places, radius), 0, atol=1e-3)
    sphere = mm.prepare(icosphere(4))
    height = 1 - (radius * np.sqrt(sphere.area)) ** 2 / 2  # of the rim of the points within this distance
    expected = (1 - (1 - height**3) / (1 - height) / 3) / 2
    np.testing.assert_allclose(stability(sphere, sphere.mesh.vertices[::100], radius), expected, rtol=0.25)
    everything = stability(sphere, sphere.mesh.vertices[:1], 9.0)
    np.testing.assert_allclose(everything, 1 / 3, rtol=0.01)


@pytest.mark.parametrize("size", [3, 200])
def test_values_are_interpolated_from_the_four_nearest_points(size):
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
def test_nine_of_ten_matches_with_a_confidence_of_09_are_right(shipped_match, name):
    result = shipped_match(name)
    vertices, points = result.target.mesh.vertices, result.target_points
    found = np.einsum("qk,qkd->qd", points.barycentric, vertices[points.corners])
    truth = true_places(name)[result.pairs[:, 0]]
    right = np.linalg.norm(found - truth, axis=1) < 0.05 * result.target_info["diameter"]
    confident = result.confidence >= 0.9
    assert confident.sum() >= 30
    assert right[confident].mean() >= 0.9


def test_confidence_tells_right_matches_of_a_half_wrong_alignment_from_the_others(shipped_match):
    """The person's first alternative: the trunk is right, and left limbs are matched with right ones."""
    result = shipped_match("person")
    wrong = result.alternatives[0]
    error = np.linalg.norm(
        result.target.mesh.vertices[wrong.pairs[:, 1]] - true_places("person")[wrong.pairs[:, 0]], axis=1
    )
    right = error < 0.05 * result.target_info["diameter"]
    assert 0.3 < right.mean() < 0.8
    first, *_, last = np.array_split(right, 5)  # the matches are sorted by confidence
    assert first.mean() > last.mean() + 0.4
    assert wrong.confidence.mean() < result.confidence.mean() - 0.03
