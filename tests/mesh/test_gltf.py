"""glTF scenes: nodes in the order of the file, transforms, and what is refused."""

import json

import numpy as np
import pytest
import trimesh

from mobius_match.errors import FormatError, MeshError
from mobius_match.mesh import read_mesh


def read(folder, name, data):
    path = folder / name
    path.write_text(data)
    return read_mesh(path)


def scene_tree():
    """Four placings of one triangle: moved below turned, scaled below a matrix, a mirror, a strip."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], "<f4").tobytes()
    half = 0.5**0.5
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [3, 0, 4, 5]}],
        "nodes": [
            {"children": [1], "rotation": [0, 0, half, half]},
            {"mesh": 0, "translation": [1, 2, 3]},
            {"mesh": 0},
            {"matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 5, 1], "children": [2]},
            {"mesh": 0, "scale": [-1, 1, 1]},
            {"mesh": 1},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}}]},
            {
                "primitives": [
                    {"attributes": {"POSITION": 1}, "mode": 5},
                    {"attributes": {"POSITION": 1}, "mode": 0},
                ]
            },
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}],
        "buffers": [{"byteLength": 48, "uri": "part%20one.bin"}],
    }
    return tree, data


def test_gltf_scene(tmp_path):
    tree, data = scene_tree()
    (tmp_path / "part one.bin").write_bytes(data)
    mesh = read(tmp_path, "a.gltf", json.dumps(tree))
    expected = [
        [[0, 0, 5], [2, 0, 5], [0, 2, 5]],
        [[-2, 1, 3], [-2, 2, 3], [-3, 1, 3]],
        [[0, 0, 0], [0, 1, 0], [-1, 0, 0]],  # mirrored: the corners are exchanged
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[1, 1, 0], [0, 1, 0], [1, 0, 0]],  # the second of a strip
    ]
    np.testing.assert_allclose(mesh.vertices[mesh.faces], expected, atol=1e-12)
    assert mesh.notes == (
        "1 primitive(s) of points or lines left out.",
        "4 parts combined in the order of the scene's nodes; vertices are numbered in that order.",
    )


def test_gltf_scene_against_trimesh(tmp_path):
    """The same surface as another reader's, the parts in the order of the nodes."""
    scene = trimesh.Scene()
    rng = np.random.default_rng(1)
    for k in range(4):
        place = trimesh.transformations.random_rotation_matrix(rng.random(3))
        place[:3, 3] = 5 * rng.random(3)
        scene.add_geometry(trimesh.creation.icosphere(k % 2 + 1), node_name=f"n{k}", transform=place)
    path = tmp_path / "scene.glb"
    scene.export(path)
    mesh = read_mesh(path)
    other = trimesh.load_scene(path).to_mesh()
    key = lambda t: np.round(np.sort(t.mean(axis=1), axis=0), 5)  # noqa: E731
    np.testing.assert_allclose(key(mesh.vertices[mesh.faces]), key(other.vertices[other.faces]), atol=2e-5)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda t: t["buffers"][0].update(uri="../part.bin"), "lies outside the file's folder"),
        (lambda t: t["buffers"][0].update(uri="/etc/hostname"), "lies outside the file's folder"),
        (lambda t: t["buffers"][0].update(uri="absent.bin"), "'absent.bin' cannot be read"),
        (lambda t: t["buffers"][0].update(byteLength=49), "promises 49 bytes in a buffer, but only 48"),
        (lambda t: t["accessors"][1].update(count=10**9), "cannot be read as GLTF .ValueError: cannot reshape"),
        (lambda t: t["accessors"][1].update(count=-1), "expected a number from 0, found -1"),
        (lambda t: t["accessors"][0].pop("bufferView"), "sparse or compressed"),
        (lambda t: t["accessors"][0].update(count=4), "cannot be read as GLTF .ValueError: cannot reshape"),
        (lambda t: t["bufferViews"][0].update(byteStride=4), "byteStride is smaller"),
        (lambda t: t["nodes"][1].update(children=[0]), "node 0 occurs in the tree twice"),
        (lambda t: t["nodes"][3].update(children=[2, 2]), "node 2 occurs in the tree twice"),
        (lambda t: t["nodes"][0].update(mesh=7), "cannot be read as GLTF .IndexError"),
        (lambda t: t["asset"].update(version="1.0"), "only version 2"),
        (lambda t: t.update(extensionsRequired=["KHR_draco_mesh_compression"]), "export without compression"),
        (lambda t: t.update(nodes=3), "cannot be read as GLTF"),
        (lambda t: t["scenes"][0].update(nodes=[]), "0 vertices and 0 faces; a surface needs both"),
    ],
)
def test_gltf_refused(tmp_path, change, text):
    tree, data = scene_tree()
    (tmp_path / "part one.bin").write_bytes(data)
    change(tree)
    with pytest.raises(MeshError, match=text):
        read(tmp_path, "a.gltf", json.dumps(tree))


def test_gltf_bomb_is_refused(tmp_path, monkeypatch):
    """Many nodes that show one mesh: small on disk, without end in memory."""
    tree, data = scene_tree()
    (tmp_path / "part one.bin").write_bytes(data)
    monkeypatch.setattr("mobius_match.mesh.formats.scenes.MAX_TRIANGLES", 10_000)
    tree["nodes"] = [{"mesh": 0}] * 3000
    tree["scenes"] = [{"nodes": list(range(3000))}]
    with pytest.raises(FormatError, match="triangles and vertices in all nodes, but only 10000"):
        read(tmp_path, "a.gltf", json.dumps(tree))
