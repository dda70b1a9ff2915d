"""Shapes with known topology, as (vertices, faces)."""

import base64
import json
import zlib
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import trimesh


def sphere(level=2):
    ball = trimesh.creation.icosphere(level)
    return np.array(ball.vertices), np.array(ball.faces)


def grid(nu, nv, wrap_u=False, wrap_v=False, twist=False):
    """Faces of nu x nv quads cut in two, the ends of u (and v) joined where asked, u with a half turn."""
    rows, columns = (nu if wrap_u else nu + 1), (nv if wrap_v else nv + 1)

    def at(i, j):
        if wrap_u and i == nu:
            i, j = 0, (nv - j if twist else j)
        return i * columns + (j % nv if wrap_v else j)

    faces = []
    for i in range(nu):
        for j in range(nv):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    i, j = np.divmod(np.arange(rows * columns), columns)
    return i / nu, j / nv, np.array(faces)


def disc():
    u, v, faces = grid(6, 6)
    return np.stack([u, v, 0.1 * u * v], axis=1), faces


def cylinder():
    u, v, faces = grid(10, 4, wrap_u=True)
    return np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), v], axis=1), faces


def torus(shift=0.0):
    u, v, faces = grid(10, 8, wrap_u=True, wrap_v=True)
    r = 2 + np.cos(2 * np.pi * v)
    return np.stack([r * np.cos(2 * np.pi * u) + shift, r * np.sin(2 * np.pi * u), np.sin(2 * np.pi * v)], 1), faces


def moebius():
    u, v, faces = grid(20, 3, wrap_u=True, twist=True)
    r = 1 + (v - 0.5) * np.cos(np.pi * u)
    return np.stack([r * np.cos(2 * np.pi * u), r * np.sin(2 * np.pi * u), (v - 0.5) * np.sin(np.pi * u)], 1), faces


def holed_sphere(holes=2):
    """An icosphere without the faces around its first, mutually distant, vertices."""
    vertices, faces = sphere(2)
    return vertices, faces[~np.isin(faces, np.arange(holes)).any(axis=1)]


def union(*parts):
    """Several (vertices, faces) in one, numbered on."""
    start = np.cumsum([0] + [len(v) for v, _ in parts])
    return np.concatenate([v for v, _ in parts]), np.concatenate(
        [f + s for (_, f), s in zip(parts, start, strict=False)]
    )


def bowtie():
    """Two discs that share one vertex: number 0 of both."""
    v, f = disc()
    vertices, faces = union((v, f), (-v, f))
    faces = np.where(faces == len(v), 0, faces)
    return vertices, faces


def book(pages=3):
    """Square sheets that share one edge of 6 segments."""
    u, v, faces = grid(6, 6)
    sheets, spine = [], np.flatnonzero(v == 0)
    for k in range(pages):
        angle = 2 * np.pi * k / pages
        sheets.append((np.stack([v * np.cos(angle), v * np.sin(angle), u], axis=1), faces))
    vertices, faces = union(*sheets)
    number = np.arange(len(vertices))
    for k in range(1, pages):
        number[spine + k * len(u)] = spine
    return vertices, number[faces]


@pytest.fixture(scope="session")
def shapes():
    return SimpleNamespace(
        sphere=sphere,
        grid=grid,
        disc=disc,
        cylinder=cylinder,
        torus=torus,
        moebius=moebius,
        holed_sphere=holed_sphere,
        union=union,
        bowtie=bowtie,
        book=book,
    )


def text_rows(rows, form="{!r}"):
    return "".join(" ".join(form.format(value) for value in row) + "\n" for row in np.asarray(rows).tolist())


def ply_header(kind, n, m):
    return (
        f"ply\nformat {kind} 1.0\ncomment by hand\nelement vertex {n}\nproperty double x\nproperty double y\n"
        f"property double z\nproperty uchar red\nelement face {m}\nproperty list uchar int vertex_indices\n"
        "property uchar flag\nend_header\n"
    )


