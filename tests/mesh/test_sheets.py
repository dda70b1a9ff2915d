"""Non-manifold edges come apart into the sheets that a person would see, and one-sided surfaces are cut where short."""

import json
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobius_match.errors import TopologyError
from mobius_match.mesh import Mesh, describe, repair, require_matchable
from mobius_match.mesh import topology as tp
from mobius_match.mesh.pieces import main_piece
from mobius_match.mesh.sheets import MOST_SHEETS
from tests.shapes import icosphere, lump

from .test_repair import rows


def manifold(mesh):
    """Whether each edge has at most two faces, each vertex one fan, and neighbours agree."""
    table = tp.edge_table(mesh.faces)
    _, turned, twisted = tp.sides(mesh.faces, table)
    many = len(tp.nonmanifold_edges(table)) + len(tp.nonmanifold_vertices(mesh.faces, table))
    return not many and not (turned | twisted).any()


def welded(*parts):
    """Several (vertices, faces) in one; equal vertices become one, the lowest."""
    start = np.cumsum([0] + [len(v) for v, _ in parts])
    vertices = np.concatenate([v for v, _ in parts])
    faces = np.concatenate([f + s for (_, f), s in zip(parts, start, strict=False)])
    first, number = np.unique(vertices.round(9), axis=0, return_index=True, return_inverse=True)[1:]
    return vertices, first[number.ravel()][faces]


def pieces(mesh):
    return np.sort(np.bincount(tp.components(mesh.faces)[1])).tolist()


def mirrored_at_edge(vertices, faces):
    """The shape and its copy, turned by half a turn about one of its edges, which both then have."""
    a, b = vertices[faces[0, :2]]
    axis = (b - a) / np.linalg.norm(b - a)
    arm = vertices - a
    return welded((vertices, faces), (a + 2 * (arm @ axis)[:, None] * axis - arm, faces))


TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)


