"""Every format: the user's numbers are kept, whatever the dialect."""

import struct
import subprocess
import sys

import meshio
import numpy as np
import pytest
import trimesh

from mobius_match.errors import FormatError
from mobius_match.mesh import Mesh, read_mesh, repair, require_matchable

NAMES = [
    "plain.off",
    "one_line.off",
    "colours.off",
    "normals.off",
    "plain.obj",
    "seams.obj",
    "text.ply",
    "little.ply",
    "big.ply",
    "text.stl",
    "binary.stl",
    "text.vtk",
    "binary.vtk",
    "offsets.vtk",
    "ascii.vtp",
    "binary.vtp",
    "zlib.vtp",
    "raw.vtp",
    "text.vtu",
    "binary.vtu",
    "zlib.vtu",
    "lib.glb",
    "hand.gltf",
]


def read(folder, name, data):
    path = folder / name
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return read_mesh(path)


def test_the_list_above_is_complete(files):
    assert list(files) == NAMES


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith("stl")])
def test_numbers_are_kept(tmp_path, files, numbered, name):
    v, f = numbered
    mesh = read(tmp_path, name, files[name])
    if name.endswith(("glb", "gltf")):  # single precision by definition
        v = v.astype(np.float32)
    digits = 1e-11 if name == "text.vtu" else 0  # as many as meshio writes
    np.testing.assert_allclose(mesh.vertices, v, rtol=0, atol=digits)
    np.testing.assert_array_equal(mesh.faces, f)
    assert (mesh.n_file_vertices, mesh.n_file_faces) == (len(v), len(f))
    np.testing.assert_array_equal(mesh.face_ids, np.arange(len(f)))
    assert mesh.name == name and mesh.path == tmp_path / name and mesh.notes == ()
    fixed = repair(mesh)
    np.testing.assert_array_equal(fixed.vertex_ids, np.unique(f))
    assert fixed.notes == ("2 unused vertices dropped.",)
    require_matchable(fixed)


@pytest.mark.parametrize("name", ["text.stl", "binary.stl"])
def test_stl_is_welded_in_order_of_appearance(tmp_path, files, numbered, name):
    v, f = numbered
    mesh = read(tmp_path, name, files[name])
    _, first = np.unique(f.ravel(), return_index=True)
    order = f.ravel()[np.sort(first)]
    expected = v if name == "text.stl" else v.astype(np.float32)
    np.testing.assert_array_equal(mesh.vertices, expected[order])
    np.testing.assert_array_equal(order[mesh.faces], f)
    assert mesh.notes == (
        "STL has no vertex numbers: 240 corners merged into 42 vertices by their coordinates, "
        "numbered in order of appearance.",
    )


def test_the_hash_is_that_of_the_file(tmp_path, files):
    import hashlib

    mesh = read(tmp_path, "a.off", files["plain.off"])
    assert mesh.sha256 == hashlib.sha256(files["plain.off"]).hexdigest()


@pytest.mark.parametrize("ending", ["off", "ply", "obj", "glb"])
def test_reads_what_trimesh_writes(tmp_path, ending):
    ball = trimesh.creation.icosphere(2)
    path = tmp_path / f"ball.{ending.upper()}"
    ball.export(path, file_type=ending)
    mesh = read_mesh(path)
    np.testing.assert_allclose(mesh.vertices, ball.vertices, atol=1e-7)
    np.testing.assert_array_equal(mesh.faces, ball.faces)


# A square, a triangle and a pentagon over the vertices 0 to 6.
POINTS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [3, 1, 1], [2, 2, 0]]
POLYGONS = [[0, 1, 2, 3], [1, 4, 2], [4, 5, 6, 2, 1]]
FANS = [[0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 5, 6], [4, 6, 2], [4, 2, 1]]


def lines(rows):
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


