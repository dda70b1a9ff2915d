"""Registration: a copy stays where it is, noise and errors of the map are corrected, and motions commute with it."""

from dataclasses import replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.registration.features import appearance
from mobius_match.registration.parameters import FeatureWeights, RegistrationParameters
from mobius_match.registration.sparse import register
from mobius_match.registration.strain import mean_stretch
from tests.shapes import lump, rotation, true_places

PARAMETERS = RegistrationParameters()


@pytest.fixture(scope="module")
def surface(lump_surface):
    return lump_surface


def test_a_copy_stays_where_it_is(surface):
    vertices, faces = lump(4)
    moved = 5 * vertices @ rotation(1).T + 3
    found = register(surface, mm.prepare((moved, faces)), surface.proxy, PARAMETERS)
    np.testing.assert_array_equal(found.image, surface.proxy)
    np.testing.assert_allclose(found.positions, moved[surface.proxy], atol=1e-6)
    assert found.residual.max() < 1e-6
    assert found.normal_deviation.max() < 1e-6


def test_noise_of_the_map_is_removed(surface):
    """Each vertex sent to another one near by, a tenth of them to anywhere."""
    generator = np.random.default_rng(0)
    vertices = surface.mesh.vertices
    apart = np.linalg.norm(vertices[surface.proxy][:, None] - vertices, axis=2) / np.sqrt(surface.area)
    start = np.array([generator.choice(np.flatnonzero(row < 0.08)) for row in apart])
    far = generator.choice(len(start), len(start) // 10, replace=False)
    start[far] = generator.integers(len(vertices), size=len(far))
    found = register(surface, surface, start, PARAMETERS)

    def mean_error(image):
        return apart[np.arange(len(image)), image].mean()

    assert mean_error(found.image) < 0.2 * mean_error(start)
    assert np.mean(found.image == surface.proxy) > 0.6


def test_another_pose_is_matched_more_closely_than_by_the_initial_map(person):
    source, target = person
    places = true_places("person")[source.proxy]
    near = np.linalg.norm(target.mesh.vertices[target.proxy][:, None] - places, axis=2).argmin(axis=0)
    start = target.proxy[near]
    found = register(source, target, start, PARAMETERS)
    scale = np.sqrt(target.area)
    before = np.linalg.norm(target.mesh.vertices[start] - places, axis=1).mean() / scale
    assert np.linalg.norm(found.positions - places, axis=1).mean() / scale < 0.6 * before
    assert found.residual.mean() < 0.01
    assert found.normal_deviation.mean() < 0.1


def test_curvature_features_align_bumps_where_proportions_differ(surface):
    vertices, faces = lump(4)
    longer = mm.prepare((vertices * (1.0, 1.0, 1.5), faces))
    generator, places = np.random.default_rng(0), longer.mesh.vertices[surface.proxy]
    apart = np.linalg.norm(places[:, None] - longer.mesh.vertices, axis=2) / np.sqrt(longer.area)
    start = np.array([generator.choice(np.flatnonzero(row < 0.08)) for row in apart])
    with_them, without = (
        np.linalg.norm(register(surface, longer, start, PARAMETERS, weights=weights).positions - places, axis=1).mean()
        for weights in (PARAMETERS.features(False), replace(PARAMETERS.features(False), curvature=0.0))
    )
    assert with_them < 0.9 * without


def test_features_without_weight_have_no_column(surface):
    n, kinds = len(surface.mesh.vertices), surface.descriptors.shape[1]
    curvatures = surface.curvature_features.shape[1]
    for descriptor, curvature, columns in (
        (0.0, 0.0, 0),
        (0.5, 0.0, kinds),
        (0.0, 0.5, curvatures),
        (0.5, 2.0, kinds + curvatures),
    ):
        found = appearance(surface, FeatureWeights(1.0, 1.0, descriptor, curvature))
        assert found.shape == (n, columns)
    np.testing.assert_allclose(found[:, kinds:], 2.0 * surface.curvature_features, rtol=1e-6)


def test_a_piece_that_the_map_tears_off_is_moved_back(surface):
    """A cap sent to the opposite end comes back to where it belongs."""
    places = surface.mesh.vertices[surface.proxy]
    height = places @ np.array([0.0, 0.0, 1.0])
    start = surface.proxy.copy()
    cap = height > np.quantile(height, 0.9)
    start[cap] = surface.proxy[height.argmin()]
    found = register(surface, surface, start, PARAMETERS)
    assert cap.sum() > 50
    assert np.linalg.norm(surface.mesh.vertices[found.image] - places, axis=1).max() < 0.1 * np.sqrt(surface.area)


def test_stretching_is_the_mean_logarithm_of_the_edges_stretch(surface):
    found = register(surface, surface, surface.proxy, PARAMETERS)
    assert mean_stretch(surface, surface, found) == pytest.approx(0.0, abs=1e-3)
    bent = replace(found, positions=found.positions * np.e)
    assert mean_stretch(surface, surface, bent) == pytest.approx(1.0, abs=0.01)
