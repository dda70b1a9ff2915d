"""Repair keeps what is good, says what it did, and counts it right."""

from itertools import combinations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from mobius_match.mesh import Mesh, describe, repair, require_matchable
from mobius_match.mesh import topology as tp
from mobius_match.mesh.measure import areas, cross_products
from mobius_match.mesh.pieces import main_piece
from mobius_match.mesh.slivers import is_flat


def volume(mesh):
    return (
        np.einsum(
            "ij,ij->i",
            mesh.vertices[mesh.faces[:, 0]],
            np.cross(mesh.vertices[mesh.faces[:, 1]], mesh.vertices[mesh.faces[:, 2]]),
        ).sum()
        / 6
    )


def rows(faces):
    """Faces as a sorted list, each beginning with its lowest vertex: equal for equal oriented surfaces."""
    return sorted(tuple(np.roll(face, -int(np.argmin(face))).tolist()) for face in faces)


@pytest.mark.parametrize("name", ["sphere", "disc", "cylinder", "holed_sphere"])
def test_a_good_mesh_is_left_alone_and_accepted(shapes, name):
    mesh = Mesh(*getattr(shapes, name)())
    fixed = repair(mesh)
    used = np.unique(mesh.faces)
    np.testing.assert_array_equal(fixed.vertices, mesh.vertices[used])
    np.testing.assert_array_equal(used[fixed.faces], mesh.faces)
    assert fixed.sha256 == mesh.sha256
    assert len(fixed.notes) == (len(used) < len(mesh.vertices))
    require_matchable(fixed)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_random_flips_of_a_closed_sphere_all_come_back_outward(seed, share):
    ball = trimesh.creation.icosphere(1)
    faces = np.array(ball.faces)
    turned = np.random.default_rng(seed).random(len(faces)) < share
    faces[turned] = faces[turned, ::-1]
    fixed = repair(Mesh(ball.vertices, faces))
    assert rows(fixed.faces) == rows(ball.faces)
    count = turned.sum()
    if count == 0:
        assert fixed.notes == ()
    elif count == len(faces):
        assert fixed.notes == ("closed surface turned outwards (80 faces reversed).",)
    else:
        noun = "face" if count == 1 else "faces"
        assert fixed.notes == (f"{count} {noun} reversed to agree with their neighbours.",)


def test_an_open_surface_follows_its_majority(shapes):
    vertices, faces = shapes.disc()
    wrong = faces.copy()
    wrong[[3, 17, 40]] = wrong[[3, 17, 40], ::-1]
    for damagedfaces, expected in ((wrong, faces), (wrong[:, ::-1], faces[:, ::-1])):
        fixed = repair(Mesh(vertices, damagedfaces))
        assert rows(fixed.faces) == rows(expected)
        assert fixed.notes == ("3 faces reversed to agree with their neighbours.",)


def test_drops_double_and_repeated_faces_and_unused_vertices(shapes):
    vertices, faces = shapes.sphere()
    vertices = np.concatenate([[[9.0, 9, 9]], vertices, [[8.0, 8, 8]]])
    faces = faces + 1
    extra = np.concatenate([[[5, 5, 9]], faces, faces[10:13, [1, 2, 0]], faces[20:21, ::-1]])
    fixed = repair(Mesh(vertices, extra))
    np.testing.assert_array_equal(fixed.vertex_ids, np.arange(1, len(vertices) - 1))
    np.testing.assert_array_equal(fixed.face_ids, np.arange(1, len(faces) + 1))
    assert rows(fixed.vertex_ids[fixed.faces]) == rows(faces)
    assert fixed.notes == (
        "1 face that names a vertex twice dropped.",
        "4 duplicate faces dropped.",
        "2 unused vertices dropped.",
    )
    assert fixed.n_file_vertices == len(vertices)


def test_joins_seams_to_the_lowest_number(shapes):
    """A sphere cut along its equator into two halves with vertices of their own, as at texture seams."""
    vertices, faces = shapes.sphere()
    upper = vertices[faces].mean(axis=1)[:, 2] > 0.01
    seam = np.intersect1d(faces[upper], faces[~upper])
    number = np.arange(len(vertices))
    number[seam] = len(vertices) + np.arange(len(seam))
    split = np.where(upper[:, None], number[faces], faces)
    fixed = repair(Mesh(np.concatenate([vertices, vertices[seam]]), split))
    assert fixed.notes == (f"{len(seam)} vertices merged with another of the same coordinates, along seams.",)
    np.testing.assert_array_equal(fixed.vertex_ids, np.arange(len(vertices)))
    assert rows(fixed.faces) == rows(faces)
    require_matchable(fixed)