@pytest.mark.parametrize("solid", [icosphere(2), TETRAHEDRON], ids=["obtuse", "acute"])
def test_solids_that_touch_at_an_edge_come_apart(solid):
    vertices, faces = mirrored_at_edge(*solid)
    assert tp.edge_table(faces).counts.max() == 4
    fixed = repair(Mesh(vertices, faces))
    assert manifold(fixed) and tp.genus(fixed.faces) == 0 and pieces(fixed) == [len(faces) // 2] * 2
    np.testing.assert_array_equal(fixed.vertex_ids[fixed.faces], faces)
    assert np.sum(np.bincount(fixed.vertex_ids) == 2) == 2
    assert fixed.notes[0].startswith("1 edge with more than two faces separated into sheets (the first joins vertices ")


def test_spheres_that_touch_along_a_path():
    vertices, faces = icosphere(2)
    path = faces[[0]][0]
    second = vertices * [1.3, 1.2, 1.1]
    second[path] = vertices[path]
    fixed = repair(Mesh(*welded((vertices, faces[1:]), (second[:, [0, 1, 2]], faces[1:, ::-1]))))
    # The rims of two holes in one place: one closed surface, a sphere within a sphere, through the hole.
    assert manifold(fixed) and tp.genus(fixed.faces) == 0 and pieces(fixed) == [2 * len(faces) - 2]


def test_three_pages_keep_the_smoothest_pair(shapes):
    vertices, faces = shapes.book(3)
    spine, page = 7, 72
    # The third page leans towards the second: the first and the second continue each other best.
    for k, angle in enumerate((0.0, np.pi, np.pi / 2)):
        own = np.setdiff1d(faces[k * page : (k + 1) * page], faces[: k * page])
        radius = np.hypot(*vertices[own, :2].T)
        vertices[own, :2] = radius[:, None] * [np.cos(angle), np.sin(angle)]
    fixed = repair(Mesh(vertices, faces))
    assert manifold(fixed) and pieces(fixed) == [page, 2 * page]
    label = tp.components(fixed.faces)[1]
    assert set(fixed.face_ids[label == label[0]].tolist()) == set(range(2 * page))
    assert np.sum(np.bincount(fixed.vertex_ids) == 2) == spine


def test_four_pages_become_two_sheets_that_do_not_cross(shapes):
    vertices, faces = shapes.book(4)
    fixed = repair(Mesh(vertices, faces))
    assert manifold(fixed) and pieces(fixed) == [144, 144]
    label = tp.components(fixed.faces)[1].reshape(4, 72)
    assert (label == label[:, :1]).all()
    for page, following in ((0, 1), (1, 2), (2, 3), (3, 0)):
        opposite = {0, 1, 2, 3} - {page, following}
        if label[page, 0] == label[following, 0]:
            assert len({label[k, 0] for k in opposite}) == 1
            break
    else:
        pytest.fail("opposite pages were joined")


def test_many_pages_are_flaps(shapes):
    number = MOST_SHEETS + 2
    fixed = repair(Mesh(*shapes.book(number)))
    assert manifold(fixed) and pieces(fixed) == [72] * number


def test_a_wall_stands_on_its_floor():
    """The wall goes across the whole floor, so that all three sheets are separate patches."""
    u, v = (x.ravel() for x in np.meshgrid(np.arange(7.0), np.arange(7.0), indexing="ij"))
    a = (np.arange(6)[:, None] * 7 + np.arange(6)).ravel()
    faces = np.concatenate([np.stack([a, a + 7, a + 8], 1), np.stack([a, a + 8, a + 1], 1)])
    floor = np.stack([u, v - 3, 0 * u], 1), faces
    wall = np.stack([u, 0 * u, v], 1), faces
    fixed = repair(Mesh(*welded(floor, wall)))
    assert manifold(fixed) and pieces(fixed) == [72, 72]
    flat = (fixed.vertices[fixed.faces][:, :, 2] == 0).all(axis=1)
    assert flat.sum() == 72 and len(np.unique(tp.components(fixed.faces)[1][flat])) == 1


def test_a_flap_without_area_goes():
    vertices, faces = icosphere(2)
    a, b = faces[40, :2]
    vertices = np.concatenate([vertices, [vertices[a] + 0.3 * (vertices[b] - vertices[a])]])
    fixed = repair(Mesh(vertices, np.concatenate([faces, [[a, b, len(vertices) - 1]]])))
    assert rows(fixed.faces) == rows(faces)
    assert fixed.notes[:2] == (
        "1 edge with more than two faces separated into sheets "
        f"(the first joins vertices {min(a, b)} and {max(a, b)}).",
        "1 flap without area dropped there.",
    )


@cache
def clean():
    return lump(3)


@settings(max_examples=60)
@given(st.data(), st.integers(0, 2**32 - 1), st.sampled_from(["fin", "folded", "bubble", "patch"]))
def test_what_is_glued_to_a_surface_leaves_it_as_it_was(data, seed, kind):
    """A fin along a path of edges, a fin of two layers, a closed bubble on an edge, a face between three vertices."""
    vertices, faces = clean()
    rng, n = np.random.default_rng(seed), len(vertices)
    path = [int(rng.integers(n))]
    edges = tp.edge_table(faces).edges
    for _ in range(1 if kind == "bubble" else data.draw(st.integers(1, 6))):
        near = np.setdiff1d(edges[(edges == path[-1]).any(axis=1)], path)
        path += [int(rng.choice(near))] if len(near) else []
    top = n + np.arange(len(path))
    low, high = np.array(path[:-1]), np.array(path[1:])
    if kind == "bubble":
        (u,), (v,), (w, x) = low, high, top
        glued = np.array([[v, u, w], [u, v, x], [w, u, x], [v, w, x]])
    elif kind == "patch":
        glued = (
            np.array([[path[0], path[len(path) // 2], path[-1]]])
            if len(set(path)) > 2
            else np.array([[path[0], path[1], n]])
        )
    else:
        glued = np.concatenate([np.stack([low, high, top[1:]], 1), np.stack([low, top[1:], top[:-1]], 1)])
    glued = glued[~(np.sort(glued, 1)[:, None] == np.sort(faces, 1)[None]).all(axis=2).any(axis=1)]
    if kind == "folded":
        glued = np.concatenate([glued, glued[:, ::-1]])
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1).mean()
    extra = vertices[path] + 0.3 * length * rng.normal(size=(len(path), 3))
    mesh = Mesh(np.concatenate([vertices, extra]), rng.permutation(np.concatenate([faces, glued])))
    fixed = main_piece(repair(mesh))
    assert rows(fixed.vertex_ids[fixed.faces]) == rows(faces)
    np.testing.assert_array_equal(np.sort(fixed.vertex_ids), np.arange(n))


def test_a_soup_with_fins_is_closed():
    """As an STL file: each face has vertices of its own, three of them along the edges of a path."""
    vertices, faces = icosphere(3)
    path = [0]
    edges = tp.edge_table(faces).edges
    while len(path) < 6:
        path.append(int(np.setdiff1d(edges[(edges == path[-1]).any(axis=1)], path)[-1]))
    glued = np.stack([path[:-1], path[1:], len(vertices) + np.arange(5)], axis=1)
    points, all_faces = np.concatenate([vertices, 1.2 * vertices[path[:5]]]), np.concatenate([faces, glued])
    fixed = main_piece(repair(Mesh(points[all_faces].reshape(-1, 3), np.arange(all_faces.size).reshape(-1, 3))))
    assert len(fixed.vertices) == len(vertices) and len(fixed.faces) == len(faces)
    assert manifold(fixed) and not len(tp.boundary_loops(fixed.faces))


def test_a_neck_of_one_edge_is_cut(shapes):
    """A torus with a ring drawn together to two vertices: two sheets on one edge, which is a handle until it is cut."""
    u, v, faces = shapes.grid(12, 3, wrap_u=True, wrap_v=True)
    r = 2 + 0.5 * np.cos(2 * np.pi * v)
    vertices = np.stack([r * np.cos(2 * np.pi * u), r * np.sin(2 * np.pi * u), 0.5 * np.sin(2 * np.pi * v)], 1)
    faces = np.where(faces == 2, 1, faces)
    faces = faces[(faces != faces[:, [1, 2, 0]]).all(axis=1)]
    assert tp.edge_table(faces).counts.max() == 4
    fixed = repair(Mesh(vertices, faces))
    assert manifold(fixed) and tp.genus(fixed.faces) == 0 and len(fixed.faces) == len(faces)
    require_matchable(fixed)


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1), st.integers(1, 80), st.integers(4, 14))
def test_any_triangles_become_a_manifold(seed, m, n):
    rng = np.random.default_rng(seed)
    faces = np.array([rng.choice(n, 3, replace=False) for _ in range(m)])
    fixed = repair(Mesh(rng.normal(size=(n, 3)), faces))
    table = tp.edge_table(fixed.faces)
    assert not len(tp.nonmanifold_edges(table)) and not len(tp.nonmanifold_vertices(fixed.faces, table))
    assert set(fixed.face_ids.tolist()) <= set(range(m))
    assert np.sort(fixed.vertex_ids[fixed.faces], 1).tolist() == np.sort(faces[fixed.face_ids], 1).tolist()
    assert repair(fixed).notes == fixed.notes


def test_all_places_are_in_the_description(shapes):
    vertices, faces = shapes.book(3)
    info = json.loads(json.dumps(describe(Mesh(vertices, faces))))
    assert info["nonmanifold_edges"] == len(info["nonmanifold_edge_places"]) == 6
    for entry in info["nonmanifold_edge_places"]:
        assert entry["faces"] == 3
        assert entry["place"] == pytest.approx(vertices[entry["vertices"]].mean(axis=0).tolist())
    info = describe(Mesh(*shapes.bowtie()))
    assert info["nonmanifold_vertex_places"] == [{"vertex": 0, "place": [0.0, 0.0, 0.0]}]


def klein(nu=24, nv=16, radius=2.0):
    u, v = (x.ravel() for x in np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij"))
    faces = []
    for i in range(nu):
        for j in range(nv):
            at = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            a, b, c, d = (k % nu * nv + (-m if k == nu else m) % nv for k, m in at)
            faces += [[a, b, c], [a, c, d]]
    s, t = np.pi * u / nu, 2 * np.pi * v / nv
    wide = radius + np.cos(s) * np.sin(t) - np.sin(s) * np.sin(2 * t)
    height = np.sin(s) * np.sin(t) + np.cos(s) * np.sin(2 * t)
    return np.stack([wide * np.cos(2 * s), wide * np.sin(2 * s), height], axis=1), np.array(faces)


@pytest.mark.parametrize("holes", [0, 1])
def test_a_klein_bottle_is_refused(holes):
    vertices, faces = klein()
    faces = faces[holes:]
    table = tp.edge_table(faces)
    assert tp.euler_characteristic(faces) == -holes and tp.sides(faces, table)[2].all()
    with pytest.raises(TopologyError, match="only one side, like a Klein bottle"):
        require_matchable(repair(Mesh(vertices, faces)))


def test_a_moebius_band_is_cut_across(shapes):
    vertices, faces = shapes.moebius()
    fixed = repair(Mesh(vertices, faces))
    require_matchable(fixed)
    assert tp.genus(fixed.faces) == 0 and len(tp.boundary_loops(fixed.faces)) == 1 and manifold(fixed)
    assert len(fixed.faces) == len(faces)
    # Four vertices lie on a straight line across the band; each of them is now two.
    assert np.sum(np.bincount(fixed.vertex_ids) == 2) == 4
    assert fixed.notes[0].startswith("surface with one side only cut open along 3 edges (0.4")
    assert repair(fixed).notes == fixed.notes
    np.testing.assert_array_equal(repair(fixed).faces, fixed.faces)


@pytest.mark.parametrize("subdivisions", [3, 4])
def test_a_small_cross_cap_is_cut(subdivisions):
    """The six neighbours of a vertex made three, opposite with opposite: a sphere with a cross-cap."""
    vertices, faces = icosphere(subdivisions)
    centre = 100
    around = faces[(faces == centre).any(axis=1)]
    following = {int(np.roll(f, -list(f).index(centre))[1]): int(np.roll(f, -list(f).index(centre))[2]) for f in around}
    ring = [next(iter(following))]
    while len(ring) < len(following):
        ring.append(following[ring[-1]])
    assert len(ring) == 6
    number = np.arange(len(vertices))
    number[ring[3:]] = ring[:3]
    vertices[ring[:3]] = vertices[centre] + 0.1 * (vertices[ring[:3]] - vertices[centre])
    capped = number[faces[~(faces == centre).any(axis=1)]]
    assert tp.sides(capped, tp.edge_table(capped))[2].all()
    fixed = repair(Mesh(vertices, capped))
    require_matchable(fixed)
    assert manifold(fixed) and len(fixed.faces) == len(capped)
    assert tp.boundary_lengths(tp.edge_table(fixed.faces)).tolist() == [6]
    assert "cut open along 3 edges" in fixed.notes[0]
