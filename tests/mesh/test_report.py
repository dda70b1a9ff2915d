"""What describe says about shapes of known measure."""

import json

import numpy as np
import pytest
import trimesh

from mobius_match.mesh import Mesh, describe


def test_a_unit_cube():
    box = trimesh.creation.box().subdivide()
    info = json.loads(json.dumps(describe(Mesh(box.vertices, box.faces, name="cube"))))
    quality = info.pop("quality")
    assert len(info.pop("sha256")) == 64
    assert info.pop("area") == pytest.approx(6)
    lengths = np.linalg.norm(np.diff(box.vertices[box.edges_unique], axis=1), axis=2)
    assert info.pop("edge_length") == pytest.approx({"min": 0.5, "mean": lengths.mean(), "max": 0.5**0.5})
    assert info == {
        "name": "cube",
        "path": None,
        "vertices": 26,
        "faces": 48,
        "file_faces": 48,
        "unused_vertices": 0,
        "duplicate_vertices": 0,
        "degenerate_faces": 0,
        "duplicate_faces": 0,
        "components": 1,
        "nonmanifold_edges": 0,
        "nonmanifold_edge_places": [],
        "nonmanifold_vertices": 0,
        "nonmanifold_vertex_places": [],
        "consistently_oriented": True,
        "euler_characteristic": 2,
        "genus": 0,
        "handle_places": [],
        "boundary_loops": {"count": 0, "lengths": []},
        "closed": True,
        "orientable": True,
        "bounding_box": {"min": [-0.5] * 3, "max": [0.5] * 3},
        "pieces": [
            {
                "vertices": 26,
                "faces": 48,
                "area": pytest.approx(6),
                "closed": True,
                "cavity": False,
                "first_vertex": 0,
                "names": [],
            }
        ],
        "unreached_vertices": [],
        "notes": [],
        "usable": True,
        "reason": None,
    }
    assert quality["smallest_angle_degrees"] == pytest.approx(dict.fromkeys(("p0", "p1", "p5", "p50", "p95"), 45))
    assert quality["negative_cotangent_fraction"] == 0


def test_faults_are_counted(shapes):
    vertices, faces = shapes.sphere()
    vertices = np.concatenate([vertices, vertices[:3], [[5.0, 5, 5]]])  # three twins and one more, all unused
    turned = faces.copy()
    turned[:2] = turned[:2, ::-1]
    info = describe(Mesh(vertices, np.concatenate([turned, [[3, 3, 4], [0, 1, 0]], faces[8:9]])))
    assert info["unused_vertices"] == 4 and info["duplicate_vertices"] == 3
    assert info["degenerate_faces"] == 2 and info["duplicate_faces"] == 1
    assert info["nonmanifold_edges"] == 3 and not info["consistently_oriented"]
    assert info["genus"] == 0 and info["closed"] and info["usable"]
    assert len(info["notes"]) == 4
    assert info["unreached_vertices"] == [162, 163, 164, 165]


def test_boundary_and_pieces(shapes):
    info = describe(Mesh(*shapes.cylinder()))
    assert info["boundary_loops"] == {"count": 2, "lengths": [10, 10]} and not info["closed"] and info["usable"]
    info = describe(Mesh(*shapes.bowtie()))
    assert info["components"] == 2 and info["nonmanifold_vertices"] == 1 and info["usable"]
    assert [piece["faces"] for piece in info["pieces"]] == [72, 72]
    info = describe(Mesh(*shapes.moebius()))
    assert info["orientable"] and info["genus"] == 0 and info["usable"] and not info["consistently_oriented"]
    info = describe(Mesh(*shapes.torus()))
    assert info["genus"] == 1 and info["usable"]


def test_negative_cotangents(shapes):
    """Two flat triangles with angles of 150 degrees across their common edge."""
    h = np.tan(np.radians(15)) / 2
    info = describe(Mesh([[0, 0, 0], [1, 0, 0], [0.5, h, 0], [0.5, -h, 0]], [[0, 1, 2], [1, 0, 3]]))
    assert info["quality"]["negative_cotangent_fraction"] == pytest.approx(1 / 5)
    assert info["quality"]["smallest_angle_degrees"]["p50"] == pytest.approx(15)
    assert info["area"] == pytest.approx(h)


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_extreme_units_stay_json(shapes, scale):
    vertices, faces = shapes.sphere()
    plain, info = describe(Mesh(vertices, faces)), describe(Mesh(vertices * scale, faces))
    angles = "smallest_angle_degrees"
    assert info["quality"][angles] == pytest.approx(plain["quality"][angles]) and info["usable"]
    assert info["edge_length"]["max"] == pytest.approx(plain["edge_length"]["max"] * scale)
    assert info["area"] == (None if scale > 1 else 0)
    json.dumps(info, allow_nan=False)


def test_nothing_to_describe():
    for mesh in (Mesh(np.zeros((0, 3)), []), Mesh(np.zeros((4, 3)), []), Mesh(np.zeros((4, 3)), [[1, 1, 1]])):
        info = json.loads(json.dumps(describe(mesh), allow_nan=False))
        assert not info["usable"] and info["quality"] is None and info["edge_length"]["max"] is None
        assert "too few" in info["reason"]


def test_handles_have_their_place_and_length(shapes):
    """The thin circle of a torus, of 8 edges in a circle of radius 1; in the numbers of a file with unused vertices."""
    vertices, faces = shapes.torus(shift=1.0)
    info = json.loads(json.dumps(describe(Mesh(np.concatenate([np.zeros((5, 3)), 100 * vertices]), faces + 5))))
    (handle,) = info["handle_places"]
    assert sorted(handle) == ["length", "place", "vertices"]
    assert handle["length"] == pytest.approx(1600 * np.sin(np.pi / 8))
    loop = np.array(handle["vertices"]) - 5
    assert len(loop) == 8
    assert np.linalg.norm(np.array(handle["place"]) - [100, 0, 0]) == pytest.approx(200)
    np.testing.assert_allclose(handle["place"], 100 * vertices[loop].mean(axis=0), atol=1e-9)
