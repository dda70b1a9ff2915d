"""Left against right: a mirror image is matched as the shape itself is, and told in the user's own coordinates."""

import json

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.geometry.points import points_at
from mobius_match.matching.reflection import odds
from mobius_match.mesh import Mesh
from mobius_match.mesh.measure import cross_products
from mobius_match.surface.reflected import reflected
from tests.shapes import bumpy_torus, icosphere, lump, rotation


def twisted(vertices, turn):
    """Points turned about the z axis, by an angle that grows with z: another pose."""
    cosine, sine = np.cos(turn * vertices[:, 2]), np.sin(turn * vertices[:, 2])
    x, y, z = vertices.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=1)


def union(*parts):
    start = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [faces + first for (_, faces), first in zip(parts, start, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def volume(vertices, faces):
    """Enclosed volume (times 6), positive if the faces point outward."""
    return float((cross_products(vertices, faces) * vertices[faces[:, 0]]).sum())


def errors(vertex_map, right):
    """Distances of mapped vertices from the right ones, per extent of the target; the truth is the same number."""
    vertices = right.mesh.vertices
    away = np.linalg.norm(vertices[vertex_map] - vertices, axis=1)
    return away / np.ptp(vertices, axis=0).max()


@pytest.fixture(scope="module")
def left():
    vertices, faces = lump(4)
    return mm.prepare(Mesh(vertices + np.array([5.0, 1.0, 0.0]), faces, name="left"))


@pytest.fixture(scope="module")
def twin():
    """The same shape in another pose; vertex i is vertex i."""
    vertices, faces = lump(4)
    return mm.prepare(Mesh(2 * twisted(vertices, 0.15) @ rotation(3), faces, name="twin"))


@pytest.fixture(scope="module")
def right(twin):
    """The mirror image of that."""
    return mm.prepare(twin.mesh.reflected())


@pytest.fixture(scope="module")
def plain(left, twin):
    return mm.match(left, twin, seed=0)


@pytest.fixture(scope="module")
def mirrored(left, right):
    return mm.match(left, right, seed=0, reflect="yes")


@pytest.fixture(scope="module")
def dense(mirrored):
    return mirrored.dense()


def test_the_mirror_image_of_a_mesh_points_outward_and_has_the_users_numbers(left):
    image = left.mesh.reflected()
    assert volume(image.vertices, image.faces) == pytest.approx(volume(left.mesh.vertices, left.mesh.faces))
    assert image.sha256 == left.mesh.sha256
    for name in ("vertex_ids", "face_ids"):
        np.testing.assert_array_equal(getattr(image, name), getattr(left.mesh, name))
    for name in ("vertices", "faces"):
        np.testing.assert_array_equal(getattr(image.reflected(), name), getattr(left.mesh, name))


@pytest.mark.parametrize("shape", ["whole", "simplified", "disc"])
def test_a_prepared_mirror_image_is_that_of_the_mirrored_mesh(shape):
    vertices, faces = lump(3)
    if shape == "disc":
        faces = faces[vertices[faces].min(axis=1)[:, 2] > -0.9]
    settings = {"samples": 50, "resolution": 300 if shape == "simplified" else 0}
    surface = mm.prepare((vertices, faces), **settings)
    image, anew = reflected(surface), mm.prepare(surface.whole_mesh.reflected(), **settings)
    np.testing.assert_array_equal(image.mesh.vertices, anew.mesh.vertices)
    np.testing.assert_array_equal(np.sort(image.mesh.faces), np.sort(anew.mesh.faces))
    np.testing.assert_array_equal(image.samples, anew.samples)
    for name in ("distances", "proxy_distances", "cells", "signatures", "curvatures"):
        np.testing.assert_allclose(getattr(image, name), getattr(anew, name), rtol=1e-3, atol=1e-4)
    # Flattenings agree up to a similarity of the plane, which keeps the orientation, and discs up to a rotation.
    for name in ("positions", "disc"):
        one, other = getattr(image, name), getattr(anew, name)
        assert len(one) == len(other) and (len(one) > 0) == (name == "positions" or shape == "disc")
        if len(one):
            one, other = ((plane - plane.mean()) / np.linalg.norm(plane - plane.mean()) for plane in (one, other))
            assert abs(np.vdot(one, other)) == pytest.approx(1, abs=1e-3)
    if shape == "simplified":
        here, there = (one.detail.places(one.mesh).values(one.mesh.vertices) for one in (image, surface))
        np.testing.assert_allclose(here * [-1, 1, 1], there)


def test_a_mirror_image_is_matched_as_the_shape_itself(plain, mirrored, dense, right):
    assert mirrored.reflected and not plain.reflected
    assert mirrored.settings["reflect"] == "yes" and plain.settings["reflect"] == "no"
    assert mirrored.warnings[-1] == "left: its mirror image was matched"
    # Sums of mirrored coordinates round otherwise: not to the last bit.
    assert len(mirrored) == pytest.approx(len(plain), rel=0.03)
    both = {tuple(pair) for pair in plain.pairs.tolist()} & {tuple(pair) for pair in mirrored.pairs.tolist()}
    assert len(both) > 0.5 * len(plain)
    assert errors(dense.vertex_map, right).mean() < 1.2 * errors(plain.dense().vertex_map, right).mean() + 1e-3
    assert errors(dense.vertex_map, right).max() < 0.1


def test_surfaces_and_maps_are_told_in_the_users_coordinates(mirrored, dense, left, right):
    assert mirrored.source is left and mirrored.target is right
    np.testing.assert_array_equal(dense.source.vertices, left.mesh.vertices)
    np.testing.assert_array_equal(dense.source.faces, left.mesh.faces)
    np.testing.assert_array_equal(dense.target.vertices, right.mesh.vertices)
    for points, mesh in ((dense.target_points, right.mesh), (dense.source_points, left.mesh)):
        np.testing.assert_array_equal(points.corners, mesh.faces[points.faces])
    back = dense.source_points.values(left.mesh.vertices)
    assert np.linalg.norm(back - left.mesh.vertices, axis=1).max() < 0.1 * np.ptp(left.mesh.vertices)


def test_no_is_what_it_was(left, right, plain, twin):
    again = mm.match(left, twin, seed=0, reflect="no")
    np.testing.assert_array_equal(again.pairs, plain.pairs)
    np.testing.assert_array_equal(again.confidence, plain.confidence)
    assert "reflected" not in plain.to_dict() and "reflected probability" not in plain.diagnostics
    # Without the mirror image, the two do not fit.
    assert errors(mm.match(left, right, seed=0).dense().vertex_map, right).mean() > 0.1


def test_auto_finds_a_mirror_image(left, right, mirrored):
    result = mm.match(left, right, seed=0, reflect="auto")
    assert result.reflected and result.diagnostics["reflected probability"] > 0.99
    assert result.warnings[-1].startswith("left: its mirror image was matched (probability 0.99")
    np.testing.assert_array_equal(result.pairs, mirrored.pairs)


def test_auto_leaves_a_shape_as_it_is(left, twin, plain):
    result = mm.match(left, twin, seed=0, reflect="auto")
    assert not result.reflected and result.diagnostics["reflected probability"] < 0.01
    assert result.warnings == plain.warnings and result.settings["reflect"] == "auto"
    np.testing.assert_array_equal(result.pairs, plain.pairs)
    np.testing.assert_array_equal(result.confidence, plain.confidence)


def test_auto_leaves_symmetric_shapes_as_they_are(shipped, shipped_match):
    plain = shipped_match("person")
    result = mm.match(*shipped("person"), seed=0, reflect="auto")
    assert 0.1 < result.diagnostics["reflected probability"] < odds(2.0)
    assert not result.reflected and result.warnings == plain.warnings
    np.testing.assert_array_equal(result.pairs, plain.pairs)


def test_quality_knows_that_orientation_is_reversed(dense):
    for surface_map in (dense, dense.inverse):
        measured = mm.quality(surface_map)
        assert measured.orientation > 0.97 and measured.kept.mean() == measured.orientation


def test_results_and_maps_are_saved_as_reflected(mirrored, dense, plain, tmp_path):
    mirrored.save(tmp_path / "mirrored.json")
    content = json.loads((tmp_path / "mirrored.json").read_text())
    assert content["reflected"] is True
    assert mm.Correspondence.load(tmp_path / "mirrored.json").reflected
    plain.save(tmp_path / "plain.json")
    assert not mm.Correspondence.load(tmp_path / "plain.json").reflected
    dense.save(tmp_path / "map.npz")
    loaded = mm.SurfaceMap.load(tmp_path / "map.npz")
    assert loaded.reflected and loaded.inverse.reflected
    np.testing.assert_array_equal(loaded.vertex_map, dense.vertex_map)
    plain.dense().save(tmp_path / "plain.npz")
    with np.load(tmp_path / "plain.npz") as file:
        assert "reflected" not in json.loads(str(file["head"]))
    assert not mm.SurfaceMap.load(tmp_path / "plain.npz").reflected


def test_a_saved_result_is_matched_again_in_the_same_way(tmp_path):
    vertices, faces = lump(3)
    paths = []
    for name, mesh in (("l", Mesh(vertices, faces)), ("r", Mesh(twisted(vertices, 0.1), faces).reflected())):
        paths.append(tmp_path / f"{name}.off")
        rows = [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
        rows += [f"3 {i} {j} {k}" for i, j, k in mesh.faces.tolist()]
        paths[-1].write_text("\n".join(["OFF", f"{len(vertices)} {len(faces)} 0", *rows]) + "\n")
    result = mm.match(*paths, seed=0, samples=50, reflect="auto")
    result.save(tmp_path / "result.json")
    again = mm.rematch(mm.Correspondence.load(tmp_path / "result.json"))
    assert result.reflected and again.reflected
    np.testing.assert_array_equal(again.pairs, result.pairs)
    np.testing.assert_array_equal(again.dense().vertex_map, result.dense().vertex_map)


def test_known_pairs_are_given_in_the_users_coordinates(left, right, tmp_path):
    given = [10, 500, 1200, 2000]
    for name, surface in (("l", left), ("r", right)):
        rows = [",".join(map(repr, row)) for row in surface.mesh.vertices[given].tolist()]
        (tmp_path / f"{name}.csv").write_text("\n".join(["x,y,z", *rows]) + "\n")
    for landmarks in (np.stack([given, given], axis=1), [tmp_path / "l.csv", tmp_path / "r.csv"]):
        result = mm.match(left, right, seed=0, reflect="yes", landmarks=landmarks)
        assert sorted(result.pairs[result.given].tolist()) == [[k, k] for k in given]
        assert result.settings["landmarks"] == [[k, k] for k in given]
        np.testing.assert_array_equal(result.dense().vertex_map[given], given)
        assert not any("off the surface" in line for line in result.warnings)
        assert errors(result.dense().vertex_map, right).mean() < 0.02


def test_landmarks_and_values_are_transferred(dense, left, right):
    transfer = mm.Transfer(dense)
    places, _ = transfer.points(points_at(left.mesh.faces, np.arange(0, 2500, 50)))
    true = right.mesh.vertices[::50][: len(places)]
    assert np.linalg.norm(places - true, axis=1).mean() < 0.02 * np.ptp(right.mesh.vertices)
    heights = transfer.values(left.mesh.vertices[:, 2])
    assert np.abs(heights - left.mesh.vertices[:, 2]).mean() < 0.05
    back = mm.Transfer(dense.inverse).positions()
    assert np.linalg.norm(back - left.mesh.vertices, axis=1).mean() < 0.02 * np.ptp(left.mesh.vertices)
    # The source's triangles on the target are turned inside out, unless they are flipped.
    positions, size = transfer.positions(), volume(right.mesh.vertices, right.mesh.faces)
    assert volume(positions, left.mesh.faces) == pytest.approx(-size, rel=0.05)
    assert volume(positions, left.mesh.reflected().faces) == pytest.approx(size, rel=0.05)


def test_a_morph_begins_with_the_mirror_image_in_the_same_box(dense, left):
    start, middle, end = mm.morph(dense, [0, 0.5, 1])
    vertices, faces = left.mesh.vertices, left.mesh.reflected().faces
    np.testing.assert_allclose(start[:, 1:], vertices[:, 1:])
    np.testing.assert_allclose(start[:, 0] + vertices[:, 0], vertices[:, 0].min() + vertices[:, 0].max())
    np.testing.assert_array_equal(end, dense.positions)
    volumes = [volume(shape - shape.mean(axis=0), faces) for shape in (start, middle, end)]
    assert 0 < 0.9 * volumes[0] < volumes[1] < volumes[2]


def test_the_papers_own_votes_know_mirror_images():
    left = mm.prepare(lump(3), preset="paper")
    # On the sphere: the triangle to which triplets are mapped has an orientation, and in the plane it tells.
    settings = {"preset": "paper", "distance": "spherical", "votes": 50_000, "seed": 0}
    plain, yes = mm.match(left, left, **settings), mm.match(left, reflected(left), reflect="yes", **settings)
    assert yes.reflected and yes.settings["preset"] == "paper"
    np.testing.assert_allclose(yes.votes.matrix, plain.votes.matrix, rtol=1e-6)
    np.testing.assert_array_equal(yes.pairs, plain.pairs)


def test_auto_compares_the_papers_own_matches():
    settings = {"preset": "paper", "samples": 60, "votes": 1_000_000, "seed": 0}
    result = mm.match(lump(4), Mesh(*lump(4)).reflected(), reflect="auto", **settings)
    assert result.reflected and result.diagnostics["reflected probability"] > 0.9
    assert (result.pairs[:15, 0] == result.pairs[:15, 1]).mean() > 0.7


def test_a_part_is_located_on_a_mirror_image():
    vertices, faces = lump(3)
    height = vertices @ [0.5, 1.0, 0.0]
    part = faces[(height[faces] > np.median(height) - 0.1).all(axis=1)]
    whole = Mesh(vertices @ rotation(5), faces).reflected()
    result = mm.match((vertices, part), whole, seed=0, samples=40, reflect="auto")
    assert result.reflected and any("treated as a partial scan" in line for line in result.warnings)
    used, size = np.unique(part), np.ptp(vertices)
    away = np.linalg.norm(whole.vertices[result.pairs[:, 0]] - whole.vertices[result.pairs[:, 1]], axis=1)
    assert len(result) > 25 and np.median(away) < 0.05 * size
    vertex_map = result.dense().vertex_map[used]
    away = np.linalg.norm(whole.vertices[vertex_map] - whole.vertices[used], axis=1)
    assert (vertex_map >= 0).mean() > 0.9 and away[vertex_map >= 0].mean() < 0.05 * size


def test_pieces_go_with_a_mirror_image():
    """Two bodies of similar size; and, on one side only, an eye that is carried along."""
    one, ball = lump(2), icosphere(1)
    shapes = [one, (0.8 * one[0] @ rotation(1) + np.array([6.0, 1.0, 0.0]), one[1])]
    eye = 0.2 * ball[0] + np.array([-1.0, 0.3, 0.2]), ball[1]
    first, second = union(*shapes, eye), union(*shapes)
    n, shift = len(second[0]), np.array([1.0, 2.0, 3.0])
    mirror, whole = (Mesh(one[0] @ rotation(7) + shift, one[1]).reflected() for one in (second, first))
    result = mm.match(first, mirror, seed=0, samples=30, reflect="auto")
    assert result.reflected and result.source.mesh.others is not None
    dense = result.dense()
    away = np.linalg.norm(mirror.vertices[dense.vertex_map[:n]] - mirror.vertices, axis=1)
    assert away.mean() < 0.03 * np.ptp(mirror.vertices)
    assert np.linalg.norm(dense.positions[n:] - whole.vertices[n:], axis=1).max() < 0.1


def test_what_is_carried_along_lies_beside_the_users_own_source():
    body, ball = lump(3), icosphere(1)
    eye = 0.2 * ball[0] + np.array([-1.0, 0.3, 0.2]), ball[1]
    target, n = union(body, eye), len(body[0])
    source = Mesh(body[0] @ rotation(7) + np.array([1.0, 2.0, 3.0]), body[1]).reflected()
    whole = Mesh(target[0] @ rotation(7) + np.array([1.0, 2.0, 3.0]), target[1]).reflected()
    back = mm.match(source, target, seed=0, samples=40, reflect="yes").dense().inverse
    assert back.reflected
    assert np.linalg.norm(back.positions[n:] - whole.vertices[n:], axis=1).max() < 0.1


def test_a_surface_with_a_handle_has_a_mirror_image_in_both_readings():
    (vertices, faces), _ = bumpy_torus(3.0, 0.0, 40, 16)
    mirror = Mesh(vertices @ rotation(2), faces).reflected()
    result = mm.match((vertices, faces), mirror, seed=0, samples=40, reflect="yes")
    assert result.reflected and result.source.handles_kept and result.target.handles_kept
    np.testing.assert_array_equal(result.source.mesh.vertices, vertices)
    away = mirror.vertices[result.dense().vertex_map] - mirror.vertices
    assert np.linalg.norm(away, axis=1).mean() < 0.02 * np.ptp(vertices)


def test_what_is_exported_says_that_the_mirror_image_was_matched(mirrored, dense, plain, tmp_path):
    mirrored.export(tmp_path / "mirrored.npz", dense=dense)
    plain.export(tmp_path / "plain.npz")
    with np.load(tmp_path / "mirrored.npz") as one, np.load(tmp_path / "plain.npz") as other:
        assert one["reflected"] and "reflected" not in other.files
        np.testing.assert_array_equal(one["source_points"], mirrored.source.mesh.vertices[mirrored.pairs[:, 0]])
    for result, said in ((mirrored, True), (plain, False)):
        (file,) = result.export(tmp_path / "matches.tps")
        assert ("the mirror image of the source was matched" in file.read_text()) == said
