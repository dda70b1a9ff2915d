"""Loops around handles: as many as there are handles, short, separating nothing; and the surface cut along them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobius_match.mesh import Mesh, repair
from mobius_match.mesh import topology as tp
from mobius_match.mesh.handles import cut_along, handle_loops, loop_lengths, number_of_handles
from mobius_match.mesh.measure import areas
from tests.shapes import icosphere, lump, renumbered, torus, tube, with_handle


def far_apart(shape, number, seed=0):
    """Pairs of faces of a shape, none of which touch each other, (number, 2)."""
    faces = shape[1]
    chosen, used = [], set()
    for face in np.random.default_rng(seed).permutation(len(faces)).tolist():
        ring = set(faces[np.isin(faces, faces[face]).any(axis=1)].ravel().tolist())
        if not ring & used:
            chosen.append(face)
            used |= ring
        if len(chosen) == 2 * number:
            return np.array(chosen).reshape(-1, 2)
    raise AssertionError("no room")


def sphere_with_handles(number, seed=0, shape=None):
    shape = shape or icosphere(3)
    # Faces are named by their corners, for the numbers change with each handle.
    for one, two in shape[1][far_apart(shape, number, seed)]:
        place = [int(np.flatnonzero((shape[1] == face).all(axis=1))[0]) for face in (one, two)]
        shape = with_handle(shape, *place)
    return shape


def checked_cut(mesh, loops):
    """The mesh cut along loops, once all that must hold for it has been checked."""
    cut, origin = cut_along(mesh, loops)
    table = tp.edge_table(cut.faces)
    assert tp.genus(cut.faces, table) == 0
    assert tp.components(cut.faces, table)[0] == 1
    before = len(tp.boundary_loops(mesh.faces))
    assert len(tp.boundary_loops(cut.faces, table)) == before + 2 * len(loops)
    assert (np.diff(origin) >= 0).all()
    np.testing.assert_array_equal(origin[cut.faces], mesh.faces)
    np.testing.assert_array_equal(cut.vertices, mesh.vertices[origin])
    np.testing.assert_array_equal(cut.vertex_ids, mesh.vertex_ids[origin])
    times = np.ones(len(mesh.vertices), int)
    times[np.concatenate(loops)] = 2
    np.testing.assert_array_equal(np.bincount(origin), times)
    return cut


@pytest.mark.parametrize(
    "shape",
    [icosphere(2), lump(3), tube(), (lambda v, f: (v, f[4:]))(*icosphere(2))],
    ids=["sphere", "lump", "tube", "hole"],
)
def test_no_handle_no_loop(shape):
    assert handle_loops(Mesh(*shape)) == []


@pytest.mark.parametrize("seed", [None, 0])
def test_the_loop_of_a_torus_is_its_thin_circle(seed):
    """A polygon of 16 edges in a circle of radius 1, which is shorter than every loop the other way around."""
    shape = torus() if seed is None else renumbered(torus(), seed)[0]
    mesh = Mesh(*shape)
    (loop,) = handle_loops(mesh)
    assert loop_lengths(mesh.vertices, [loop]) == pytest.approx(32 * np.sin(np.pi / 16))
    assert len(checked_cut(mesh, [loop]).vertices) == len(mesh.vertices) + 16


def test_the_loop_of_a_fat_torus_is_its_hole():
    """Radius 2 - 1.8 against 1.8."""
    mesh = Mesh(*torus(2.0, 1.8, around=24, across=40))
    (loop,) = handle_loops(mesh)
    # Edges are no straight lines across the surface, so only an upper bound is known: the innermost circle.
    assert loop_lengths(mesh.vertices, [loop]) <= 48 * 0.2 * np.sin(np.pi / 24) * (1 + 1e-9)
    assert len(set(loop // 40)) == 24
    checked_cut(mesh, [loop])


@pytest.mark.parametrize("number", [1, 2, 5])
def test_a_loop_for_each_handle_of_a_sphere(number):
    """Each handle is a tube of three sides, whose narrowest ring no other loop can beat."""
    mesh = Mesh(*sphere_with_handles(number))
    assert number_of_handles(mesh.faces) == number
    loops = handle_loops(mesh)
    assert len(loops) == number == len({frozenset(loop // 3) for loop in loops})
    checked_cut(mesh, loops)
    tubes = np.arange(len(icosphere(3)[0]), len(mesh.vertices)).reshape(-1, 3)
    narrow = sorted(loop_lengths(mesh.vertices, list(tubes)).reshape(number, 3).min(axis=1))
    assert sorted(loop_lengths(mesh.vertices, loops)) <= [length * (1 + 1e-9) for length in narrow]


def test_a_double_torus():
    """Two tori joined by a tube: the thin circles of both, whatever the order of the vertices."""
    vertices, faces = torus()
    n, m = len(vertices), len(faces)
    both = np.concatenate([vertices, vertices + np.array([9, 0, 0])]), np.concatenate([faces, faces + n])
    outer, inner = (
        int(np.argmax((v[faces].mean(axis=1) * [sign, 0, 0]).sum(axis=1)))
        for v, sign in ((vertices, 1), (vertices, -1))
    )
    for shape in (joined := with_handle(both, outer, m + inner), renumbered(joined)[0]):
        mesh = Mesh(*shape)
        loops = handle_loops(mesh)
        np.testing.assert_allclose(loop_lengths(mesh.vertices, loops), 32 * np.sin(np.pi / 16))
        middle = [mesh.vertices[loop, 0].mean() for loop in loops]
        assert min(middle) < 4.5 < max(middle)
        checked_cut(mesh, loops)


@given(seed=st.integers(0, 1000), number=st.integers(1, 4), holes=st.integers(0, 4))
def test_spheres_with_handles_and_holes(seed, number, holes):
    """Coarse ones, so that loops have to pass by holes closely."""
    vertices, faces = sphere_with_handles(number, seed, icosphere(2))
    drop = np.random.default_rng(seed).choice(320 - 2 * number, holes, replace=False)
    mesh = repair(Mesh(vertices, np.delete(faces, drop, axis=0)))
    assert number_of_handles(mesh.faces) == number
    loops = handle_loops(mesh)
    cut, _ = cut_along(mesh, loops)
    assert tp.genus(cut.faces) == 0 and tp.components(cut.faces)[0] == 1
    np.testing.assert_allclose(areas(cut.vertices, cut.faces).sum(), areas(mesh.vertices, mesh.faces).sum())


@pytest.mark.parametrize("across", [3, 4])
def test_a_strip_of_handles_with_boundary_on_both_sides(across):
    """A torus with a slit around it, so that every loop through the hole must cross or touch the boundary."""
    vertices, faces = torus(around=12, across=across)
    mesh = repair(Mesh(vertices, np.delete(faces, [0, 5, 9], axis=0)))
    (loop,) = handle_loops(mesh)
    cut, _ = cut_along(mesh, [loop])
    assert tp.genus(cut.faces) == 0 and tp.components(cut.faces)[0] == 1


def test_the_smallest_torus_has_a_loop():
    """The torus of seven vertices: every two of them are joined, and loops have three edges."""
    faces = np.array([[(i + a) % 7, (i + b) % 7, (i + c) % 7] for i in range(7) for a, b, c in ((0, 1, 3), (0, 3, 2))])
    mesh = Mesh(np.random.default_rng(0).normal(size=(7, 3)), faces)
    assert number_of_handles(faces) == 1
    (loop,) = handle_loops(mesh)
    cut, _ = cut_along(mesh, [loop])
    assert len(loop) == 3 and tp.genus(cut.faces) == 0 and tp.components(cut.faces)[0] == 1


def test_repair_does_not_sew_up_a_cut():
    """Its two sides lie on each other, like those of a seam, but share the user's numbers."""
    mesh = Mesh(*torus())
    cut, _ = cut_along(mesh, handle_loops(mesh))
    again = repair(cut)
    np.testing.assert_array_equal(again.faces, cut.faces)
    assert number_of_handles(again.faces) == 0