def test_joins_a_soup_of_triangles(shapes):
    vertices, faces = shapes.sphere()
    soup = Mesh(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    fixed = repair(soup)
    assert len(fixed.vertices) == len(vertices) and tp.genus(fixed.faces) == 0
    np.testing.assert_array_equal(fixed.vertices[fixed.faces], soup.vertices[soup.faces])
    require_matchable(fixed)


def test_surfaces_that_only_touch_stay_apart():
    """Two boxes with an edge, or a corner, in the same place: two closed pieces, before and after."""
    for shift in ([1, 1, 0], [1, 1, 1]):
        box = trimesh.creation.box()
        vertices = np.concatenate([box.vertices, box.vertices + shift])
        faces = np.concatenate([box.faces, box.faces + 8])
        fixed = repair(Mesh(vertices, faces))
        assert fixed.notes == () and len(fixed.vertices) == 16
        soup = repair(Mesh(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)))
        assert len(soup.vertices) == 16 and tp.components(soup.faces)[0] == 2
        assert not len(tp.nonmanifold_edges(tp.edge_table(soup.faces)))


def test_a_double_sided_sheet_becomes_single(shapes):
    vertices, faces = shapes.disc()
    fixed = repair(Mesh(*shapes.union((vertices, faces), (vertices, faces[:, ::-1]))))
    assert rows(fixed.faces) == rows(faces)
    assert fixed.notes[0] == "72 faces dropped: their piece coincides with another piece of the surface."


def test_cuts_a_bowtie_apart_and_keeps_the_number(shapes):
    vertices, faces = shapes.bowtie()
    fixed = repair(Mesh(vertices, faces))
    assert "1 vertex added where parts of the surface only touch, to separate them." in fixed.notes
    assert (fixed.vertex_ids == 0).sum() == 2
    np.testing.assert_array_equal(fixed.vertex_ids[fixed.faces], faces)
    assert not len(tp.nonmanifold_vertices(fixed.faces))
    require_matchable(main_piece(fixed))


def test_keeps_all_pieces(shapes):
    vertices, faces = shapes.sphere()
    crumbs = [(vertices * 0.03 + 3 * k, faces) for k in (1, 2)]
    whole = shapes.union(crumbs[0], (vertices, faces), crumbs[1])
    fixed = repair(Mesh(*whole))
    assert fixed.notes == ()
    np.testing.assert_array_equal(fixed.vertices, whole[0])
    np.testing.assert_array_equal(fixed.faces, whole[1])


def test_a_point_doubled_along_an_edge_is_merged(shapes):
    """Vertex 50 split in two at one place, with two faces of no area between them."""
    vertices, faces = shapes.sphere()
    ring = np.flatnonzero((faces == 50).any(axis=1))
    # Walk around vertex 50 and hand a run of three faces over to the new vertex.
    order = {int(np.roll(f, -list(f).index(50))[1]): i for i, f in zip(ring, faces[ring], strict=True)}
    first = ring[0]
    second = order[int(np.roll(faces[first], -list(faces[first]).index(50))[2])]
    third = order[int(np.roll(faces[second], -list(faces[second]).index(50))[2])]
    new = len(vertices)
    a = int(np.roll(faces[first], -list(faces[first]).index(50))[1])
    b = int(np.roll(faces[third], -list(faces[third]).index(50))[2])
    split = faces.copy()
    for f in (first, second, third):
        split[f] = np.where(split[f] == 50, new, split[f])
    split = np.concatenate([split, [[50, a, new], [50, new, b]]])
    mesh = Mesh(np.concatenate([vertices, vertices[50:51]]), split)
    assert tp.genus(mesh.faces) == 0 and not tp.sides(mesh.faces, tp.edge_table(mesh.faces))[1].any()
    fixed = repair(mesh)
    assert fixed.notes == ("1 near-zero-length edge collapsed (2 faces removed).",)
    assert rows(fixed.faces) == rows(faces)


def test_a_cap_is_flipped_and_every_vertex_stays(shapes):
    """A new vertex on an edge, used by one of the two faces only: the other sees a flat triangle."""
    vertices, faces = shapes.sphere()
    a, b, p = faces[7]
    middle = len(vertices)
    vertices = np.concatenate([vertices, [(vertices[a] + vertices[b]) / 2]])
    cut = np.concatenate([np.delete(faces, 7, axis=0), [[a, middle, p], [middle, b, p], [a, b, middle]]])
    mesh = Mesh(vertices, cut)
    fixed = repair(mesh)
    assert fixed.notes == ("1 face without area removed (by edge flips, or at the boundary).",)
    assert len(fixed.vertices) == len(vertices) and len(fixed.faces) == len(cut)
    assert not is_flat(fixed.vertices, fixed.faces).any() and tp.genus(fixed.faces) == 0
    assert volume(fixed) == pytest.approx(volume(mesh), rel=1e-14)
    # Both new faces lie in the former neighbour across the edge a b.
    other = next(i for i, f in enumerate(np.delete(faces, 7, axis=0)) if {a, b} <= set(f.tolist()))
    assert (fixed.face_ids == other).sum() == 2 and len(mesh.faces) - 1 not in fixed.face_ids


