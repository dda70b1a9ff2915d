"""Pieces that both shapes have: two bodies, eyes, a piece without a partner; pieces by name."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import MeshError, SettingsError
from mobius_match.matching.pieces.copies import laid_on
from mobius_match.mesh import Mesh, describe, read_mesh, repair
from mobius_match.mesh.pieces import main_piece
from tests.shapes import ellipsoid, icosphere, lump, rotation


def union(*parts):
    start = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(
        [faces + first for (_, faces), first in zip(parts, start, strict=False)]
    )


def second_lump():
    """A shape of the size of the lump's, with other bumps."""
    vertices, faces = icosphere(3)
    radius = (
        1.2 + 0.5 * np.exp((vertices @ [0.6, 0.8, 0] - 1) / 0.05) + 0.4 * np.exp((vertices @ [0, -0.6, 0.8] - 1) / 0.1)
    )
    return vertices * radius[:, None], faces


def moved(vertices):
    return 2 * vertices @ rotation(2) + [3, -1, 4]


@pytest.fixture(scope="module")
def two_bodies():
    """Two bodies side by side, and the same moved, in the other order, of other sizes so that the largest changes."""
    one, other = lump(3), second_lump()
    shift = np.array([6.0, 1.0, 0.0])
    first = union(one, (other[0] + shift, other[1]))
    second = union((moved(1.5 * other[0] + shift), other[1]), (moved(one[0]), one[1]))
    return first, second


def test_two_bodies_are_matched_with_their_own_whatever_their_order_and_size(two_bodies):
    n = len(lump(3)[0])
    result = mm.match(*two_bodies, seed=0)
    swapped = np.r_[n : 2 * n, 0:n]
    vertex_map = result.dense().vertex_map
    assert ((vertex_map < n) == (swapped < n)).mean() == 1
    error = np.linalg.norm(two_bodies[1][0][vertex_map] - two_bodies[1][0][swapped], axis=1)
    assert error.mean() < 0.02 * np.sqrt(result.target_info["area"])
    # Both are in the list, the most confident first.
    assert (result.pairs[:, 0] < n).sum() > 100 and (result.pairs[:, 0] >= n).sum() > 100
    assert (np.diff(result.confidence) <= 0).all() and len(result.target_points.faces) == len(result)
    assert ((result.pairs[:, 1] < n) == (result.pairs[:, 0] >= n)).all()
    assert any("1 further piece" in warning for warning in result.warnings)
    assert any("the main piece is that of" in warning for warning in result.warnings)


def test_eyes_find_each_other_and_a_hat_is_not_forced_on_them():
    """Two eyes at other places of the list, and a hat that the other shape does not have."""
    body, ball = lump(4), icosphere(2)
    top = body[0][np.linalg.norm(body[0], axis=1).argmax()]
    eyes = [(0.1 * ball[0] + place, ball[1]) for place in ([0.0, -0.9, -0.1], [-1.0, 0.3, 0.2])]
    hat = ellipsoid((0.9, 0.9, 0.3), 2)
    hat = hat[0] + 1.2 * top, hat[1]
    first = union(eyes[0], eyes[1], body, hat)
    second = union(body, eyes[1], eyes[0])
    second = moved(second[0]), second[1]
    vertex_map = mm.match(first, second, seed=0).dense().vertex_map
    n, m = len(ball[0]), len(body[0])
    # The turn of a ball in its socket is kept, too.
    np.testing.assert_array_equal(vertex_map[:n], m + n + np.arange(n))
    np.testing.assert_array_equal(vertex_map[n : 2 * n], m + np.arange(n))
    assert (vertex_map[2 * n + m :] < m).all() and (vertex_map >= 0).all()


def test_all_matches_small_pieces_by_the_whole_method():
    small = second_lump()
    small = 0.25 * small[0] + [0.0, -1.5, 0.0], small[1]
    first = union(lump(3), small)
    second = moved(first[0]), first[1]
    n = len(lump(3)[0])
    largest, every = (mm.match(first, second, pieces=pieces, seed=0) for pieces in ("largest", "all"))
    assert (largest.pairs < n).all() and (every.pairs[:, 0] >= n).sum() > 50
    assert every.settings["pieces"] == "all"
    for result in (largest, every):
        error = np.linalg.norm(second[0][result.dense().vertex_map] - second[0], axis=1)
        assert error[n:].mean() < 0.02 * np.sqrt(result.target_info["area"])


