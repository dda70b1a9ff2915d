"""Interpolation between shapes: bends and coils keep edge lengths, rigid motions stay rigid, the file is valid glTF."""

import io
import json
import struct
from itertools import pairwise

import numpy as np
import pytest
import trimesh

import mobius_match as mm
from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import Mesh
from mobius_match.mesh.topology import edges_of
from mobius_match.results.surface_map import SurfaceMap
from mobius_match.transfer.animation import animated_glb
from mobius_match.transfer.morph import interpolate, morph
from tests.shapes import lump, rotation, tube

TIMES = np.linspace(0, 1, 11)


def coiled(vertices, turns, pitch=0.0):
    """A long tube along z, wound around an axis."""
    length = vertices[:, 2].max()
    angle, radius = vertices[:, 2] / length * 2 * np.pi * turns, length / (2 * np.pi * turns) + vertices[:, 0]
    return np.stack([radius * np.cos(angle), vertices[:, 1] + pitch * vertices[:, 2], radius * np.sin(angle)], axis=1)


def lengths(shapes, faces):
    first, second = edges_of(faces).T
    return np.linalg.norm(shapes[:, first] - shapes[:, second], axis=2)


def excess(shapes, faces):
    """Largest relative shortening below and lengthening above an edge's lengths at both ends."""
    found = lengths(shapes, faces)
    low, high = np.sort(found[[0, -1]], axis=0)
    return 1 - (found / low).min(), (found / high).max() - 1


@pytest.mark.parametrize(("turns", "pitch", "most"), [(0.5, 0.0, 0.02), (0.9, 0.0, 0.03), (2.5, 0.4, 0.1)])
def test_a_bent_tube_keeps_its_lengths_where_a_straight_line_collapses(turns, pitch, most):
    vertices, faces = tube(24, 60, 0.2, 8.0)
    end = coiled(vertices, turns, pitch) @ rotation(1) + 5
    shapes = interpolate(vertices, end, faces, TIMES)
    np.testing.assert_array_equal(shapes[0], vertices)
    np.testing.assert_array_equal(shapes[-1], end)
    assert max(excess(shapes, faces)) < most
    straight = vertices + TIMES[:, None, None] * (end - vertices)
    assert excess(straight, faces)[0] > 0.4
    # Nothing jumps: no step is much longer than the mean of a vertex's steps.
    steps = np.linalg.norm(np.diff(shapes, axis=0), axis=2)
    assert (steps.max(axis=0) < 2.5 * steps.mean(axis=0) + 0.05).all()


def test_the_ends_are_approached_without_a_jump():
    vertices, faces = tube(16, 30, 0.3, 6.0)
    end = coiled(vertices, 0.7) @ rotation(2) - 3
    near = interpolate(vertices, end, faces, np.array([1e-7, 1 - 1e-7]))
    assert np.abs(near - [vertices, end]).max() < 1e-5


def test_a_rigid_motion_stays_rigid_and_its_centre_goes_straight():
    vertices, faces = lump(2)
    end = vertices @ rotation(3).T + [1.0, 2.0, 3.0]
    shapes = interpolate(vertices, end, faces, TIMES)
    np.testing.assert_allclose(lengths(shapes, faces), lengths(shapes[:1], faces).repeat(11, axis=0), rtol=1e-9)
    solid = trimesh.Trimesh(vertices, faces, process=False)
    centres = np.einsum("m,tmcd->td", solid.area_faces / solid.area / 3, shapes[:, faces])
    np.testing.assert_allclose(centres, centres[0] + TIMES[:, None] * (centres[-1] - centres[0]), atol=1e-9)
    # The rotation from one time to the next is always the same.
    steps = [
        trimesh.registration.procrustes(before, after, scale=False)[0][:3, :3] for before, after in pairwise(shapes)
    ]
    np.testing.assert_allclose(steps, [steps[0]] * 10, atol=1e-9)


def test_a_shift_and_a_scale_are_linear():
    vertices, faces = lump(2)
    end = 2 * vertices + [5.0, 0.0, 0.0]
    straight = vertices + TIMES[:, None, None] * (end - vertices)
    np.testing.assert_allclose(interpolate(vertices, end, faces, TIMES), straight, atol=1e-9)