def test_a_flat_ear_on_the_boundary_goes(shapes):
    vertices, faces = shapes.disc()
    a, b = 0, 7  # an edge of the boundary, in the direction of its face or against it
    vertices = np.concatenate([vertices, [2 * vertices[a] - vertices[b]]])
    fixed = repair(Mesh(vertices, np.concatenate([faces, [[a, b, len(vertices) - 1]]])))
    assert "1 face without area removed (by edge flips, or at the boundary)." in fixed.notes
    assert rows(fixed.faces) == rows(faces)


def test_all_area_and_genus_survive_many_caps():
    rng = np.random.default_rng(3)
    box = trimesh.creation.box().subdivide().subdivide().subdivide()
    # Grid points moved along their grid lines only: many corners come to lie on straight lines.
    vertices, faces = np.array(box.vertices), np.array(box.faces)
    edges = tp.edge_table(faces).edges
    picked = edges[rng.permutation(len(edges))[:25]]
    vertices[picked[:, 0]] = vertices[picked[:, 1]]
    damaged = Mesh(vertices, faces)
    fixed = repair(damaged)
    assert tp.genus(fixed.faces) == 0 and tp.components(fixed.faces)[0] == 1
    left = int(is_flat(fixed.vertices, fixed.faces).sum())
    assert left == 0
    assert not any("kept: removing them" in note for note in fixed.notes)
    before, after = (
        np.linalg.norm(cross_products(mesh.vertices, mesh.faces), axis=1).sum() for mesh in (damaged, fixed)
    )
    assert after == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-150, 1e-20, 1.0, 1e20, 1e150])
def test_units_do_not_matter(shapes, scale):
    vertices, faces = shapes.holed_sphere()
    plain, scaled = repair(Mesh(vertices, faces)), repair(Mesh(vertices * scale, faces))
    np.testing.assert_array_equal(plain.faces, scaled.faces)
    assert plain.notes == scaled.notes
    np.testing.assert_allclose(areas(scaled.vertices, scaled.faces), areas(plain.vertices, plain.faces), rtol=1e-9)
    require_matchable(scaled)


def test_repair_is_idempotent(shapes):
    rng = np.random.default_rng(0)
    vertices, faces = shapes.union(shapes.sphere(), shapes.bowtie())
    faces = faces[rng.permutation(len(faces))]
    faces[::3] = faces[::3, ::-1]
    once = repair(Mesh(vertices, faces))
    twice = repair(once)
    np.testing.assert_array_equal(once.faces, twice.faces)
    np.testing.assert_array_equal(once.vertices, twice.vertices)
    np.testing.assert_array_equal(once.vertex_ids, twice.vertex_ids)
    assert once.notes == twice.notes


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(3, 20))
def test_any_triangles_at_all(seed, m, n):
    """Random triangles, some coincident vertices: the result is manifold, oriented, compact."""
    rng = np.random.default_rng(seed)
    mesh = Mesh(rng.integers(0, 3, (n, 3)), rng.integers(0, n, (m, 3)))
    fixed = repair(mesh)
    assert (fixed.faces != fixed.faces[:, [1, 2, 0]]).all()
    np.testing.assert_array_equal(np.unique(fixed.faces), np.arange(len(fixed.vertices)))
    np.testing.assert_array_equal(fixed.vertices, mesh.vertices[fixed.vertex_ids])
    assert set(fixed.face_ids.tolist()) <= set(range(m))
    assert not len(tp.nonmanifold_vertices(fixed.faces)) and not len(tp.nonmanifold_edges(tp.edge_table(fixed.faces)))
    _, turned, twisted = tp.sides(fixed.faces, tp.edge_table(fixed.faces))
    assert not (turned & ~twisted).any()
    info, main = describe(mesh), main_piece(fixed)
    edges = {frozenset(pair) for face in main.faces.tolist() for pair in combinations(face, 2)}
    assert info["euler_characteristic"] == len(main.vertices) - len(edges) + len(main.faces)
    assert info["notes"] == list(main.notes)
    assert sum(piece["faces"] for piece in info["pieces"]) == len(fixed.faces)
    # Only an orientable surface of at least 12 vertices and 20 faces can be matched.
    assert not info["usable"] or (len(main.vertices) >= 12 and len(main.faces) >= 20 and info["genus"] is not None)
    assert info["usable"] == (info["reason"] is None)


@pytest.mark.parametrize("name", ["sphere", "disc", "cylinder", "holed_sphere", "torus", "moebius", "bowtie", "book"])
def test_these_are_accepted(shapes, name):
    mesh = Mesh(*getattr(shapes, name)())
    info = describe(mesh)
    assert info["usable"] and info["reason"] is None
    require_matchable(main_piece(repair(mesh)))
