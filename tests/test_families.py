"""The families of shapes that tools/families.py writes: sound meshes, exact truth, the same bytes each time."""

import json
from dataclasses import replace

import families
import numpy as np
import pytest
import trimesh
from bodies import Bone, symmetry
from families import KINDS, Family, main
from implicit import field, surface
from instances import clipped, overlaps

from mobius_match.evaluation.datasets import find_dataset

SMALL = ["--instances", "2", "--vertices", "500", "800"]


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("families")
    main([str(folder), "--kinds", "teddy,vase,molar", *SMALL])
    return folder


def rest(folder, name):
    """The places on the template of all vertices of an instance, and what its posed template says of them."""
    template = trimesh.load(folder / "truth" / "template.ply", process=False)
    truth = np.load(folder / "truth" / f"{name}.npz")
    corners = template.faces[truth["template_faces"]]
    return tuple(
        np.einsum("ki,kij->kj", truth["barycentric"], places[corners]) for places in (template.vertices, truth["posed"])
    )


def known(folder, name):
    return np.loadtxt(folder / "corres" / f"{name}.vts", dtype=int) - 1


@pytest.mark.parametrize("kind", ["teddy", "vase", "molar"])
def test_meshes_are_sound(written, kind):
    counts = set()
    for number in range(2):
        mesh = trimesh.load(written / kind / f"{kind}{number}.ply", process=False)
        assert mesh.body_count == 1
        assert mesh.is_winding_consistent
        if kind == "molar":
            assert mesh.euler_number == 1
            rim = mesh.edges[trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1)]
            assert len(trimesh.graph.connected_components(rim)) == 1
        else:
            assert mesh.is_watertight
            assert mesh.volume > 0
            assert mesh.euler_number == 2
        counts.add(len(mesh.vertices))
    assert len(counts) == 2, "each instance has its own triangulation"


@pytest.mark.parametrize("kind", ["teddy", "vase", "molar"])
def test_every_vertex_lies_where_its_place_on_the_template_went(written, kind):
    for number in range(2):
        vertices = trimesh.load(written / kind / f"{kind}{number}.ply", process=False).vertices
        moved = rest(written / kind, f"{kind}{number}")[1]
        np.testing.assert_allclose(moved, vertices, atol=1e-6 * np.ptp(vertices))


@pytest.mark.parametrize("kind", ["teddy", "vase", "molar"])
def test_lines_of_the_lists_are_one_point(written, kind):
    folder = written / kind
    places = [rest(folder, f"{kind}{number}")[0][known(folder, f"{kind}{number}")] for number in range(2)]
    apart = np.linalg.norm(places[0] - places[1], axis=1)
    template = trimesh.load(folder / "truth" / "template.ply", process=False)
    edge = np.sqrt(template.area / 500)
    assert apart.max() < 3 * edge
    assert np.median(apart) < edge


@pytest.mark.parametrize(("kind", "word"), [("teddy", "sym"), ("vase", "turn6"), ("vase", "sym")])
def test_lists_of_a_symmetry_are_images_at_rest(written, kind, word):
    folder, name = written / kind, f"{kind}1"
    places = rest(folder, name)[0]
    images = places[known(folder, name)] @ symmetry(KINDS[kind], word).T
    edge = np.sqrt(trimesh.load(folder / "truth" / "template.ply", process=False).area / 500)
    assert np.median(np.linalg.norm(places[known(folder, f"{name}.{word}")] - images, axis=1)) < edge


def test_the_sets_are_read_by_the_benchmark(written):
    teddy = find_dataset(written / "teddy")
    assert teddy.layout == "vertex lists"
    assert len(teddy.cases) == 1
    assert teddy.cases[0].truth.mirrored is not None
    assert find_dataset(written / "molar").cases[0].truth.mirrored is None
    assert json.loads((written / "vase" / "family.json").read_text())["turns"] == 24
    assert "| vase | closed, genus 0 | yes | all (24 are listed) |" in (written / "README.md").read_text()