def ply_binary(v, f, order):
    points = np.zeros(len(v), [("v", order + "f8", 3), ("red", "u1")])
    points["v"] = v
    cells = np.zeros(len(f), [("n", "u1"), ("f", order + "i4", 3), ("flag", "u1")])
    cells["n"], cells["f"] = 3, f
    kind = "binary_little_endian" if order == "<" else "binary_big_endian"
    return ply_header(kind, len(v), len(f)).encode() + points.tobytes() + cells.tobytes()


def stl_binary(v, f):
    cells = np.zeros(len(f), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    cells["v"] = v[f]
    return b"solid but binary".ljust(80) + np.uint32(len(f)).tobytes() + cells.tobytes()


def stl_text(v, f):
    out = ["solid thing"]
    for corners in v[f]:
        out += ["facet normal 0 0 0", " outer loop"]
        out += ["  vertex " + " ".join(map(repr, p)) for p in corners.tolist()]
        out += [" endloop", "endfacet"]
    return "\n".join([*out, "endsolid thing", ""]).encode()


def obj_seams(v, f):
    """Texture and normal numbers that differ between the faces of a vertex, groups and materials."""
    out = ["mtllib nowhere.mtl", "o thing", *("v " + " ".join(map(repr, p)) for p in v.tolist())]
    out += [f"vt {k / 7} {k / 9}" for k in range(7)] + [f"vn {k} 0 1" for k in range(5)]
    for k, face in enumerate(f.tolist()):
        if k % 50 == 0:
            out += [f"g part{k}", f"usemtl colour{k}"]
        out.append("f " + " ".join(f"{i + 1}/{(k + c) % 7 + 1}/{k % 5 + 1}" for c, i in enumerate(face)))
    return "\n".join(out).encode()


def vtk_legacy(v, f, binary):
    cells = np.insert(f, 0, 3, axis=1)
    kind = "BINARY" if binary else "ASCII"
    head = f"# vtk DataFile Version 3.0\ntitle\n{kind}\nDATASET POLYDATA\nPOINTS {len(v)} double\n"
    mid = f"POLYGONS {len(f)} {cells.size}\n"
    tail = b"\nPOINT_DATA 1\nSCALARS x double\n"
    if binary:
        return head.encode() + v.astype(">f8").tobytes() + b"\n" + mid.encode() + cells.astype(">i4").tobytes() + tail
    return (head + text_rows(v) + mid + text_rows(cells)).encode() + tail


def vtk_offsets(v, f):
    """Version 5: offsets and connectivity, metadata after the points."""
    return (
        "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET POLYDATA\n"
        f"POINTS {len(v)} double\n{text_rows(v)}METADATA\nINFORMATION 0\n\nPOLYGONS {len(f) + 1} {f.size}\n"
        f"OFFSETS vtktypeint64\n{text_rows([range(0, f.size + 1, 3)])}"
        f"CONNECTIVITY vtktypeint64\n{text_rows(f)}"
    ).encode()


def vtp(v, f, form):
    """PolyData in XML: "ascii", "binary" (base64), "zlib" (base64, compressed) or "raw" (appended)."""
    appended = b""

    def array(values, kind, name, width=1):
        nonlocal appended
        data = values.tobytes()
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="'
        if form == "ascii":
            return head + 'ascii">' + text_rows([values.ravel()]) + "</DataArray>"
        if form == "binary":
            return head + 'binary">' + base64.b64encode(np.uint32(len(data)).tobytes() + data).decode() + "</DataArray>"
        if form == "zlib":
            blocks = [data[k : k + 1000] for k in range(0, len(data), 1000)]
            packed = [zlib.compress(block) for block in blocks]
            sizes = np.array([len(blocks), 1000, len(blocks[-1]) % 1000, *map(len, packed)], dtype="<u4")
            text = base64.b64encode(sizes.tobytes()) + base64.b64encode(b"".join(packed))
            return head + 'binary">' + text.decode() + "</DataArray>"
        appended += np.uint32(len(data)).tobytes() + data
        return head + f'appended" offset="{len(appended) - len(data) - 4}"/>'

    body = (
        f'<PolyData><Piece NumberOfPoints="{len(v)}" NumberOfPolys="{len(f)}">'
        f"<Points>{array(v, 'Float64', 'p', 3)}</Points><Polys>"
        f"{array(f.astype(np.int64), 'Int64', 'connectivity')}"
        f"{array(np.arange(3, f.size + 1, 3, dtype=np.int32), 'Int32', 'offsets')}</Polys></Piece></PolyData>"
    )
    packer = ' compressor="vtkZLibDataCompressor"' if form == "zlib" else ""
    head = f'<?xml version="1.0"?><VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"{packer}>'
    section = b'<AppendedData encoding="raw">\n_' + appended + b"\n</AppendedData>" if appended else b""
    return head.encode() + body.encode() + section + b"</VTKFile>"


def vtu(v, f, folder, **how):
    path = folder / "made.vtu"
    meshio.vtu.write(path, meshio.Mesh(v, [("triangle", f)]), **how)
    return path.read_bytes()


def glb(v, f):
    return trimesh.Trimesh(v, f, process=False).export(file_type="glb")


def gltf(v, f):
    """With its buffer in a data URI."""
    data = v.astype("<f4").tobytes() + f.astype("<u4").tobytes()
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "nowhere.png"}],
        "buffers": [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * len(v)},
                        {"buffer": 0, "byteOffset": 12 * len(v), "byteLength": 12 * len(f)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(v), "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": f.size, "type": "SCALAR"}],
    }  # fmt: skip
    return json.dumps(tree).encode()


