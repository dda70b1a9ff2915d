"""Simplification: fewer vertices, the same surface."""

import numpy as np
import pytest

from mobius_match.mesh import topology as tp
from mobius_match.mesh.measure import cross_products
from mobius_match.mesh.simplify import simplify
from tests.shapes import bent, grid, icosphere, lump, renumbered, tube

HOLE = tuple((x, 20) for x in range(20, 32)) + tuple((20, y) for y in range(21, 30))
SHEET = bent(grid(60, 50, holes=HOLE))
SHAPES = {"lump": lump(5), "sheet": SHEET, "tube": tube(60, 60), "renumbered": renumbered(lump(4))[0]}


@pytest.mark.parametrize("name", SHAPES)
def test_fewer_vertices_of_the_same_surface(name):
    vertices, faces = SHAPES[name]
    count = len(vertices) // 6
    kept, simple, home = simplify(vertices, faces, count)
    assert len(kept) == count
    assert (np.diff(kept) > 0).all()
    np.testing.assert_array_equal(tp.used_vertices(simple), np.arange(count))
    np.testing.assert_array_equal(home[kept], np.arange(count))
    # As good a manifold as before, with as many holes.
    assert tp.genus(simple) == tp.genus(faces) == 0
    assert len(tp.boundary_loops(simple)) == len(tp.boundary_loops(faces))
    assert tp.components(simple)[0] == 1
    assert not tp.sides(simple, tp.edge_table(simple))[1].any()
    # As large, and next to the old one everywhere.
    old, new = (
        np.linalg.norm(cross_products(*mesh), axis=1).sum() for mesh in ((vertices, faces), (vertices[kept], simple))
    )
    assert new == pytest.approx(old, rel=0.03)
    edge = np.sqrt(np.linalg.norm(cross_products(vertices[kept], simple), axis=1).mean())
    assert np.linalg.norm(vertices - vertices[kept][home], axis=1).max() < 3 * edge


def test_faces_keep_their_side():
    vertices, faces = icosphere(5)
    kept, simple, _ = simplify(vertices, faces, 500)
    outwards = np.einsum("md,md->m", cross_products(vertices[kept], simple), vertices[kept][simple].mean(axis=1))
    assert outwards.min() > 0
    sides = vertices[kept][simple] - np.roll(vertices[kept][simple], 1, axis=1)
    lengths = np.linalg.norm(sides, axis=2)
    assert (lengths.max(axis=1) / lengths.min(axis=1)).max() < 4  # no slivers


@pytest.mark.parametrize("shape", [icosphere(3), tube(12, 10), bent(grid(8, 8, holes=((3, 3), (5, 6))))])
def test_no_more_than_the_topology_allows(shape):
    vertices, faces = shape
    kept, simple, _ = simplify(vertices, faces, 1)
    assert 4 <= len(kept) < len(vertices) / 2
    assert tp.genus(simple) == 0
    assert len(tp.boundary_loops(simple)) == len(tp.boundary_loops(faces))