def polygon_files():
    cells = [[len(p), *p] for p in POLYGONS]
    header = "element vertex 7\nproperty float x\nproperty float y\nproperty float z\nelement face 3\n"
    header += "property list uchar uint vertex_index\nend_header\n"
    body = np.array(POINTS, ">f4").tobytes()
    body += b"".join(struct.pack(f">B{len(p)}I", len(p), *p) for p in POLYGONS)
    flat, ends = [corner for polygon in POLYGONS for corner in polygon], np.cumsum([len(p) for p in POLYGONS])
    xml = (
        '<VTKFile type="{0}"><{0}><Piece NumberOfPoints="7" NumberOf{1}="3">'
        '<Points><DataArray type="Float32" NumberOfComponents="3">'
        f"{lines(POINTS)}</DataArray></Points><{{1}}>"
        f'<DataArray type="Int32" Name="connectivity">{lines([flat])}</DataArray>'
        f'<DataArray type="Int32" Name="offsets">{lines([ends])}</DataArray>'
        '<DataArray type="UInt8" Name="types">9 5 7</DataArray></{1}></Piece></{0}></VTKFile>'
    )
    vtk = f"# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 7 float\n{lines(POINTS)}"
    return {
        "a.off": f"OFF\n7 3 0\n{lines(POINTS)}{lines(cells)}",
        "a.obj": "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS) + "f 1 2 3 4\nf -6 -3 -5\nf 5 \\\n 6 7 3 2\n",
        "a.ply": f"ply\nformat ascii 1.0\n{header}{lines(POINTS)}{lines(cells)}",
        "b.ply": f"ply\nformat binary_big_endian 1.0\n{header}".encode() + body,
        "a.vtk": f"{vtk}CELLS 3 15\n{lines(cells)}CELL_TYPES 3\n9 5 7\n",
        "a.vtp": xml.format("PolyData", "Polys"),
        "a.vtu": xml.format("UnstructuredGrid", "Cells"),
    }


@pytest.mark.parametrize("name", polygon_files())
def test_polygons_become_fans_that_know_their_polygon(tmp_path, name):
    mesh = read(tmp_path, name, polygon_files()[name])
    np.testing.assert_array_equal(mesh.vertices, POINTS)
    np.testing.assert_array_equal(mesh.faces, FANS)
    assert mesh.face_ids.tolist() == [0, 0, 1, 2, 2, 2] and mesh.n_file_faces == 3
    assert mesh.notes == ("2 polygon(s) with more than 3 corners cut into 5 triangles.",)


def test_edges_among_faces_are_left_out(tmp_path):
    mesh = read(tmp_path, "a.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 0\n\n")
    assert mesh.faces.tolist() == [[0, 1, 2]] and mesh.face_ids.tolist() == [1] and mesh.n_file_faces == 3
    assert mesh.notes == ("2 face(s) with fewer than 3 corners left out.",)


def test_obj_negative_numbers_count_from_their_own_line(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3//1 -2//1 -1//1\n  v 5 5 5 1.0\n"
    text += "v 6 5 5\nv 5 6 5\nf -3/2 -2/2 -1/2\nl 1 2\n"
    mesh = read(tmp_path, "a.obj", text)
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]
    with pytest.raises(FormatError, match=r"line 4: a face names vertex 0, but OBJ counts from 1"):
        read(tmp_path, "b.obj", text.replace("-3//1", "0//1"))
    with pytest.raises(FormatError, match=r"face 0 .* names vertex -1"):
        read(tmp_path, "c.obj", text.replace("-3//1", "-4//1"))


def test_why_obj_is_not_left_to_a_library(tmp_path, files, numbered):
    """Should one of these come to keep the numbers, our own reader can go."""
    (tmp_path / "a.obj").write_bytes(files["seams.obj"])
    assert len(trimesh.load_mesh(tmp_path / "a.obj", process=False).vertices) != len(numbered[0])
    with pytest.raises(ValueError, match=r"len\(points\) = 44, but len\(point_data"):
        meshio.obj.read(tmp_path / "a.obj")
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n")
    assert meshio.obj.read(tmp_path / "b.obj").cells[0].data.tolist() == [[-4, -3, -2]]


def test_ply_skips_what_it_does_not_need(tmp_path):
    header = (
        "ply\nformat {} 1.0\nelement camera 1\nproperty list uchar float k\nelement vertex 3\n"
        "property float q\nproperty double z\nproperty short y\nproperty char x\n"
        "element edge 2\nproperty int a\nelement face 1\nproperty float w\n"
        "property list ushort uchar vertex_indices\nproperty list uchar float texcoord\nend_header\n"
    )
    text = header.format("ascii") + "2 0.5 0.5\n9 3 2 1\n9 6 5 4\n9 7 8 9\n0\n1\n0.5 3 0 1 2 2 0 0\n"
    binary = header.format("binary_little_endian").encode() + struct.pack("<B2f", 2, 0.5, 0.5)
    binary += b"".join(struct.pack("<fdhb", 9, z, y, x) for z, y, x in ((3, 2, 1), (6, 5, 4), (7, 8, 9)))
    binary += struct.pack("<2i", 0, 1) + struct.pack("<fH3BB2f", 0.5, 3, 0, 1, 2, 2, 0, 0)
    for name, data in (("a.ply", text), ("b.ply", binary)):
        mesh = read(tmp_path, name, data)
        assert mesh.vertices.tolist() == [[1, 2, 3], [4, 5, 6], [9, 8, 7]] and mesh.faces.tolist() == [[0, 1, 2]]


