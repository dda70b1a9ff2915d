"""The unit disc on surfaces whose conformal map to it is known."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.geometry.laplacian import intrinsic_mesh
from mobius_match.surface.disc import boundary_corners, disc_positions, mid_edges_in_disc
from mobius_match.surface.flattening import choose_cut_face, flatten
from mobius_match.surface.surface import Surface
from tests.shapes import bent, disc, grid, icosphere


def places(arrays, centre=(0.0, 0.0, 0.0)):
    """All vertices in the unit disc, infinity near a point in space."""
    mesh = intrinsic_mesh(*arrays)
    cut = choose_cut_face(mesh, np.linalg.norm(arrays[0] - centre, axis=1))
    return disc_positions(flatten(mesh, cut), mesh, np.arange(len(arrays[0])))


def onto(first, second):
    """Points of the disc after the map of the disc to itself that brings them nearest to others (by their middles)."""
    p, q = first[np.abs(first).argmin()], second[np.abs(first).argmin()]
    first, second = ((z - at) / (1 - np.conj(at) * z) for z, at in ((first, p), (second, q)))
    turn = (np.conj(first) * second).sum()
    return first * turn / abs(turn), second


def spacing(arrays):
    """Mean length of the edges of a flat disc of area pi, about."""
    return np.sqrt(np.pi / len(arrays[0]))


@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.0), (0.3, -0.4, 0.0)])
@pytest.mark.parametrize("hole", [0.0, 0.3])
def test_a_flat_disc_is_its_own_map_up_to_one_of_the_group(centre, hole):
    """A round hole is closed by a flat cone, which changes nothing but for the size of the cone's faces."""
    arrays = disc(hole=hole)
    found, true = onto(places(arrays, centre), arrays[0][:, 0] + 1j * arrays[0][:, 1])
    assert np.abs(found - true).max() < 3 * spacing(arrays)
    assert np.abs(found - true).mean() < (0.8 if hole else 0.4) * spacing(arrays)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_hemisphere_goes_to_the_disc_as_by_stereographic_projection(mirrored):
    vertices, faces = disc(2000)
    square = (vertices**2).sum(axis=1)
    cap = np.column_stack([2 * vertices[:, :2], 1 - square]) / (1 + square[:, None])
    found, true = onto(
        places((cap, faces[:, ::-1] if mirrored else faces), (0, 0, 1)),
        vertices[:, 0] + (-1j if mirrored else 1j) * vertices[:, 1],
    )
    assert np.abs(found - true).mean() < 0.4 * spacing((vertices, faces))


@pytest.mark.parametrize("hole", [0.2, 0.5])
def test_an_annulus_keeps_its_modulus(hole):
    """The modulus of a disc without a disc of hyperbolic diameter d is -log(tanh(d / 4)) / 2 pi."""
    arrays = disc(2000, hole)
    z = places(arrays, (0.7, 0.0, 0.0))
    inner = z[np.isclose(np.linalg.norm(arrays[0], axis=1), hole)][:, None]
    diameter = 2 * np.arctanh(np.abs((inner - inner.T) / (1 - np.conj(inner.T) * inner))).max()
    assert np.tanh(diameter / 4) == pytest.approx(hole, rel=0.05)


def test_mid_edges_of_the_rim_lie_on_the_circle_in_order():
    vertices, faces = bent(grid(holes=((3, 3), (3, 4))))
    mesh = intrinsic_mesh(vertices, faces)
    cut = choose_cut_face(mesh, np.linalg.norm(vertices - vertices.mean(axis=0), axis=1))
    corners, loops = boundary_corners(mesh)
    rim = corners[loops == 0]
    assert (len(rim), loops.max()) == (2 * (12 + 9), 1)
    z = mid_edges_in_disc(flatten(mesh, cut), mesh, rim)
    on_rim = z[mesh.face_edges.ravel()[rim]]
    np.testing.assert_allclose(np.abs(on_rim), 1, atol=1e-9)
    assert np.nanmax(np.abs(z)) <= 1 + 1e-9
    # Once around the circle along the boundary, in one direction.
    tails, heads = mesh.faces[rim // 3, rim % 3 - 2], mesh.faces[rim // 3, rim % 3 - 1]
    after, at, turn = dict(zip(tails.tolist(), range(len(rim)), strict=True)), 0, 0.0
    for _ in range(len(rim)):
        following = after[int(heads[at])]
        step = np.angle(on_rim[following] / on_rim[at])
        assert step > 0
        turn, at = turn + step, following
    assert turn == pytest.approx(2 * np.pi)


def test_a_missing_face_is_closed_as_well():
    """A loop of three edges: hardly anything moves."""
    vertices, faces = disc()
    middle = np.linalg.norm(vertices[faces].mean(axis=1) - (0.5, 0.2, 0), axis=1).argmin()
    whole, open_ = places((vertices, faces)), places((vertices, np.delete(faces, middle, axis=0)))
    found, true = onto(open_, whole)
    assert np.abs(found - true).max() < 0.2 * spacing((vertices, faces))


def test_prepared_surfaces_have_the_disc_if_they_are_open(tmp_path):
    closed, opened = mm.prepare(icosphere(2)), mm.prepare(bent(grid()))
    assert (len(closed.disc), closed.rim_length) == (0, 0.0)
    assert len(opened.disc) == len(opened.proxy)
    assert np.abs(opened.disc).max() <= 1 + 1e-9
    flat = mm.prepare(disc(800))
    assert flat.rim_length == pytest.approx(2 * np.sqrt(np.pi), rel=0.01)
    flat.save(tmp_path / "disc.npz")
    np.testing.assert_array_equal(Surface.load(tmp_path / "disc.npz").disc, flat.disc)


def test_a_missing_triangle_is_closed_by_the_triangle():
    """An equilateral hole of three edges, whose cone with round spokes would be no triangles."""
    arrays = bent(grid(16, 13))
    hole = int(np.argmin(np.linalg.norm(arrays[0][arrays[1]].mean(axis=1) - arrays[0].mean(axis=0), axis=1)))
    found, whole = onto(places((arrays[0], np.delete(arrays[1], hole, axis=0))), places(arrays))
    assert np.abs(found - whole).max() < 0.02