def test_same_seed_same_bytes(written, tmp_path):
    main([str(tmp_path), "--kinds", "teddy", *SMALL])
    assert files(tmp_path / "teddy") == files(written / "teddy")
    main([str(tmp_path / "other"), "--kinds", "teddy", "--seed", "1", *SMALL])
    assert files(tmp_path / "other" / "teddy").keys() == files(written / "teddy").keys()
    assert files(tmp_path / "other" / "teddy") != files(written / "teddy")


def test_related_kinds_share_landmarks(tmp_path):
    both = {name: Family(replace(KINDS["teddy"], name=name), 1, 0, (500, 800)) for name in ("person", "teddy")}
    for name, family in both.items():
        family.write(tmp_path / name)
    families.write_related(both, tmp_path)
    (case,) = find_dataset(tmp_path / "related").cases
    landmarks = both["teddy"].landmarks()
    assert case.truth.landmarks
    np.testing.assert_array_equal(case.truth.target, [vertices[0] for vertices in landmarks.values()])
    left, right = (list(landmarks).index(f"hand.{side}") for side in "LR")
    assert case.truth.mirrored[left] == case.truth.target[right]


def test_unrelated_shapes_exist(written):
    pairs = [line.split() for line in (written / "unrelated.txt").read_text().splitlines()]
    assert pairs == []  # none of these belongs to a pair with another of them
    for solid in ("ball", "cube"):
        mesh = trimesh.load(written / "solids" / f"{solid}.ply", process=False)
        assert mesh.is_volume
        assert mesh.euler_number == 2


def test_unknown_kinds_are_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main([str(tmp_path), "--kinds", "unicorn"])
    assert "unicorn" in capsys.readouterr().err


def test_the_field_is_the_smooth_union():
    """Against a plain union of balls, one after another, and with one taken away."""
    rng = np.random.default_rng(0)
    balls = [(rng.uniform(-1, 1, 3), rng.uniform(0.1, 0.4), 0.1) for _ in range(6)]
    rows = [
        Bone("", "", at, at, radius, seam=seam, carved=k == 5).solid() for k, (at, radius, seam) in enumerate(balls)
    ]
    points = rng.uniform(-1.5, 1.5, (2000, 3))
    plain = np.full(len(points), 10.0)
    for k, (at, radius, seam) in enumerate(balls):
        one = np.linalg.norm(points - at, axis=1) - radius
        sign = -1 if k == 5 else 1
        overlap = np.maximum(seam - np.abs(sign * plain - one), 0)
        plain = sign * (np.minimum(sign * plain, one) - overlap**2 / (4 * seam))
    np.testing.assert_allclose(field(points, np.array(rows)), plain, atol=1e-12)


def test_a_flattened_ball_is_an_ellipsoid():
    solid = Bone("", "", (0, 0, 0), (0, 0, 0), 1.0, flat=(0, 1, 0), flatness=0.3).solid()
    vertices, faces = surface(np.array([solid]), 0.03, np.eye(3), np.full(3, 0.3))
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.3, rel=0.02)


def test_a_ball_is_cut_in_half():
    ball = trimesh.creation.icosphere(subdivisions=4)
    vertices, faces = clipped(ball.vertices, ball.faces, 0.013, 0.01)
    half = trimesh.Trimesh(vertices, faces, process=False)
    assert half.euler_number == 1
    assert half.area == pytest.approx(2 * np.pi * (1 - 0.013), rel=0.01)
    rim = half.edges[trimesh.grouping.group_rows(half.edges_sorted, require_count=1)]
    np.testing.assert_allclose(vertices[rim, 1], 0.013)
    assert vertices[:, 1].min() == pytest.approx(0.013)


def test_overlaps_are_seen():
    ball = trimesh.creation.icosphere(subdivisions=3)
    faces = np.vstack([ball.faces, ball.faces + len(ball.vertices)])
    assert overlaps(np.vstack([ball.vertices, ball.vertices + 0.9]), faces)
    assert not overlaps(np.vstack([ball.vertices, ball.vertices + 1.2]), faces)