def test_arrays_and_files_agree(tmp_path, files, numbered):
    mesh, plain = read(tmp_path, "a.off", files["plain.off"]), Mesh(*numbered)
    np.testing.assert_array_equal(mesh.vertices, plain.vertices)
    np.testing.assert_array_equal(mesh.faces, plain.faces)


def test_texture_coordinates_split_nothing(tmp_path):
    """PLY with texture coordinates at corners and at vertices, which trimesh would split vertices for."""
    header = (
        "ply\ncomment before the format\nformat ascii 1.0\ncomment TextureFile nowhere.png\nelement vertex 7\n"
        "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
        "element face 2\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
    )
    rows = lines([[*point, k / 7, 0] for k, point in enumerate(POINTS)])
    uv = " 6 0 0 1 0 0 1\n"
    mesh = read(tmp_path, "a.ply", f"{header}{rows}3 1 4 2{uv}3 6 2 1{uv}")
    assert mesh.vertices.tolist() == POINTS and mesh.faces.tolist() == [[1, 4, 2], [6, 2, 1]] and mesh.notes == ()


def test_ply_polygons_behind_which_bytes_follow(tmp_path):
    data = polygon_files()["b.ply"] + b"\n"
    mesh = read(tmp_path, "a.ply", data)
    assert mesh.faces.tolist() == FANS and mesh.vertices.tolist() == POINTS


def test_stl_named_like_its_own_words(tmp_path, files):
    named = files["text.stl"].replace(b"solid thing", b"solid vertex facet endsolid")
    plain, mesh = read(tmp_path, "a.stl", files["text.stl"]), read(tmp_path, "b.stl", named)
    np.testing.assert_array_equal(mesh.vertices, plain.vertices)
    np.testing.assert_array_equal(mesh.faces, plain.faces)


def test_stl_with_two_solids(tmp_path, files):
    mesh = read(tmp_path, "a.stl", files["text.stl"] + files["text.stl"])
    assert len(mesh.vertices) == 42 and mesh.faces[:80].tolist() == mesh.faces[80:].tolist()


@pytest.mark.parametrize("version", ["42", "51"])
@pytest.mark.parametrize("binary", [True, False])
def test_unstructured_grids_with_data(tmp_path, numbered, version, binary):
    v, f = numbered
    path = tmp_path / "a.vtk"
    grid = meshio.Mesh(v, [("triangle", f)], point_data={"p": v[:, 0]}, cell_data={"c": [np.arange(len(f))]})
    getattr(meshio.vtk, f"_vtk_{version}").write(path, grid, binary=binary)
    mesh = read_mesh(path)
    np.testing.assert_allclose(mesh.vertices, v, rtol=0, atol=0 if binary else 1e-11)
    np.testing.assert_array_equal(mesh.faces, f)
    assert mesh.notes == ()


def test_vtk_polydata_leaves_lines_out_and_reads_crlf(tmp_path):
    cells = lines([[len(p), *p] for p in POLYGONS])
    text = (
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nT 1 1 double\n1\nPOINTS 7 float\n"
    )
    text += f"{lines(POINTS)}VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS 3 15\n{cells}CELL_DATA 3\nNORMALS n float\n"
    for data in (text, text.replace("\n", "\r\n")):
        mesh = read(tmp_path, "a.vtk", data)
        assert mesh.faces.tolist() == FANS and mesh.vertices.tolist() == POINTS and mesh.n_file_faces == 3


def test_vtk_in_several_pieces_is_refused(tmp_path):
    """meshio would keep the cells of the last piece alone."""
    text = polygon_files()["a.vtu"]
    piece = text[text.index("<Piece") : text.index("</Piece>") + 8]
    with pytest.raises(FormatError, match=r"with 2 piece\(s\) is not a surface; save it as PolyData in one piece"):
        read(tmp_path, "a.vtu", text.replace(piece, 2 * piece))


def test_libraries_stay_silent(tmp_path, capfd):
    """A cell type that meshio only prints a warning about."""
    text = polygon_files()["a.vtu"].replace("9 5 7", "9 5 99")
    with pytest.raises(FormatError, match="the header promises 3 cells, but 2 can be read"):
        read(tmp_path, "a.vtu", text)
    assert capfd.readouterr() == ("", "")


def test_reading_imports_libraries_only_when_needed():
    code = "import sys, mobius_match.mesh; sys.exit(bool({'trimesh', 'meshio', 'igl', 'numba'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
