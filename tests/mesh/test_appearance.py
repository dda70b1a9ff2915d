"""Colours, textures and labels in mesh files: written, read again, and as other programs write them."""

import io

import numpy as np
import pytest
import trimesh
from PIL import Image

import mobius_match as mm
from mobius_match.mesh.appearance import read_appearance
from mobius_match.mesh.writing import mesh_files, split_seams
from tests.shapes import lump, tube


@pytest.fixture
def dressed():
    """A lump with colours, a texture that is torn between all faces, and labels."""
    vertices, faces = lump(1)
    rng = np.random.default_rng(0)
    picture = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (8, 8, 3), dtype=np.uint8)).save(picture, "PNG")
    vertices = vertices.astype(np.float32).astype(float)
    colors = rng.integers(0, 256, (len(vertices), 4), dtype=np.uint8)
    uv = rng.random((len(faces), 3, 2)).astype(np.float32).astype(float)
    return vertices, faces, colors, uv, picture.getvalue(), rng.integers(-1, 5, len(faces))


def saved(folder, name, *arrays, **others):
    for path, content in mesh_files(folder / name, *arrays, **others).items():
        path.write_bytes(content)
    return folder / name


@pytest.mark.parametrize("kind", ["ply", "obj", "glb"])
def test_colours_come_back(dressed, kind, tmp_path):
    vertices, faces, colors, *_ = dressed
    if kind == "obj":
        colors[:, 3] = 255  # the format knows no other
    found = read_appearance(saved(tmp_path, f"a.{kind}", vertices, faces, colors=colors))
    np.testing.assert_array_equal(found.mesh.vertices, vertices)
    np.testing.assert_array_equal(found.mesh.faces, faces)
    np.testing.assert_array_equal(found.colors, colors)
    assert (found.uv, found.image, found.labels) == (None, None, None)


@pytest.mark.parametrize("kind", ["ply", "obj", "glb"])
def test_textures_come_back_with_the_vertices_in_their_places(dressed, kind, tmp_path):
    vertices, faces, _, uv, image, _ = dressed
    path = saved(tmp_path, f"a.{kind}", vertices, faces, uv=uv, image=image)
    found = read_appearance(path)
    np.testing.assert_array_equal(found.mesh.vertices[: len(vertices)], vertices)
    assert len(found.mesh.vertices) == (3 * len(faces) if kind == "glb" else len(vertices))
    np.testing.assert_array_equal(found.mesh.vertices[found.mesh.faces], vertices[faces])
    np.testing.assert_allclose(found.uv, uv, atol=1e-6)
    pictures = [np.asarray(Image.open(io.BytesIO(one)).convert("RGB")) for one in (found.image, image)]
    np.testing.assert_array_equal(*pictures)


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_vertices_keep_their_own_colours_beside_a_texture(dressed, kind, tmp_path):
    vertices, faces, colors, uv, image, _ = dressed
    colors[:, 3] = 255
    found = read_appearance(saved(tmp_path, f"a.{kind}", vertices, faces, colors=colors, uv=uv, image=image))
    np.testing.assert_array_equal(found.colors, colors)
    np.testing.assert_allclose(found.uv, uv, atol=1e-6)


def test_labels_and_values_come_back_from_ply(dressed, tmp_path):
    vertices, faces, colors, uv, image, labels = dressed
    values = {"height": vertices[:, 2], "a vector": vertices, "part": np.arange(len(vertices))}
    kept = {"colors": colors, "uv": uv, "image": image, "labels": labels}
    path = saved(tmp_path, "a.ply", vertices, faces, **kept, values=values)
    found = read_appearance(path)
    np.testing.assert_array_equal(found.labels, labels)
    np.testing.assert_allclose(found.uv, uv, atol=1e-6)
    rows = trimesh.load(path, process=False, fix_texture=False).metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(rows["height"], vertices[:, 2])
    np.testing.assert_array_equal(rows["a_vector_1"], vertices[:, 1])
    np.testing.assert_array_equal(rows["part"], np.arange(len(vertices)))


