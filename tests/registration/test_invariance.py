"""What motions and units do to a registration: it moves with them, and lengths of edges scale."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mobius_match as mm
from mobius_match.registration.parameters import RegistrationParameters
from mobius_match.registration.sparse import register
from mobius_match.registration.strain import edge_stretches
from tests.shapes import lump, rotation

PARAMETERS = RegistrationParameters()

motions = st.tuples(
    st.integers(0, 2**32 - 1), st.floats(0.01, 100), st.tuples(*[st.floats(-10, 10, allow_subnormal=False)] * 3)
)


def moved(points, motion):
    """Points (n, 3) rotated, scaled and shifted."""
    seed, scale, shift = motion
    return scale * (points @ rotation(seed).T + shift)


def moved_surface(surface, motion):
    scale = motion[1]
    return replace(
        surface,
        mesh=replace(surface.mesh, vertices=moved(surface.mesh.vertices, motion)),
        area=surface.area * scale**2,
        diameter=surface.diameter * scale,
        distances=surface.distances * scale,
        proxy_distances=surface.proxy_distances * scale,
    )


@pytest.fixture(scope="module")
def registered():
    """A surface, another of other proportions, an initial map with noise, and the registration."""
    vertices, faces = lump(3)
    source, target = mm.prepare((vertices, faces), samples=40), mm.prepare((vertices * [1, 1, 1.2], faces), samples=40)
    places = target.mesh.vertices[source.proxy]
    apart = np.linalg.norm(places[:, None] - target.mesh.vertices, axis=2) / np.sqrt(target.area)
    generator = np.random.default_rng(0)
    image = np.array([generator.choice(np.flatnonzero(row < 0.08)) for row in apart])
    return source, target, image, register(source, target, image, PARAMETERS)


@settings(max_examples=6)
@given(motion=motions)
def test_a_registration_does_not_depend_on_where_and_how_large_the_source_is(registered, motion):
    source, target, image, expected = registered
    found = register(moved_surface(source, motion), target, image, PARAMETERS)
    assert np.mean(found.image == expected.image) > 0.99
    np.testing.assert_allclose(found.positions, expected.positions, atol=1e-3 * np.sqrt(target.area))


@settings(max_examples=6)
@given(motion=motions)
def test_a_registration_moves_with_the_target(registered, motion):
    source, target, image, expected = registered
    there = moved_surface(target, motion)
    found = register(source, there, image, PARAMETERS)
    assert np.mean(found.image == expected.image) > 0.99
    np.testing.assert_allclose(found.positions, moved(expected.positions, motion), atol=1e-3 * np.sqrt(there.area))
    np.testing.assert_allclose(found.residual, expected.residual, atol=1e-3)


@given(factor=st.floats(0.1, 10))
def test_a_stretched_registration_has_longer_edges_by_that_factor(registered, factor):
    source, target, _, registration = registered
    larger = replace(registration, positions=factor * registration.positions)
    change = edge_stretches(source, target, larger) - edge_stretches(source, target, registration)
    np.testing.assert_allclose(change, np.log(factor), atol=1e-3)