@pytest.fixture(scope="module")
def surface_map():
    """The map from a tube to the same tube bent; the last rings have no counterpart."""
    vertices, faces = tube(16, 30, 0.3, 6.0)
    corner = np.empty(len(vertices), np.int64)
    corner[faces.ravel()] = np.arange(faces.size)
    points = SurfacePoints(corner // 3, faces[corner // 3], np.eye(3)[corner % 3])
    found = vertices[:, 2] < 5.5
    return SurfaceMap(Mesh(vertices, faces), Mesh(coiled(vertices, 0.5), faces), points, points, found, found)


def test_vertices_without_a_counterpart_follow_their_neighbours(surface_map):
    shapes = morph(surface_map, TIMES)
    found = surface_map.source_mapped
    np.testing.assert_array_equal(shapes[0], surface_map.source.vertices)
    np.testing.assert_allclose(shapes[-1][found], surface_map.target.vertices[found], atol=1e-12)
    assert np.isfinite(shapes).all()
    assert lengths(shapes, surface_map.source.faces).max() < 3 * lengths(shapes[:1], surface_map.source.faces).max()
    np.testing.assert_array_equal(morph(surface_map, [0.3]), morph(surface_map, [0.3, 0.6])[:1])


@pytest.mark.parametrize("times", [[0.5, 1.5], [-0.1], [np.nan]])
def test_times_outside_are_refused(surface_map, times):
    with pytest.raises(mm.SettingsError, match="`times` has a time outside 0 to 1"):
        morph(surface_map, times)


def test_a_map_without_counterparts_is_refused(surface_map):
    nothing = SurfaceMap(
        surface_map.source,
        surface_map.target,
        surface_map.target_points,
        surface_map.source_points,
        np.zeros_like(surface_map.source_mapped),
        surface_map.target_mapped,
    )
    with pytest.raises(mm.MeshError, match="no vertex has a counterpart"):
        morph(nothing, [0.5])


def test_the_animation_is_valid_gltf():
    """The rules of the glTF 2.0 specification for the parts that are used, and what another reader finds."""
    vertices, faces = tube(8, 6)
    shapes = interpolate(vertices, coiled(vertices, 0.3), faces, np.linspace(0, 1, 4))
    content = animated_glb(shapes, faces, 1.5)
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    size, kind = struct.unpack_from("<I4s", content, 12)
    assert (kind, size % 4) == (b"JSON", 0)
    tree = json.loads(content[20 : 20 + size])
    rest, kind = struct.unpack_from("<I4s", content, 20 + size)
    binary = content[28 + size :]
    assert (kind, rest % 4, rest) == (b"BIN\0", 0, len(binary))
    assert tree["buffers"] == [{"byteLength": len(binary)}]

    def array(number):
        accessor = tree["accessors"][number]
        view = tree["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        dtype = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0
        assert accessor["count"] * width * 4 == view["byteLength"]
        assert view["byteOffset"] + view["byteLength"] <= len(binary)
        rows = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        if "min" in accessor:
            np.testing.assert_array_equal(np.float32(accessor["min"]), rows.min(axis=0))
            np.testing.assert_array_equal(np.float32(accessor["max"]), rows.max(axis=0))
        return rows, accessor, view

    views = sorted((view["byteOffset"], view["byteLength"]) for view in tree["bufferViews"])
    ends = np.cumsum([size for _, size in views])
    np.testing.assert_array_equal([start for start, _ in views], [0, *ends[:-1]])  # none overlaps another
    assert ends[-1] == len(binary)
    (primitive,) = tree["meshes"][0]["primitives"]
    indices, _, view = array(primitive["indices"])
    assert view["target"] == 34963
    np.testing.assert_array_equal(indices.reshape(-1, 3), faces)
    base, accessor, view = array(primitive["attributes"]["POSITION"])
    assert {"min", "max"} <= accessor.keys()
    assert view["target"] == 34962
    np.testing.assert_array_equal(base, shapes[0].astype(np.float32))
    normals = array(primitive["attributes"]["NORMAL"])[0]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
    assert len(primitive["targets"]) == 3 == len(tree["meshes"][0]["weights"])
    for target, shape in zip(primitive["targets"], shapes[1:], strict=True):
        moved, accessor, _ = array(target["POSITION"])
        assert {"min", "max"} <= accessor.keys()
        np.testing.assert_allclose(base + moved, shape, atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(normals + array(target["NORMAL"])[0], axis=1), 1, atol=1e-6)
    (animation,) = tree["animations"]
    (sampler,), (channel,) = animation["samplers"], animation["channels"]
    assert channel == {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    times, accessor, view = array(sampler["input"])
    assert {"min", "max"} <= accessor.keys()
    assert "target" not in view
    np.testing.assert_allclose(times.ravel(), [0, 0.5, 1, 1.5])
    weights = array(sampler["output"])[0].reshape(4, 3)
    np.testing.assert_array_equal(weights, np.eye(4)[:, 1:])
    loaded = trimesh.load(io.BytesIO(content), file_type="glb", process=False, force="mesh")
    np.testing.assert_array_equal(loaded.vertices, shapes[0].astype(np.float32))
    np.testing.assert_array_equal(loaded.faces, faces)
