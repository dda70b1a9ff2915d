"""What a page holds, decoded without a browser."""

import base64
import io
import json
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from PIL import Image

from mobius_match import Correspondence, FormatError, MeshError, SurfaceMap, match, viewer
from mobius_match.evaluation import Truth, examples, metrics
from mobius_match.geometry.points import SurfacePoints, points_at
from mobius_match.mesh import as_mesh, repair
from mobius_match.viewer import View, packing, page
from mobius_match.voting.mobius import CANONICAL_TRIANGLE, cross_ratio
from tests import shapes
from tests.viewer.pages import Prepared, info, write_ply


def element(text, name):
    return json.loads(re.search(f'id="{name}">(.*?)</script>', text, re.DOTALL)[1])


def numbers(packed, kind):
    return np.frombuffer(base64.b64decode(packed), kind)


def vertices(side):
    return places(side["positions"])


def places(found):
    codes = numbers(found["codes"], "<u2").reshape(-1, len(found["low"]))
    return found["low"] + codes * np.array(found["step"])


def ends(content, k=0):
    return [numbers(points, "<f4").reshape(-1, 3) for points in content["alignments"][k]["points"]]


def test_spheres_are_at_the_matched_vertices(result, mesh):
    content = element(page(result), "shapes")
    for side, points, matched in zip(content["sides"], ends(content), result.pairs.T, strict=True):
        np.testing.assert_allclose(points, vertices(side)[matched], atol=2e-5)
        np.testing.assert_array_equal(numbers(side["triangles"], "<u2").reshape(-1, 3), mesh.faces)
        # Turned and scaled at most: distances keep their ratios.
        ratios = np.linalg.norm(np.diff(vertices(side), axis=0), axis=1) / np.linalg.norm(
            np.diff(mesh.vertices, axis=0), axis=1
        )
        np.testing.assert_allclose(ratios, ratios.mean(), rtol=5e-3)


def test_loops_around_handles_are_closed_chains_of_edges(ring):
    result, loop = ring
    source, target = element(page(result), "shapes")["sides"]
    assert "loops" not in target
    from_to = numbers(source["loops"], "<f4").reshape(-1, 2, 3)
    np.testing.assert_allclose(
        from_to[:, 0], vertices(source)[np.searchsorted(result.source.mesh.vertex_ids, loop)], atol=2e-5
    )
    np.testing.assert_array_equal(from_to[:, 1], np.roll(from_to[:, 0], -1, axis=0))


def test_loops_of_a_loaded_result_are_found_again(ring, tmp_path):
    result = ring[0]
    whole = repair(as_mesh(shapes.torus()))
    write_ply(tmp_path / "ring.ply", whole, np.zeros((len(whole.vertices), 3)))
    mesh = as_mesh(tmp_path / "ring.ply")
    loaded = replace(result, source=None, source_info=info(mesh, str(tmp_path / "ring.ply")))
    # The map is one of the surface cut open, which the file of the result does not say.
    cut, n = replace(result.source.mesh, sha256=mesh.sha256), len(result.source.mesh.vertices)
    target = result.target.mesh
    there, back = points_at(target.faces, np.zeros(n, int)), points_at(cut.faces, np.zeros(len(target.vertices), int))
    dense = SurfaceMap(cut, target, there, back, np.full(n, True), np.full(len(target.vertices), True))
    contents = [element(text, "shapes")["sides"][0] for text in (page(result), page(loaded), page(loaded, dense=dense))]
    assert contents[0]["loops"] == contents[1]["loops"] == contents[2]["loops"]
    assert [len(vertices(side)) for side in contents] == [n, n - 16, n]


def test_exact_places_on_the_target_are_used(result, mesh):
    weights = np.full((24, 3), [0.5, 0.3, 0.2])
    faces = np.arange(24)
    exact = replace(result, target_points=SurfacePoints(faces, mesh.faces[faces], weights))
    content = element(page(exact), "shapes")
    expected = np.einsum("qk,qki->qi", weights, vertices(content["sides"][1])[mesh.faces[faces]])
    np.testing.assert_allclose(ends(content)[1], expected, atol=5e-5)


