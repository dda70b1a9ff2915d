"""The bent source: a copy stays where it is, blur and errors are mended, and a joint is bent."""

from dataclasses import replace

import numpy as np
import pytest
from mobius_match.registration.register import ALIKE, SKETCHED, _appearance, register, stretching

import mobius_match as mm
from mobius_match.evaluation import examples
from tests.shapes import lump, rotation


@pytest.fixture(scope="module")
def surface():
    return mm.prepare(lump(4))


def test_a_copy_stays_where_it_is(surface):
    vertices, faces = lump(4)
    moved = 5 * vertices @ rotation(1).T + 3
    found = register(surface, mm.prepare((moved, faces)), surface.proxy)
    np.testing.assert_array_equal(found.image, surface.proxy)
    np.testing.assert_allclose(found.positions, moved[surface.proxy], atol=1e-6)
    assert found.residual.max() < 1e-6
    assert found.normal_deviation.max() < 1e-6


def test_blur_is_mended(surface):
    """Each vertex sent to another one near by, a tenth of them to anywhere."""
    generator = np.random.default_rng(0)
    vertices = surface.mesh.vertices
    apart = np.linalg.norm(vertices[surface.proxy][:, None] - vertices, axis=2) / np.sqrt(surface.area)
    start = np.array([generator.choice(np.flatnonzero(row < 0.08)) for row in apart])
    far = generator.choice(len(start), len(start) // 10, replace=False)
    start[far] = generator.integers(len(vertices), size=len(far))
    found = register(surface, surface, start)

    def mean_error(image):
        return apart[np.arange(len(image)), image].mean()

    assert mean_error(found.image) < 0.2 * mean_error(start)
    assert np.mean(found.image == surface.proxy) > 0.6


def test_another_pose_is_met_more_closely_than_by_the_map_it_began_with():
    source, target = (mm.prepare(path) for path in examples.paths("person"))
    faces, barycentric = examples.truth("person")
    places = np.einsum("ijk,ij->ik", target.mesh.vertices[target.mesh.faces[faces]], barycentric)[source.proxy]
    near = np.linalg.norm(target.mesh.vertices[target.proxy][:, None] - places, axis=2).argmin(axis=0)
    start = target.proxy[near]
    found = register(source, target, start)
    scale = np.sqrt(target.area)
    before = np.linalg.norm(target.mesh.vertices[start] - places, axis=1).mean() / scale
    assert np.linalg.norm(found.positions - places, axis=1).mean() / scale < 0.6 * before
    assert found.residual.mean() < 0.01
    assert found.normal_deviation.mean() < 0.1


def test_curvatures_keep_bumps_together_where_proportions_differ(surface):
    vertices, faces = lump(4)
    longer = mm.prepare((vertices * (1.0, 1.0, 1.5), faces))
    generator, places = np.random.default_rng(0), longer.mesh.vertices[surface.proxy]
    apart = np.linalg.norm(places[:, None] - longer.mesh.vertices, axis=2) / np.sqrt(longer.area)
    start = np.array([generator.choice(np.flatnonzero(row < 0.08)) for row in apart])
    with_them, without = (
        np.linalg.norm(register(surface, longer, start, feature_weights=seen).positions - places, axis=1).mean()
        for seen in (ALIKE, SKETCHED)
    )
    assert with_them < 0.9 * without


def test_of_what_has_no_weight_there_is_no_column(surface):
    n, kinds = len(surface.mesh.vertices), surface.descriptors.shape[1]
    relief = surface.curvature_features.shape[1]
    for weights, columns in (((0.0, 0.0), 0), ((0.5, 0.0), kinds), ((0.0, 0.5), relief), ((0.5, 2.0), kinds + relief)):
        assert _appearance(surface, weights).shape == (n, columns)
    np.testing.assert_allclose(_appearance(surface, (0.5, 2.0))[:, kinds:], 2.0 * surface.curvature_features, rtol=1e-6)


def test_a_piece_that_the_map_tears_off_follows_the_body(surface):
    """A cap sent to the opposite end comes back to where it belongs."""
    places = surface.mesh.vertices[surface.proxy]
    height = places @ np.array([0.0, 0.0, 1.0])
    start = surface.proxy.copy()
    cap = height > np.quantile(height, 0.9)
    start[cap] = surface.proxy[height.argmin()]
    found = register(surface, surface, start)
    assert cap.sum() > 50
    assert np.linalg.norm(surface.mesh.vertices[found.image] - places, axis=1).max() < 0.1 * np.sqrt(surface.area)


def test_stretching_is_that_of_the_edges(surface):
    found = register(surface, surface, surface.proxy)
    assert stretching(surface, surface, found) == pytest.approx(0.0, abs=1e-3)
    bent = replace(found, positions=found.positions * np.e)
    assert stretching(surface, surface, bent) == pytest.approx(1.0, abs=0.01)
