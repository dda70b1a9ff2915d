"""Pictures of matches, checked by their pixels."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
import trimesh
from matplotlib.image import imread
from scipy import ndimage

from mobius_match import Correspondence, FormatError, MeshError, SettingsError
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_matches, farthest_first
from mobius_match.exporting.rendering import Shape, render
from mobius_match.exporting.scene import colours_of
from mobius_match.mesh import as_mesh, repair

SIZE = (400, 200)


def result_of(source, target, pairs, confidence=None):
    """A result as `match` gives it, without the matching."""
    meshes = [repair(as_mesh(thing)) for thing in (source, target)]
    infos = [{"path": mesh.path and str(mesh.path), "sha256": mesh.sha256} for mesh in meshes]
    pairs = np.array(pairs, np.int64).reshape(-1, 2)
    return Correspondence(
        pairs=pairs,
        confidence=np.ones(len(pairs)) if confidence is None else np.array(confidence, np.float64),
        kind=np.full(len(pairs), "voted"),
        source_info=infos[0],
        target_info=infos[1],
        settings={},
        source=SimpleNamespace(whole_mesh=meshes[0]),
        target=SimpleNamespace(whole_mesh=meshes[1]),
    )


def drawn(result, **options):
    """The picture as (h, w, 3) numbers from 0 to 1."""
    buffer = io.BytesIO()
    draw_matches(result, buffer, **({"size": SIZE} | options))
    buffer.seek(0)
    return imread(buffer)[:, :, :3]


def saturated(picture):
    """Where there are spheres: the only thing that is neither white nor grey."""
    return picture.max(axis=2) - picture.min(axis=2) > 0.25


def halves(picture):
    middle = picture.shape[1] // 2
    return picture[:, :middle], picture[:, middle:]


def spots_from_left_to_right(half):
    """Mean colour of each spot."""
    spots, n = ndimage.label(saturated(half))
    order = np.argsort([np.nonzero(spots == k)[1].mean() for k in range(1, n + 1)])
    return np.array([half[spots == k + 1].mean(axis=0) for k in order])


def ball(**options):
    """A sphere, with a vertex at each end of the three axes."""
    mesh = trimesh.creation.icosphere(subdivisions=3, **options)
    ends = [int(np.argmax(mesh.vertices @ axis)) for axis in np.vstack([np.eye(3), -np.eye(3)])]
    return (np.array(mesh.vertices), np.array(mesh.faces)), ends


@pytest.fixture(scope="module")
def quadruped():
    source = as_mesh(examples.paths("quadruped")[0])
    return result_of(source, source, [(i, i) for i in range(0, len(source.vertices), 100)])


def test_a_surface_matched_to_itself_gives_two_equal_halves(quadruped):
    picture = drawn(quadruped)
    left, right = halves(picture)
    np.testing.assert_array_equal(left, right)
    spheres = saturated(left)
    surface = (left.max(axis=2) < 0.98) & ~spheres
    assert spheres.mean() > 0.02
    assert surface.mean() > 0.1
    assert (left[0] == 1).all() and (left[:, 0] == 1).all()  # on white, with a margin


def test_a_match_has_one_colour_on_both_sides():
    (vertices, faces), _ = ball()
    ends = [int(np.argmax(vertices @ [x, 0, 1])) for x in (-1, 1)]
    picture = drawn(result_of((vertices, faces), (vertices * [1, 1.2, 0.9], faces), np.c_[ends, ends]))
    first, second = (spots_from_left_to_right(half) for half in halves(picture))
    assert len(first) == len(second) == 2
    assert np.abs(first - second).max() < 0.1
    assert np.abs(first[0] - first[1]).max() > 0.3


def test_exchanged_matches_exchange_colours():
    (vertices, faces), _ = ball()
    ends = [int(np.argmax(vertices @ [x, 0, 1])) for x in (-1, 1)]
    left, right = halves(drawn(result_of((vertices, faces), (vertices, faces), [ends, ends[::-1]])))
    # The match on the left of the source is on the right of the target.
    first, second = (spots_from_left_to_right(half) for half in (left, right))
    assert len(first) == len(second) == 2
    assert np.abs(first[0] - second[1]).max() < 0.1
    assert np.abs(first[1] - second[0]).max() < 0.1
    assert np.abs(first[0] - second[0]).max() > 0.3


def test_hidden_matches_are_not_drawn():
    mesh, (_, _, front, _, _, back) = ball()
    both = drawn(result_of(mesh, mesh, [(front, front), (back, back)]))
    for half in halves(both):
        assert ndimage.label(saturated(half))[1] == 1
    # From any viewpoint only one end of the match is visible.
    left, right = halves(drawn(result_of(mesh, mesh, [(front, back)])))
    assert sorted([saturated(left).any(), saturated(right).any()]) == [False, True]


def test_a_sphere_is_cut_by_the_surface_in_front_of_it():
    plate = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-0.1, 0, 0)], float)
    bar = np.array([(0, -0.9, 1), (0.5, -0.9, 1), (0.5, 0.9, 1), (0, 0.9, 1)])
    fan = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    both = Shape(
        np.vstack([plate, bar]),
        np.array([*fan, (5, 6, 7), (5, 7, 8)]),
        np.tile([0.0, 0, 1], (9, 1)),
        np.array([4]),
    )
    alone = replace(both, faces=both.faces[:4])
    red = np.array([[1, 0, 0]], np.float32)
    whole, cut = (saturated(render(shape, 100, (220, 220), np.array([0.3]), red)) for shape in (alone, both))
    # The bar begins at x = 0, in the middle of the picture; the sphere reaches from -0.4 to 0.2.
    assert whole.sum() == pytest.approx(np.pi * 30**2, rel=0.02)
    assert (cut != whole)[:, :110].sum() < 8  # at its edge
    assert whole[:, 110:129].any() and not cut[:, 110:].any()


def test_the_radius_grows_with_confidence():
    mesh, (_, _, front, *_) = ball()
    areas = [saturated(drawn(result_of(mesh, mesh, [(front, front)], [c]), size=(800, 400))).sum() for c in (1, 0.5, 0)]
    radii = np.sqrt(areas) / np.sqrt(areas[0])
    np.testing.assert_allclose(radii, [1, 0.7, 0.4], atol=0.05)


@pytest.mark.parametrize("most", [0, 1, 3, 6])
def test_the_number_of_matches_is_limited(most):
    (vertices, faces), _ = ball()
    chosen = [int(np.argmax(vertices @ [np.sin(a), np.cos(a), 1.5])) for a in np.arange(6) * np.pi / 3]
    picture = drawn(result_of((vertices, faces), (vertices, faces), np.c_[chosen, chosen]), most=most)
    for half in halves(picture):
        assert ndimage.label(saturated(half))[1] == most


def test_the_matches_drawn_are_far_from_each_other():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [10, 0, 0], [9, 0, 0], [5, 0, 0], [4, 0, 0]])
    assert farthest_first(line, 3).tolist() == [0, 2, 4]
    assert farthest_first(line, 9).tolist() == [0, 1, 2, 3, 4, 5]
    assert farthest_first(np.zeros((4, 3)), 2).tolist() == [0, 1]
    assert farthest_first(line, 0).tolist() == farthest_first(line[:0], 5).tolist() == []


def test_matches_are_vertices_of_the_users_file():
    (vertices, faces), (_, _, front, *_) = ball()
    unused = np.vstack([np.full((7, 3), 0.5), vertices])
    plain = drawn(result_of((vertices, faces), (vertices, faces), [(front, front)]))
    shifted = drawn(result_of((unused, faces + 7), (vertices, faces), [(front + 7, front)]))
    np.testing.assert_array_equal(plain, shifted)


def test_files_with_z_upward_look_like_files_with_y_upward(quadruped):
    mesh = quadruped.source.whole_mesh
    turned = (mesh.vertices[:, [0, 2, 1]] * [1, -1, 1], mesh.faces)
    difference = np.abs(drawn(quadruped) - drawn(result_of(turned, turned, quadruped.pairs)))
    assert difference.max(axis=2).mean() < 1e-3


def test_a_flat_sheet():
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(11.0), np.arange(11.0)))
    corner = np.arange(110).reshape(10, 11)[:, :10].ravel()
    faces = np.vstack([np.c_[corner, corner + 1, corner + 12], np.c_[corner, corner + 12, corner + 11]])
    for axes in ([x, y, 0 * x], [x, 0 * x, y], [0 * x, x, y]):
        vertices = np.stack(axes, axis=1)
        left, right = halves(drawn(result_of((vertices, faces), (vertices, faces[:, ::-1]), [(60, 60), (24, 24)])))
        for half in (left, right):
            assert (half.min(axis=2) < 0.98).mean() > 0.2  # not seen edge-on
            assert ndimage.label(saturated(half))[1] == 2


@pytest.mark.parametrize("scale", [1e-150, 1e150])
def test_units_do_not_matter(scale):
    (vertices, faces), (_, _, front, *_) = ball()
    plain = drawn(result_of((vertices, faces), (vertices, faces), [(front, front)]))
    other = drawn(result_of((vertices * scale, faces), (vertices, faces), [(front, front)]))
    assert np.abs(plain - other).max() < 0.1


def test_the_same_result_gives_the_same_bytes_whatever_the_users_matplotlib_settings(quadruped, tmp_path):
    draw_matches(quadruped, tmp_path / "a.png", size=SIZE, title="A quadruped, $x_1$")
    with matplotlib.rc_context(
        {"savefig.bbox": "tight", "savefig.dpi": 37, "figure.dpi": 50, "font.size": 30, "image.origin": "lower"}
    ):
        draw_matches(quadruped, str(tmp_path / "b.PNG"), size=SIZE, title="A quadruped, $x_1$")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.PNG").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.PNG"]


@pytest.mark.parametrize("size", [(64, 64), (401, 201), (1163, 70)])
def test_size(quadruped, size):
    assert drawn(quadruped, size=size).shape == (size[1], size[0], 3)
    assert drawn(quadruped, size=size, title="x").shape == (size[1], size[0], 3)


def test_title_stands_above_the_picture(quadruped):
    plain, titled = drawn(quadruped, size=(400, 300)), drawn(quadruped, size=(400, 300), title="Title")
    ink = (titled[:21] < 0.9).any(axis=2)
    assert ink.any() and not (plain[:21] < 0.9).any()
    columns = np.flatnonzero(ink.any(axis=0))
    assert abs(columns.mean() - 200) < 10
    assert not (titled[20] < 0.9).any()


def test_a_loaded_result_reads_its_meshes_again(tmp_path):
    mesh, (_, _, front, *_) = ball()
    file = tmp_path / "ball.off"
    trimesh.Trimesh(*mesh, process=False).export(file)
    result = result_of(file, file, [(front, front)])
    result.save(tmp_path / "result.json")
    loaded = Correspondence.load(tmp_path / "result.json")
    assert loaded.source is None
    np.testing.assert_array_equal(drawn(result), drawn(loaded))

    wrong = replace(loaded, pairs=np.array([[front, 5000]]))
    with pytest.raises(MeshError, match=r"ball\.off: has no vertex 5000"):
        drawn(wrong)
    file.write_text(file.read_text() + "\n")
    with pytest.raises(MeshError, match=r"ball\.off: the file has changed"):
        drawn(loaded)
    file.unlink()
    with pytest.raises(FormatError, match=r"ball\.off: no such file"):
        drawn(loaded)


def test_a_loaded_result_of_arrays_is_refused():
    mesh, (front, *_) = ball()
    with pytest.raises(MeshError, match="given as arrays"):
        drawn(replace(result_of(mesh, mesh, [(front, front)]), source=None))


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.pdf", {}, r"a\.pdf: .*\.png"),
        ("png", {}, r"png: .*\.png"),
        ("a.png", {"size": (10, 800)}, "`size` is .*64 to 4096"),
        ("a.png", {"size": (800.5, 800)}, "size"),
        ("a.png", {"size": 800}, "size"),
        ("a.png", {"most": -1}, "`most` is -1"),
        ("a.png", {"most": None}, "`most` is None"),
    ],
)
def test_settings_out_of_range(quadruped, tmp_path, name, options, message):
    with pytest.raises(SettingsError, match=message):
        draw_matches(quadruped, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_colours_change_smoothly_and_differ_from_grey():
    rng = np.random.default_rng(0)
    line = np.c_[np.linspace(-3, 3, 60), 0.01 * rng.normal(size=(60, 2))]
    level = colours_of(line) @ [0.2126, 0.7152, 0.0722]
    chroma = np.ptp(colours_of(line), axis=1)
    assert chroma.min() > 0.3
    assert np.ptp(level) > 0.3
    neighbours = np.linalg.norm(np.diff(colours_of(np.c_[line[:, 0], np.zeros((60, 2))]), axis=0), axis=1)
    assert neighbours.max() < 0.15 < 0.9 < np.linalg.norm(colours_of(line)[0] - colours_of(line)[-1])
    assert colours_of(np.zeros((0, 3))).shape == (0, 3)
    assert np.isfinite(colours_of(np.zeros((1, 3)))).all()


def test_no_global_state_of_matplotlib():
    """Neither pyplot nor a display: a server or a thread can draw."""
    import subprocess
    import sys

    code = (
        "import sys, numpy as np, mobius_match.exporting.figures as f\n"
        "assert 'matplotlib' not in sys.modules\n"
        "f._png(np.ones((64, 64, 3)), (64, 64), 'x')\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parent)