def test_a_large_mesh_is_drawn_with_fewer_vertices_and_spheres_stay(result, mesh, monkeypatch):
    whole = element(page(result), "shapes")
    monkeypatch.setattr(viewer.shapes, "MAX_VERTICES", 500)
    monkeypatch.setattr(viewer.shapes, "SIMPLIFIED_VERTICES", 200)
    simple = element(page(result), "shapes")
    for side, points, before in zip(simple["sides"], ends(simple), ends(whole), strict=True):
        assert side["simplified"]
        assert side["vertices"] == len(mesh.vertices)
        assert 150 < len(vertices(side)) < 250
        np.testing.assert_array_equal(points, before)
        apart = np.linalg.norm(points[:, None] - vertices(side)[None], axis=2).min(axis=1)
        assert apart.max() < 0.2


def test_a_loaded_result_reads_its_meshes_and_keeps_its_alternatives(tmp_path, result):
    path = examples.paths("quadruped")[0]
    mesh = repair(as_mesh(path))
    known = info(mesh, str(path))
    live = replace(result, source_info=known, target_info=known, source=Prepared(mesh), target=Prepared(mesh))
    file = tmp_path / "result.json"
    file.write_text(json.dumps(live.to_dict(alternatives=True)))
    loaded = Correspondence.load(file)
    assert page(loaded) == page(live)
    assert loaded.alternatives[0].share == 0.25
    with pytest.raises(MeshError, match="atch again"):
        page(replace(loaded, source_info={**known, "sha256": "0"}))


def test_nothing_but_finite_numbers(result):
    with pytest.raises(FormatError, match="match again"):
        page(replace(result, confidence=np.full(24, np.nan)))


def test_the_page_of_a_pair_with_its_map_is_small():
    sides = [repair(as_mesh(path)) for path in examples.paths("quadruped")]
    pairs = np.arange(100).reshape(-1, 1) * [40, 40]
    found = Correspondence(
        pairs=pairs, confidence=np.linspace(1, 0.5, 100), kind=np.full(100, "voted"),
        source_info=info(sides[0]), target_info=info(sides[1]), settings={},
        source=Prepared(sides[0]), target=Prepared(sides[1]),
    )  # fmt: skip
    assert len(page(found)) < 1_000_000


def test_colours_follow_the_map_and_are_grey_without_counterpart(result, dense):
    content = element(page(result, dense=dense), "shapes")
    names = ["Position", "Checkerboard", "Area distortion", "Angle distortion", "Distance distortion"]
    assert [one["name"] for one in content["colourings"]] == names
    source, target = (numbers(colours, "u1").reshape(-1, 3) for colours in content["colourings"][0]["colours"])
    np.testing.assert_array_equal(source[30:], target[30:])
    assert (target[:30] == np.round(255 * packing.NOTHING)).all()
    assert content["colourings"][1]["like"] == 0
    origins = [numbers(side["origins"], "<u2").reshape(-1, 3) for side in content["sides"]]
    np.testing.assert_array_equal(origins[0][30:], origins[1][30:])
    assert (origins[1][:30] == 65535).all()
    # The identity changes neither areas nor angles nor distances.
    for one, value in zip(content["colourings"][2:], (127, 0, 0), strict=True):
        source, target = (numbers(values, "u1") for values in one["values"])
        assert (source == value).all()
        assert (target[30:] == value).all()
        assert (target[:30] == 255).all()
        assert len(one["scale"]["labels"]) == 3


def test_the_morph_begins_at_the_source_and_ends_at_the_target(result, dense):
    """Turned round and larger there: shapes between neither shrink nor leave the page."""
    turned = replace(dense.target, vertices=dense.target.vertices @ np.diag([-1.0, 1, -1]) * 2, sha256="other")
    across = replace(dense, target=turned, target_mapped=dense.source_mapped)
    other = replace(result, target=Prepared(turned), target_info=info(turned))
    content = element(page(other, dense=across), "shapes")
    start, end = (vertices(side) for side in content["sides"])
    frames = places(content["morph"]).reshape(8, -1, 3)
    np.testing.assert_allclose(frames[-1], end, atol=1e-4)
    sizes = [np.linalg.norm(one - one.mean(axis=0), axis=1).mean() for one in (start, *frames)]
    assert np.ptp(sizes) < 0.02 * sizes[0]
    for k, one in enumerate((result, *result.alternatives)):
        moved = numbers(content["alignments"][k]["moved"], "<f4").reshape(8, -1, 3)
        np.testing.assert_allclose(moved, frames[:, one.pairs[:, 0]], atol=1e-4)


