"""Bad files: one clear error, at once, and never another exception."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mobius_match.errors import FormatError, MeshError
from mobius_match.mesh import Mesh, read_mesh
from mobius_match.mesh.files import READERS

ENDINGS = sorted(READERS)
HUGE = 10**9


def outcome(path, data):
    """The mesh, or the error if it is one of the family that names the file; anything else comes through."""
    path.write_bytes(data)
    try:
        return read_mesh(path)
    except MeshError as error:
        # Errors of the file have its path, those of its numbers its name.
        assert path.name in str(error)
        return error


def test_missing_folder_empty_unknown(tmp_path):
    with pytest.raises(FormatError, match=r"absent\.off: no such file"):
        read_mesh(tmp_path / "absent.off")
    (tmp_path / "folder.off").mkdir()
    with pytest.raises(FormatError, match=r"folder\.off: is a folder or a device"):
        read_mesh(tmp_path / "folder.off")
    for data in (b"", b" \n\n"):
        (tmp_path / "empty.ply").write_bytes(data)
        with pytest.raises(FormatError, match=r"empty\.ply: the file is empty"):
            read_mesh(tmp_path / "empty.ply")
    (tmp_path / "scan.xyz").write_bytes(b"1 2 3")
    with pytest.raises(FormatError, match=r"unknown ending '\.xyz'\. Supported are \.off, \.obj, .*\.vtu: export"):
        read_mesh(tmp_path / "scan.xyz")
    for odd in ("", "a\0b.off", "x" * 5000 + ".off"):
        with pytest.raises(FormatError):
            read_mesh(odd)


PLY = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
PLY += "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
VTK = "# vtk DataFile Version 3.0\nt\n{}\nDATASET POLYDATA\n{}"
POINT = "0 0 0\n1 0 0\n0 1 0\n"
PROMISES = {
    "a.off": f"OFF\n3 {HUGE} 0\n{POINT}3 0 1 2\n",
    "b.off": f"OFF\n{HUGE} 1 0\n{POINT}3 0 1 2\n",
    "c.off": f"OFF\n3 1 0\n{POINT}{HUGE} 0 1 2\n",
    "a.ply": PLY.format("ascii", 3, HUGE) + POINT + "3 0 1 2\n",
    "b.ply": PLY.format("ascii", HUGE, 1) + POINT + "3 0 1 2\n",
    "c.ply": (PLY.format("binary_little_endian", 3, HUGE) + "\0" * 49).encode(),
    "d.ply": (PLY.format("binary_big_endian", HUGE, 1) + "\0" * 49).encode(),
    "e.ply": PLY.format("binary_big_endian", 0, 1).replace("uchar", "uint").encode() + b"\xff" * 40,
    "a.stl": b"\0" * 80 + np.uint32(HUGE).tobytes() + b"\0" * 50,
    "a.vtk": VTK.format("ASCII", f"POINTS {HUGE} float\n{POINT}"),
    "b.vtk": VTK.format("BINARY", f"POINTS {HUGE} float\n{POINT}"),
    "c.vtk": VTK.format("ASCII", f"POINTS 3 float\n{POINT}POLYGONS {HUGE} {4 * HUGE}\n3 0 1 2\n"),
    "d.vtk": VTK.format("ASCII", f"POINTS 3 float\n{POINT}POLYGONS {HUGE} 4\n3 0 1 2\n"),
    "a.vtp": f'<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="{HUGE}"/></PolyData></VTKFile>',
}


@pytest.mark.parametrize("name", PROMISES)
def test_a_header_cannot_promise_the_moon(tmp_path, name):
    data = PROMISES[name]
    (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match=r"promises|corners|beyond|does not fit"):
            read_mesh(tmp_path / name)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("name", "data", "text"),
    [
        ("a.off", "COUNT\n", "must begin with OFF"),
        ("a.off", "OFF BINARY\n1 1 1\n", "numbers of vertices, faces and edges expected after OFF, found 'BINARY'"),
        ("a.off", "4OFF\n1 1 1\n", "binary and four-dimensional OFF cannot be read"),
        ("a.off", "OFF\n", "the numbers of vertices, faces and edges expected after OFF, found ''"),
        (
            "a.off",
            "OFF\n3 -1 0\n",
            "the numbers of vertices, faces and edges expected after OFF, found '3 -1 0'",
        ),
        ("a.off", "OFF\n3\n", "faces and edges expected after OFF, found '3'"),
        (
            "a.off",
            f"OFF\n3 1 0\n{POINT}3 0 1\n",
            r"face 0 \(counting from 0\) should have 3 corners, but 2 numbers follow",
        ),
        (
            "a.off",
            f"OFF\n3 1 0\n{POINT}3 0 1 x\n",
            r"face 0 .* names vertex x, but there are 3 vertices",
        ),
        ("a.off", f"OFF\n3 1 0\n{POINT}3 0 1 1.5\n", r"face 0 .* names vertex 1\.5, but there are 3 vertices"),
        ("a.off", f"OFF\n3 1 0\n{POINT}-3 0 1 2\n", r"face 0 .* should have -3 corners"),
        (
            "a.off",
            f"OFF\n3 1 0\n# hm\n\n{POINT}".replace("1 0 0", "1 o 0") + "3 0 1 2\n",
            "cannot be read as OFF .ValueError: could not convert string to float: 'o'",
        ),
        (
            "a.off",
            f"OFF\n3 1 0\n{POINT}3 0 1 3\n",
            r"face 0 .* names vertex 3, but there are 3 vertices, numbered 0 to 2",
        ),
        ("a.off", f"OFF\n3 1 0\n{POINT}3 0 1 -1\n", "names vertex -1"),
        ("a.off", f"OFF\n3 0 0\n{POINT}", "3 vertices and 0 faces.* A point cloud must be meshed first"),
        (
            "a.off",
            f"OFF\n3 1 0\n{POINT.replace('1 0 0', 'nan 0 0')}3 0 1 2\n",
            "1 vertex has .* first is vertex 1",
        ),
        (
            "a.off",
            f"OFF\n3 1 0\n{POINT.replace('1', '1e999')}3 0 1 2\n",
            "2 vertices have .* first is vertex 1",
        ),
        ("a.obj", "f 1 2 3\n", "there are 0 vertices"),
        ("a.obj", "v 0 0\nv 1 1 1\nf 1 2 1\n", "line 1: a vertex needs 3 numbers, found 'v 0 0'"),
        ("a.obj", "v 0 0 0\nv 1 1 1\nf 1 2 a/b\n", "line 3: a face needs whole numbers, found 'f 1 2 a/b'"),
        ("a.obj", "hello", "0 vertices and 0 faces"),
        ("a.ply", "ply\nformat ascii 1.0\n", "no end_header line"),
        ("a.ply", "ply\nformat ebcdic 1.0\nend_header\n", "line 2: 'format ebcdic 1.0' is not understood"),
        ("a.ply", "ply\nend_header\n", "no format line"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "the header lacks a vertex element with x y z",
        ),
        (
            "a.ply",
            PLY.format("ascii", 3, 1).partition("element face")[0] + "end_header\n" + POINT,
            "the header lacks a face element with vertex_indices.* A point cloud must be meshed first",
        ),
        (
            "a.ply",
            PLY.format("ascii", 3, 1).replace("float z", "float w") + POINT + "3 0 1 2\n",
            "the header lacks a vertex element with x y z",
        ),
        ("a.ply", PLY.format("ascii", 3, 1) + POINT + "3 0 1\n", r"face 0 .* should have 3 corners, but 2 follow"),
        ("a.ply", PLY.format("ascii", "3x", 1), "line 3: 'element vertex 3x' is not understood"),
        ("a.stl", "solid x\nfacet\nvertex 0 0 0\n", "1 facets begin, 0 end and there are 1 corners"),
        ("a.stl", "short", "5 bytes are too few for STL"),
        ("a.vtk", "hello\nworld\n", "not a legacy VTK file"),
        (
            "a.vtk",
            VTK.format("ASCII", "").replace("POLYDATA", "STRUCTURED_POINTS"),
            "is not a surface; save it as PolyData",
        ),
        (
            "a.vtk",
            VTK.format("ASCII", f"POINTS 3 float\n{POINT}TRIANGLE_STRIPS 1 4\n3 0 1 2\n"),
            "apply a triangle filter",
        ),
        ("a.vtk", VTK.format("ASCII", "POINTS x float\n"), "'POINTS x float' does not give a count"),
        ("a.vtk", VTK.format("ASCII", "POINTS 1 complex\n0 0 0\nPOLYGONS 1 1\n0\n"), "KeyError: 'complex'"),
        ("a.vtu", "<VTKFile", "cannot be read as VTU .ParseError"),
        ("a.vtu", '<VTKFile type="ImageData"/>', "is not a surface"),
        ("a.vtp", '<!DOCTYPE x [<!ENTITY a "b">]><VTKFile type="PolyData"/>', "have no place"),
        ("a.glb", b"glTF\2\0\0\0\xff\0\0\0", "promises 255 bytes"),
        ("a.glb", b"glTF\1\0\0\0\x0c\0\0\0", "GLB version 1"),
        ("a.gltf", "[1, 2]", "must be an object"),
        ("a.gltf", "[" * 100_000, "cannot be read as GLTF"),
    ],
)
def test_says_what_is_wrong_and_where(tmp_path, name, data, text):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(MeshError, match=text) as caught:
        read_mesh(path)
    assert name in str(caught.value) and "\n" not in str(caught.value)


def test_solid_cells_are_refused(tmp_path):
    path = tmp_path / "a.vtk"
    cells = "CELLS 2 9\n3 0 1 2\n4 0 1 2 3\nCELL_TYPES 2\n5 10\n"
    path.write_text(
        VTK.format("ASCII", f"POINTS 4 float\n{POINT}0 0 1\n{cells}").replace("POLYDATA", "UNSTRUCTURED_GRID")
    )
    with pytest.raises(FormatError, match=r"1 cell\(s\) of type tetra are neither .*\(the first is cell 1\)"):
        read_mesh(path)
    path.write_text(path.read_text().replace("4 0 1 2 3", "2 0 1").replace("2 9", "2 7").replace("5 10", "5 3"))
    mesh = read_mesh(path)
    assert mesh.faces.tolist() == [[0, 1, 2]] and mesh.n_file_faces == 2


def test_cut_short_anywhere(tmp_path, files):
    """Cut at every 60th byte or so: half a file is never a mesh, and the error is always of the family."""
    rng = np.random.default_rng(0)
    for name, data in files.items():
        for size in np.sort(rng.integers(1, len(data), 60)).tolist():
            result = outcome(tmp_path / name, data[:size])
            # The last digits of a text, or attributes behind the faces, may go unnoticed; faces may not.
            if size < 0.9 * len(data) and not name.endswith("obj"):
                assert isinstance(result, MeshError), (name, size, len(data))


def test_damaged_anywhere(tmp_path, files):
    """A few bytes exchanged: a mesh or an error of the family."""
    rng = np.random.default_rng(1)
    refused = 0
    for name, data in files.items():
        for _ in range(40):
            damaged = np.frombuffer(data, np.uint8).copy()
            # Half of the damage strikes the header, where counts and types are.
            span = len(data) if rng.random() < 0.5 else min(len(data), 400)
            damaged[rng.integers(0, span, 3)] = rng.integers(0, 256, 3)
            result = outcome(tmp_path / name, damaged.tobytes())
            refused += isinstance(result, MeshError)
            assert isinstance(result, Mesh | MeshError)
    assert refused > 100


def test_digits_exchanged(tmp_path, files):
    """Other digits in the text of a header: wrong counts and sizes that still parse."""
    rng = np.random.default_rng(2)
    for name, data in files.items():
        digits = np.flatnonzero(np.isin(np.frombuffer(data[:1500], np.uint8), np.frombuffer(b"0123456789", np.uint8)))
        for _ in range(30):
            damaged = bytearray(data)
            for place in rng.choice(digits, 2).tolist():
                damaged[place : place + 1] = str(rng.integers(0, 10 ** rng.integers(1, 12))).encode()
            assert isinstance(outcome(tmp_path / name, bytes(damaged)), Mesh | MeshError)


MAGIC = (
    b"",
    b"OFF\n",
    b"ply\nformat ascii 1.0\n",
    b"solid ",
    b"glTF\2\0\0\0",
    b"# vtk DataFile Version 3.0\n",
    b"<VTKFile",
    b"{",
)


@pytest.mark.parametrize("ending", ENDINGS)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(MAGIC), st.binary(max_size=300))
def test_random_bytes(tmp_path, ending, magic, data):
    assert isinstance(outcome(tmp_path / f"a{ending}", magic + data), MeshError)
