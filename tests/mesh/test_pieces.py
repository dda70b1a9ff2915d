"""Pieces of a mesh: the main one, the others beside it, and cavities."""

import numpy as np
import pytest

from mobius_match.mesh import Mesh, describe, repair
from mobius_match.mesh.pieces import all_pieces, joined, main_piece, pieces_of, unreached_vertices


def scene(shapes):
    """A sphere of 162 vertices between a small one before it and a smaller one inside it, which faces inwards."""
    vertices, faces = shapes.sphere()
    return shapes.union((vertices * 0.2 + 3, faces), (vertices, faces), (vertices * 0.5, faces[:, ::-1]))


def test_the_largest_is_the_main_one_and_keeps_the_numbers(shapes):
    vertices, faces = scene(shapes)
    main = main_piece(repair(Mesh(vertices, faces)))
    np.testing.assert_array_equal(main.vertex_ids, 162 + np.arange(162))
    np.testing.assert_array_equal(main.face_ids, 320 + np.arange(320))
    np.testing.assert_array_equal(main.others.vertex_ids, np.delete(np.arange(486), main.vertex_ids))
    assert main.notes == (
        "3 pieces: the largest (162 vertices, 78 % of the area) is the main one, with 2 others beside it (324 "
        "vertices; 1 cavity inside others).",
    )
    whole = all_pieces(main)
    np.testing.assert_array_equal(whole.vertices, vertices)
    np.testing.assert_array_equal(whole.faces, faces)


def test_joined_says_where_the_pieces_are(shapes):
    main = main_piece(repair(Mesh(*scene(shapes))))
    whole, here, beside = joined(main)
    for part, (vertices, faces) in ((main, here), (main.others, beside)):
        np.testing.assert_array_equal(whole.vertices[vertices], part.vertices)
        np.testing.assert_array_equal(whole.faces[faces], vertices[part.faces])


def test_one_piece_stays_as_it_is(shapes):
    mesh = repair(Mesh(*shapes.sphere()))
    assert main_piece(mesh) is mesh and all_pieces(mesh) is mesh and mesh.others is None


def test_a_large_plate_of_two_triangles_is_not_the_main_one(shapes):
    vertices, faces = shapes.sphere()
    plate = np.array([[-50, -50, -1], [50, -50, -1], [50, 50, -1], [-50, 50, -1.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    main = main_piece(repair(Mesh(*shapes.union(plate, (vertices, faces)))))
    assert len(main.faces) == 320 and len(main.others.faces) == 2


@pytest.mark.parametrize("outside_in", [False, True])
def test_a_cavity_faces_inwards_whichever_way_the_file_does(shapes, outside_in):
    vertices, faces = scene(shapes)
    mesh = repair(Mesh(vertices, faces[:, ::-1] if outside_in else faces))
    assert pieces_of(mesh).cavities.tolist() == [False, False, True]
    assert bool(mesh.notes) == outside_in
    volumes = np.bincount(pieces_of(mesh).faces, np.linalg.det(mesh.vertices[mesh.faces]))
    assert np.sign(volumes).tolist() == [1, 1, -1]


def test_a_solid_inside_another_is_no_cavity(shapes):
    """An eye in a head, and an island in a cavity."""
    vertices, faces = shapes.sphere()
    mesh = repair(Mesh(*shapes.union((vertices, faces), (0.5 * vertices, faces[:, ::-1]), (0.2 * vertices, faces))))
    assert pieces_of(mesh).cavities.tolist() == [False, True, False]
    assert not pieces_of(repair(Mesh(*shapes.union((vertices, faces), (0.5 * vertices, faces))))).cavities.any()


def test_a_large_cavity_is_not_the_main_piece(shapes):
    """A cavity with folds may have more area than what it lies in."""
    vertices, faces = shapes.sphere()
    crumpled = vertices * np.where(np.arange(162) % 2, 0.9, 0.3)[:, None]
    mesh = repair(Mesh(*shapes.union((crumpled, faces[:, ::-1]), (vertices, faces))))
    pieces = pieces_of(mesh)
    assert pieces.areas[0] > pieces.areas[1] and pieces.cavities.tolist() == [True, False]
    assert main_piece(mesh).vertex_ids[0] == 162


def test_info_lists_pieces_and_vertices_on_no_face(shapes):
    vertices, faces = scene(shapes)
    info = describe(Mesh(np.concatenate([vertices, [[9.0, 9, 9]]]), faces))
    assert [(one["vertices"], one["first_vertex"], one["cavity"]) for one in info["pieces"]] == [
        (162, 162, False),
        (162, 324, True),
        (162, 0, False),
    ]
    assert info["genus"] == 0 and info["closed"] and info["usable"] and info["unreached_vertices"] == [486]
    assert unreached_vertices(main_piece(repair(Mesh(vertices, faces)))).tolist() == []