def test_the_morph_of_a_reflected_map_begins_with_the_mirror_image(result, dense, mesh):
    """The page shows the source itself, and as the first shape its mirror image, at the middle of the page."""
    image = replace(mesh.reflected(), sha256="other")
    points = dense.source_points.in_flipped_faces
    across = replace(dense, target=image, target_points=points, target_mapped=dense.source_mapped, reflected=True)
    other = replace(result, target=Prepared(image), target_info=info(image), reflected=True)
    text = page(other, dense=across)
    content = element(text, "shapes")
    assert element(text, "result")["reflected"] is True
    start, end = (vertices(side) for side in content["sides"])
    frames = places(content["morph"]).reshape(8, -1, 3)
    np.testing.assert_allclose(frames[-1], end, atol=1e-4)
    # The two mirror images differ by a rotation, so nothing is flattened on the way.
    sizes = [np.linalg.svd(one - one.mean(axis=0), compute_uv=False) for one in (start, *frames)]
    np.testing.assert_allclose(sizes, np.tile(sizes[0], (9, 1)), rtol=1e-3)
    moved = numbers(content["alignments"][0]["moved"], "<f4").reshape(8, -1, 3)
    np.testing.assert_allclose(moved, frames[:, result.pairs[:, 0]], atol=1e-4)


def test_colours_of_the_source_file_are_carried(tmp_path, result, dense, mesh):
    path = tmp_path / "coloured.ply"
    colours = np.arange(3 * len(mesh.vertices)).reshape(-1, 3) % 251
    write_ply(path, mesh, colours)
    coloured = repair(as_mesh(path))
    seen = replace(result, source=Prepared(coloured), source_info=info(coloured, str(path)))
    content = element(page(seen, dense=replace(dense, source=coloured)), "shapes")
    (own,) = [one for one in content["colourings"] if one["name"] == "Colours of the file"]
    source, target = (numbers(one, "u1").reshape(-1, 3) for one in own["colours"])
    np.testing.assert_array_equal(source, colours)
    np.testing.assert_array_equal(target[30:], colours[30:])


def test_the_texture_of_the_source_file_is_carried(textured):
    content = element(textured, "shapes")
    assert content["colourings"][2]["name"] == "Texture"
    source, target = content["sides"]
    known = [numbers(side["uv"]["known"], "u1").astype(bool) for side in (source, target)]
    assert known[0].all()
    assert 0 < (~known[1]).sum() < 200  # around the vertices without counterpart
    uv = [places(side["uv"]).reshape(-1, 3, 2) for side in (source, target)]
    np.testing.assert_allclose(uv[1][known[1]], uv[0][known[1]], atol=1e-3)
    picture = base64.b64decode(content["texture"].removeprefix("data:image/jpeg;base64,"))
    assert Image.open(io.BytesIO(picture)).size == (1024, 512)


def test_errors_are_those_of_the_evaluation(result, dense, mesh):
    """A truth that is off by one edge: each error is that edge's length, per diameter."""
    numbers_of = np.arange(len(mesh.vertices))
    shifted = mesh.faces[np.argsort(mesh.faces[:, 0], kind="stable")]
    shifted = shifted[np.searchsorted(shifted[:, 0], numbers_of).clip(max=len(shifted) - 1)]
    known = shifted[:, 0] == numbers_of
    truth = Truth(shifted[known, 0], shifted[known, 1])
    content = element(page(result, dense=dense, truth=truth), "shapes")
    diameter = metrics.diameter(mesh)
    errors = np.array(content["alignments"][0]["errors"])
    step = np.linalg.norm(mesh.vertices[truth.source] - mesh.vertices[truth.target], axis=1) / diameter
    near = np.searchsorted(truth.source, result.pairs[:, 0])
    same = truth.source[near] == result.pairs[:, 0]
    assert same.sum() > 12
    np.testing.assert_allclose(errors[same], step[near][same], atol=1e-6)
    assert len(content["alignments"][1]["errors"]) == 5
    assert max(content["alignments"][1]["errors"]) > 0.2
    (painted,) = [one for one in content["colourings"] if one["name"] == "Error"]
    source, target = (numbers(one, "u1") for one in painted["values"])
    np.testing.assert_allclose(source[truth.source] / 254 * 0.2, step, atol=0.0005)
    np.testing.assert_array_equal(source[30:], target[30:])
    assert (target[:30] == 255).all()