def every_file(v, f, folder):
    """The mesh in every format and dialect: name of the file -> bytes."""
    n, m = len(v), len(f)
    rows, cells = text_rows(v), text_rows(np.insert(f, 0, 3, axis=1))
    painted = cells.replace("\n", " 255 0 0\n")
    extra = np.hstack([v, np.zeros((n, 4))])
    return {
        "plain.off": f"OFF\n{n} {m} 0\n{rows}{cells}",
        "one_line.off": f"# first\nOFF {n} {m} 0 # counts\n\n{rows}# faces\n{painted}",
        "colours.off": f"COFF\r\n{n} {m} 0\r\n" + (text_rows(extra) + cells).replace("\n", "\r\n"),
        "normals.off": f"NOFF\n{n} {m}\n{text_rows(extra[:, :6])}{cells}",
        "plain.obj": "".join(f"v {line}\n" for line in rows.splitlines())
        + "".join(f"f {line}\n" for line in text_rows(f + 1).splitlines()),
        "seams.obj": obj_seams(v, f),
        "text.ply": ply_header("ascii", n, m) + rows.replace("\n", " 7\n") + cells.replace("\n", " 1\n"),
        "little.ply": ply_binary(v, f, "<"),
        "big.ply": ply_binary(v, f, ">"),
        "text.stl": stl_text(v, f),
        "binary.stl": stl_binary(v, f),
        "text.vtk": vtk_legacy(v, f, False),
        "binary.vtk": vtk_legacy(v, f, True),
        "offsets.vtk": vtk_offsets(v, f),
        **{f"{form}.vtp": vtp(v, f, form) for form in ("ascii", "binary", "zlib", "raw")},
        "text.vtu": vtu(v, f, folder, binary=False),
        "binary.vtu": vtu(v, f, folder, compression=None),
        "zlib.vtu": vtu(v, f, folder),
        "lib.glb": glb(v, f),
        "hand.gltf": gltf(v, f),
    }


@pytest.fixture(scope="session")
def numbered():
    """A sphere in random numbering, with two unused vertices, and coordinates that need all 17 digits."""
    rng = np.random.default_rng(5)
    vertices, faces = sphere(1)
    place = rng.permutation(len(vertices) + 2)
    v = rng.normal(size=(len(place), 3))
    v[place[: len(vertices)]] = vertices
    f = place[faces][rng.permutation(len(faces))]
    return v.astype(np.float64), np.array([np.roll(face, k % 3) for k, face in enumerate(f)])


@pytest.fixture(scope="session")
def files(numbered, tmp_path_factory):
    made = every_file(*numbered, tmp_path_factory.mktemp("made"))
    return {name: data.encode() if isinstance(data, str) else data for name, data in made.items()}
