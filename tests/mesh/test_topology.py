"""Counts that theory fixes: Euler characteristic, genus, boundary, sides."""

import numpy as np
import pytest

from mobius_match.errors import TopologyError
from mobius_match.mesh import topology as tp
from tests.shapes import icosphere

# name: (components, Euler characteristic, genus, boundary lengths, orientable)
KNOWN = {
    "sphere": (1, 2, 0, [], True),
    "torus": (1, 0, 1, [], True),
    "disc": (1, 1, 0, [24], True),
    "cylinder": (1, 0, 0, [10, 10], True),
    "holed_sphere": (1, 0, 0, [5, 5], True),
    "moebius": (1, 0, None, [40], False),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_shapes(shapes, name):
    pieces, euler, genus, lengths, orientable = KNOWN[name]
    _, faces = getattr(shapes, name)()
    table = tp.edge_table(faces)
    assert tp.components(faces)[0] == pieces
    assert tp.euler_characteristic(faces) == euler
    assert tp.genus(faces) == genus
    assert tp.boundary_lengths(table).tolist() == lengths
    assert tp.sides(faces, table)[2].any() == (not orientable)
    assert not len(tp.nonmanifold_edges(table)) and not len(tp.nonmanifold_vertices(faces))


def test_edge_table_against_a_dictionary(shapes):
    _, faces = shapes.book(3)
    known = {}
    for f, face in enumerate(faces.tolist()):
        for k in range(3):
            known.setdefault(tuple(sorted((face[(k + 1) % 3], face[(k + 2) % 3]))), []).append((f, k))
    table = tp.edge_table(faces)
    assert [tuple(edge) for edge in table.edges.tolist()] == sorted(known)
    for e, (edge, corners) in enumerate(sorted(known.items())):
        assert table.counts[e] == len(corners), edge
        assert table.edge_faces[e].tolist() == ([f for f, _ in corners] + [-1])[:2]
        assert all(table.face_edges[f, k] == e for f, k in corners)


def test_book_and_bowtie(shapes):
    _, faces = shapes.book(3)
    table = tp.edge_table(faces)
    assert len(tp.nonmanifold_edges(table)) == 6 and (table.counts[tp.nonmanifold_edges(table)] == 3).all()
    assert tp.genus(faces) is None and tp.components(faces)[0] == 1
    _, faces = shapes.bowtie()
    assert tp.nonmanifold_vertices(faces).tolist() == [0]
    assert tp.components(faces)[0] == 2 and tp.genus(faces) is None


def test_genus_adds_up(shapes):
    _, faces = shapes.union(shapes.torus(), shapes.sphere(), shapes.torus(9.0), shapes.cylinder())
    assert tp.components(faces)[0] == 4 and tp.genus(faces) == 2
    assert np.bincount(tp.components(faces)[1]).tolist() == [160, 320, 160, 80]


def test_boundary_loops_follow_the_faces(shapes):
    vertices, faces = shapes.disc()
    (loop,) = tp.boundary_loops(faces)
    x, y = vertices[loop, :2].T
    # The disc's faces run counter-clockwise in the plane, so its boundary does too: area + 1 (shoelace).
    assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2 == pytest.approx(1.0)
    both = tp.boundary_loops(shapes.cylinder()[1])
    assert [len(loop) for loop in both] == [10, 10] and not np.intersect1d(*both).size
    assert tp.boundary_loops(shapes.sphere()[1]) == []


def test_boundary_loops_need_orientation(shapes):
    _, faces = shapes.disc()
    faces[0] = faces[0, ::-1]
    with pytest.raises(TopologyError, match="not consistently oriented"):
        tp.boundary_loops(faces)


@pytest.mark.parametrize("seed", range(5))
def test_sides_find_the_turned_faces(shapes, seed):
    _, faces = shapes.torus()
    turned = np.random.default_rng(seed).random(len(faces)) < 0.5
    faces[turned] = faces[turned, ::-1]
    _, found, twisted = tp.sides(faces, tp.edge_table(faces))
    np.testing.assert_array_equal(found, turned ^ turned[0])
    assert not twisted.any()


def test_nothing_is_no_trouble():
    none = np.zeros((0, 3), dtype=np.int64)
    table = tp.edge_table(none)
    assert table.edges.shape == (0, 2) and tp.components(none)[0] == 0 and tp.genus(none) is None
    assert tp.boundary_loops(none) == [] and tp.euler_characteristic(none) == 0


@pytest.mark.parametrize("kind", ["closed", "torn", "turned", "random"])
def test_large_meshes_get_the_same_from_kernels(kind, monkeypatch):
    generator = np.random.default_rng(0)
    faces = icosphere(3)[1]
    if kind == "torn":
        faces = faces[generator.random(len(faces)) < 0.6]
    elif kind == "turned":
        faces = np.where(generator.random((len(faces), 1)) < 0.3, faces[:, [0, 2, 1]], faces)
    elif kind == "random":
        faces = np.array([generator.choice(60, 3, replace=False) for _ in range(200)])
    table = tp.edge_table(faces)
    extra = tuple(generator.integers(0, faces.size, (2, 20)))
    found = []
    for large in (10**9, 0):
        monkeypatch.setattr(tp, "LARGE", large)
        found.append([tp.components(faces, table), tp.fans(faces, table), tp.fans(faces, table, extra)])
    for (number, labels), (same_number, same_labels) in zip(*found, strict=True):
        assert number == same_number
        np.testing.assert_array_equal(labels, same_labels)


def test_edges_of_very_large_numbers():
    faces = icosphere(1)[1]
    plain, far = tp.edge_table(faces), tp.edge_table(faces + 2**31 - 50)
    assert np.array_equal(far.edges - (2**31 - 50), plain.edges) and np.array_equal(far.order, plain.order)
    assert np.array_equal(tp.boundary_edges(faces[1:]), tp.edges_of(faces[:1]))