def test_what_is_not_known_has_no_error(result, dense):
    truth = Truth(result.pairs[:2, 0], result.pairs[:2, 1], landmarks=True)
    content = element(page(result, dense=dense, truth=truth), "shapes")
    assert [error for error in content["alignments"][0]["errors"] if error is not None] == [0.0, 0.0]
    source = numbers(content["colourings"][-1]["values"][0], "u1")
    assert 0 < (source != 255).sum() < 0.2 * len(source)
    with pytest.raises(FormatError, match="the list is of another mesh"):
        page(result, truth=Truth(np.array([10**6]), np.array([0])))


def test_the_votes_and_the_planes_are_those_of_the_match(matched):
    found = element(page(matched), "shapes")["insight"]
    shape = matched.votes.matrix.shape
    share = numbers(found["matrix"], "<u2").reshape(shape) / 65535
    np.testing.assert_allclose(share, matched.votes.matrix / matched.votes.matrix.max(), atol=1e-5)
    assert sorted(found["rows"]) == list(range(shape[0]))
    assert sorted(found["columns"]) == list(range(shape[1]))
    assert found["samples"][0] == matched.source.mesh.vertex_ids[matched.source.samples].tolist()
    planes = [numbers(plane, "<f4").reshape(-1, 2) @ [1, 1j] for plane in found["planes"]]
    assert all((np.abs(plane) <= 1).all() for plane in planes)
    opened = [plane / (1 - np.abs(plane)) for plane in planes]
    for plane, triplet, surface in zip(opened, found["triplet"], (matched.source, matched.target), strict=True):
        np.testing.assert_allclose(plane[triplet], CANONICAL_TRIANGLE, atol=1e-5)
        # A Moebius transformation leaves cross-ratios as they are.
        four = [*triplet, next(i for i in range(len(plane)) if i not in triplet)]
        np.testing.assert_allclose(
            cross_ratio(*plane[four]), cross_ratio(*surface.positions[four]), rtol=1e-3
        )  # fmt: skip
    # Mutually nearest, but for a few whose weight decides.
    for i, j in enumerate(found["paired"]):
        if j >= 0:
            assert found["paired"].count(j) == 1
            assert np.abs(opened[0][i] - opened[1][j]) < 0.5 or np.abs(opened[0][i]) > 3
    assert sum(j >= 0 for j in found["paired"]) >= 8


def test_the_planes_of_a_reflected_match_are_those_of_the_mirror_image():
    shape = as_mesh(shapes.lump())
    reflected = match(shape, shape.reflected(), samples=30, votes=4000, seed=0, reflect="yes")
    found = element(page(reflected), "shapes")["insight"]
    planes = [numbers(plane, "<f4").reshape(-1, 2) @ [1, 1j] for plane in found["planes"]]
    here, there = (plane / (1 - np.abs(plane)) for plane in planes)
    pairs = [(i, j) for i, j in enumerate(found["paired"]) if j >= 0 and np.abs(here[i]) <= 3]
    assert len(pairs) >= 20
    assert all(np.abs(here[i] - there[j]) < 0.5 for i, j in pairs)


def test_votes_of_uniform_triplets_and_too_few_of_them():
    shape = shapes.lump()
    uniform = match(shape, shape, samples=20, votes=3000, proposal="uniform", seed=0)
    found = element(page(uniform), "shapes")["insight"]
    rows, columns = found["triplet"]
    leading = np.argsort(-uniform.votes.matrix, axis=None)[0]
    assert [rows[0], columns[0]] == list(np.unravel_index(leading, (20, 20)))
    few = replace(uniform.votes, matrix=np.diag([1.0, 1.0, *[0.0] * 18]))
    assert "insight" not in element(page(replace(uniform, votes=few)), "shapes")


def test_a_map_of_other_meshes_is_refused(result, dense):
    other = repair(as_mesh(examples.paths("quadruped")[0]))
    wrong = SurfaceMap(
        dense.source, other, dense.target_points, dense.source_points, dense.source_mapped, dense.target_mapped
    )
    with pytest.raises(MeshError, match="`dense` is a map between other meshes"):
        page(result, dense=wrong)


def test_the_same_result_gives_the_same_page(result, dense):
    assert page(result, dense=dense) == page(result, dense=dense)


def test_a_notebook_shows_it_in_a_frame_of_its_own(result):
    shown = View(page(result))._repr_html_()
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts allow-downloads" [^<>]*></iframe>', shown)
    assert unescape(frame[1]) == page(result)