def test_places_that_single_precision_cannot_hold_are_kept(tmp_path):
    vertices, faces = tube(7, 3)
    for kind in ("ply", "obj"):
        np.testing.assert_array_equal(
            mm.read_mesh(saved(tmp_path, f"a.{kind}", vertices + 1e5, faces)).vertices, vertices + 1e5
        )


def test_several_materials_and_polygons_are_told_apart(tmp_path):
    """Trimesh sorts the faces by material and leaves out vertices; all must come back in the order of the file."""
    lines = ["mtllib a.mtl", "v 9 9 9", *(f"v {x} {y} 0" for y in range(4) for x in range(4))]
    lines += [f"vt {x / 4} {y / 4}" for y in range(4) for x in range(4)]
    for k, (x, y) in enumerate((x, y) for y in range(3) for x in range(3)):
        corner = [1 + y * 4 + x, 2 + y * 4 + x, 6 + y * 4 + x, 5 + y * 4 + x]
        words = [f"{number + 1}/{number}" for number in corner]
        faces = [words] if k == 4 else [words[:3], [words[0], *words[2:]]]
        lines += [f"usemtl {'ab'[k % 2]}", *("f " + " ".join(face) for face in faces)]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd a.png\n")
    Image.new("RGB", (4, 4), (10, 20, 30)).save(tmp_path / "a.png")
    found = read_appearance(tmp_path / "a.obj")
    np.testing.assert_allclose(found.uv, found.mesh.vertices[found.mesh.faces][..., :2] / 4, atol=1e-9)
    np.testing.assert_array_equal(found.colors[1:], [[10, 20, 30, 255]] * 16)
    assert found.mesh.n_file_faces == 17


def test_seams_get_copies_behind_all_vertices():
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    uv = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [0.5, 0.5], [0, 1]]])
    origin, split, at = split_seams(5, faces, uv)
    np.testing.assert_array_equal(origin, [0, 1, 2, 3, 4, 2])
    np.testing.assert_array_equal(at[split], uv)
    np.testing.assert_array_equal(origin[split], faces)


@pytest.mark.parametrize(
    ("name", "others", "message"),
    [
        ("a.off", {}, "written as .ply, .glb, .obj"),
        ("a.obj", {"labels": np.zeros(320, int)}, "can be written to .ply files"),
        ("a.glb", {"values": {"a": np.zeros(162)}}, "can be written to .ply files"),
        ("a.glb", {"colors": np.zeros((162, 4), np.uint8), "uv": np.zeros((320, 3, 2))}, "not both"),
    ],
)
def test_what_a_format_cannot_hold_is_refused(name, others, message, tmp_path):
    with pytest.raises(mm.SettingsError, match=message):
        mesh_files(tmp_path / name, *lump(2), **others)


def test_a_file_without_anything_else(tmp_path):
    found = read_appearance(saved(tmp_path, "a.ply", *lump(1)))
    assert (found.colors, found.uv, found.image, found.labels) == (None,) * 4


@pytest.mark.parametrize("polygons", [["3 0 1 2 5", "3 0 2 3 6"], ["4 0 1 2 3 5"]])
def test_ply_as_text(tmp_path, polygons):
    head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz")]
    head += [*(f"property uchar {name}" for name in ("red", "green", "blue")), f"element face {len(polygons)}"]
    head += ["property list uchar int vertex_indices", "property int label", "end_header"]
    rows = ["0 0 0 1 2 3", "1 0 0 4 5 6", "1 1 0 7 8 9", "0 1 0 10 11 12", *polygons]
    (tmp_path / "a.ply").write_text("\n".join([*head, *rows]) + "\n")
    found = read_appearance(tmp_path / "a.ply")
    np.testing.assert_array_equal(found.colors[:, :3], np.arange(1, 13).reshape(4, 3))
    assert found.labels.tolist() == [5, 6][: len(polygons)]
    np.testing.assert_array_equal(found.mesh.faces, [[0, 1, 2], [0, 2, 3]])