def test_a_row_of_pieces_that_look_alike_keeps_its_order():
    """Six flat pieces that touch, as a fan; in the other shape it is turned by 1.5 times the angle of two."""
    body, ball = lump(4), icosphere(2)
    blade = ball[0] * [0.6, 0.12, 0.05] + [0.55, 0, 0]

    def fan(start):
        angles = start + 0.2 * np.arange(6)
        turns = [np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]]) for a in angles]
        return [(blade @ turn + [0.0, -0.9, 0.2], ball[1]) for turn in turns]

    first, second = union(body, *fan(-2.1)), union(body, *fan(-1.6))
    vertex_map = mm.match(first, (moved(second[0]), second[1]), seed=0).dense().vertex_map
    n, m = len(body[0]), len(ball[0])
    np.testing.assert_array_equal((vertex_map[n:] - n) // m, np.repeat(np.arange(6), m))


def test_a_copy_is_laid_on_its_like_from_a_wrong_start():
    vertices, faces = second_lump()
    there = moved(vertices)
    start = there @ rotation(5) * 0.8 + 0.4
    dense = laid_on(Mesh(vertices, faces), Mesh(there, faces), start, 0.3)
    np.testing.assert_array_equal(dense.target_points.nearest, np.arange(len(vertices)))


@pytest.fixture
def obj(tmp_path):
    """A large ball of group 'box', then a small lump of object 'my body' and material 'skin', in an OBJ file."""
    path = tmp_path / "scene.obj"
    ball, body = icosphere(2), lump(3)
    lines = ["o thing", "g box other"]
    lines += [f"v {x} {y} {z}" for x, y, z in 5 * ball[0] + 20] + [f"f {a} {b} {c}" for a, b, c in ball[1] + 1]
    lines += ["o my body", "g", "usemtl skin"]
    lines += [f"v {x} {y} {z}" for x, y, z in body[0]]
    lines += [f"f {a} {b} {c}" for a, b, c in body[1] + 1 + len(ball[0])]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_names_of_an_obj_file(obj):
    names = dict(read_mesh(obj).names)
    assert list(names) == ["thing", "my body", "box", "other", "skin"]
    np.testing.assert_array_equal(names["box"], np.arange(320))
    for name in ("my body", "skin"):
        np.testing.assert_array_equal(names[name], 320 + np.arange(1280))
    mesh = repair(read_mesh(obj))
    assert main_piece(mesh).face_ids[0] == 0
    main = main_piece(mesh, "skin")
    assert main.face_ids[0] == 320 and "the largest named 'skin'" in main.notes[-1]
    assert [one["names"] for one in describe(read_mesh(obj))["pieces"]] == [
        ["thing", "box", "other"],
        ["my body", "skin"],
    ]
    with pytest.raises(MeshError, match="no group, object, material or node is named 'hair'; there are 'thing', "):
        main_piece(mesh, "hair")


def test_a_match_by_name(obj, tmp_path):
    body = lump(3)
    result = mm.match(obj, (moved(body[0]), body[1]), pieces="skin", seed=0)
    assert (result.pairs[:, 0] >= 162).all() and result.settings["pieces"] == "skin"
    surface = mm.prepare(obj, pieces="skin")
    assert len(surface.mesh.vertices) == 642
    surface.save(tmp_path / "skin.npz")
    again = mm.match(tmp_path / "skin.npz", (moved(body[0]), body[1]), seed=0)
    np.testing.assert_array_equal(again.pairs, result.pairs)
    with pytest.raises(SettingsError, match="`pieces` is 'box', but the source scene"):
        mm.match(surface, body, pieces="box")
    # Whether all pieces are matched is no matter of preparation.
    assert mm.prepare(obj, pieces="all").settings == mm.prepare(obj).settings


def test_names_of_a_gltf_file(tmp_path):
    import trimesh

    scene = trimesh.Scene()
    parts = {"ball": icosphere(2), "lump": lump(3)}
    for name, (vertices, faces) in parts.items():
        scene.add_geometry(trimesh.Trimesh(vertices, faces, process=False), geom_name=f"{name} mesh", node_name=name)
    for path in (tmp_path / "scene.glb", tmp_path / "scene.gltf"):
        scene.export(path)
        names = dict(read_mesh(path).names)
        assert {"ball", "lump", "ball mesh", "lump mesh"} <= set(names)
        assert len(names["ball"]) == len(names["ball mesh"]) == 320
        assert len(main_piece(repair(read_mesh(path)), "ball").faces) == 320
    names = dict(mm.read_mesh(path).names)
    assert sorted(np.concatenate([names["ball"], names["lump"]])) == list(range(1600))
