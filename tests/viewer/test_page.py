"""What a page holds, decoded without a browser."""

import base64
import json
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

from mobius_match import Correspondence, FormatError, MeshError, SurfaceMap, examples, viewer
from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import as_mesh, repair
from mobius_match.viewer import page
from tests.viewer.pages import Prepared, info


def element(text, name):
    return json.loads(re.search(f'id="{name}">(.*?)</script>', text, re.DOTALL)[1])


def numbers(packed, kind):
    return np.frombuffer(base64.b64decode(packed), kind)


def vertices(side):
    codes = numbers(side["positions"], "<u2").reshape(-1, 3)
    return side["low"] + codes * np.array(side["step"])


def ends(content, k=0):
    return [numbers(points, "<f4").reshape(-1, 3) for points in content["explanations"][k]["points"]]


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


def test_exact_places_on_the_target_are_used(result, mesh):
    weights = np.full((24, 3), [0.5, 0.3, 0.2])
    faces = np.arange(24)
    exact = replace(result, target_points=SurfacePoints(faces, mesh.faces[faces], weights))
    content = element(page(exact), "shapes")
    expected = np.einsum("qk,qki->qi", weights, vertices(content["sides"][1])[mesh.faces[faces]])
    np.testing.assert_allclose(ends(content)[1], expected, atol=5e-5)


def test_a_large_mesh_is_drawn_with_fewer_vertices_and_spheres_stay(result, mesh, monkeypatch):
    whole = element(page(result), "shapes")
    monkeypatch.setattr(viewer, "MOST", 500)
    monkeypatch.setattr(viewer, "FEWER", 200)
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
    with pytest.raises(MeshError, match="match again"):
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


def test_colours_go_by_the_map_and_nothing_is_grey(result, dense):
    content = element(page(result, dense=dense), "shapes")
    assert [one["name"] for one in content["colourings"]] == [
        "Places", "Squares", "Change of area", "Change of distances",
    ]  # fmt: skip
    for one in content["colourings"]:
        source, target = (numbers(colours, "u1").reshape(-1, 3) for colours in one["colours"])
        np.testing.assert_array_equal(source[30:], target[30:])
        assert (target[:30] == np.round(255 * viewer.NOTHING)).all()
    origins = [numbers(side["origins"], "<u2").reshape(-1, 3) for side in content["sides"]]
    np.testing.assert_array_equal(origins[0][30:], origins[1][30:])
    assert (origins[1][:30] == 65535).all()
    # The identity changes neither areas nor distances.
    area, distances = (numbers(one["colours"][0], "u1").reshape(-1, 3) for one in content["colourings"][2:])
    assert (np.abs(area - viewer.DIVERGING[2]) <= 1).all()
    assert (np.abs(distances - viewer.RISING[0]) <= 1).all()


def test_a_map_of_other_meshes_is_refused(result, dense):
    other = repair(as_mesh(examples.paths("quadruped")[0]))
    wrong = SurfaceMap(dense.source, other, dense.points, dense.back, dense.found, dense.back_found)
    with pytest.raises(MeshError, match="other meshes"):
        page(result, dense=wrong)


def test_the_same_result_gives_the_same_page(result, dense):
    assert page(result, dense=dense) == page(result, dense=dense)


def test_a_notebook_shows_it_in_a_frame_of_its_own(result):
    shown = result.show()._repr_html_()
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts allow-downloads" [^<>]*></iframe>', shown)
    assert unescape(frame[1]) == page(result)
