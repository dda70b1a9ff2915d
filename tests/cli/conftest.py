"""The command line in this process and in one of its own, and small meshes to give it."""

import io
import os
import signal
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest
import trimesh
from PIL import Image

import mobius_match as mm
from mobius_match.cli import main
from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import repair
from mobius_match.mesh.writing import mesh_files
from mobius_match.results.surface_map import SurfaceMap


class Ended(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def mobius(monkeypatch, capsys):
    """Run the command line in this process. The line about compiling is left out: it depends on earlier tests."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["mobius", *map(str, arguments)])
        with pytest.raises(SystemExit) as ending:
            main()
        out, err = capsys.readouterr()
        said = [line for line in err.splitlines(keepends=True) if not line.startswith("compiling (")]
        return Ended(ending.value.code or 0, out, "".join(said))

    handler = signal.getsignal(signal.SIGTERM)
    yield run
    signal.signal(signal.SIGTERM, handler)


@pytest.fixture
def start_mobius():
    """Start the command line as a process, which is killed if it still runs at the end of the test."""
    started = []

    def start(*arguments, **options):
        command = [sys.executable, "-c", "from mobius_match.cli import main; main()", *map(str, arguments)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": dict(os.environ)}
        # Tests that run in the background ignore interrupts, and so would what they start.
        handler = signal.signal(signal.SIGINT, signal.default_int_handler)
        started.append(subprocess.Popen(command, **(pipes | options)))
        signal.signal(signal.SIGINT, handler)
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


@pytest.fixture
def start_process():
    """Run the interpreter to its end and give what it wrote."""

    def run(*arguments):
        ended = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=60, check=True)
        return ended.stdout, ended.stderr

    return run


def _write(path, vertices, faces):
    path.write_bytes(trimesh.Trimesh(vertices, faces, process=False).export(file_type="off").encode())
    return path


@pytest.fixture(scope="session")
def shape():
    """A sphere with five arms of different length and no symmetry: vertices (642, 3), faces (1280, 3)."""
    sphere = trimesh.creation.icosphere(subdivisions=3)
    arms = np.array([[1, 0.1, 0], [-0.3, 1, 0.2], [0, -0.4, 1], [-1, -0.5, 0.3], [0.2, -0.7, -1]])
    arms /= np.linalg.norm(arms, axis=1, keepdims=True)
    lengths = np.array([2.0, 1.5, 1.1, 0.8, 0.5])
    radius = 1 + np.exp(12 * (sphere.vertices @ arms.T - 1)) @ lengths
    return sphere.vertices * radius[:, None], sphere.faces


@pytest.fixture(scope="session")
def pair(shape, tmp_path_factory):
    """Two files, the shape and the shape turned and renumbered, and the new number of each vertex."""
    vertices, faces = shape
    folder = tmp_path_factory.mktemp("pair")
    number = np.random.default_rng(1).permutation(len(vertices))
    moved = np.empty_like(vertices)
    moved[number] = vertices @ trimesh.transformations.rotation_matrix(1.0, [1, 2, 3])[:3, :3].T
    return (
        _write(folder / "one.off", vertices, faces),
        _write(folder / "two.off", moved, number[faces]),
        number,
    )


@pytest.fixture(scope="session")
def klein(tmp_path_factory):
    """A mesh that can be read and not matched: a Klein bottle of 16 by 8 quadrilaterals."""

    def at(i, j):
        return i % 16 * 8 + (-j if i == 16 else j) % 8

    faces = [
        corners
        for i in range(16)
        for j in range(8)
        for a, b, c, d in [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))]
        for corners in ((a, b, c), (a, c, d))
    ]
    u, v = 2 * np.pi * np.repeat(np.arange(16), 8) / 16, 2 * np.pi * np.tile(np.arange(8), 16) / 8
    radius = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), height], axis=1)
    return _write(tmp_path_factory.mktemp("klein") / "klein.off", vertices, np.array(faces))


@pytest.fixture
def broken(tmp_path):
    """A file that ends in the middle."""
    path = tmp_path / "broken.off"
    path.write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n")
    return path


def at_vertices(mesh, vertices):
    corner = np.empty(len(mesh.vertices), np.int64)
    corner[mesh.faces.ravel()] = np.arange(3 * len(mesh.faces))
    faces, place = corner[vertices] // 3, corner[vertices] % 3
    return SurfacePoints(faces, mesh.faces[faces], np.eye(3)[place])


@pytest.fixture(scope="module")
def saved_map(shape, tmp_path_factory):
    """A map of a mesh with attributes to a renumbered copy, part of which has no counterpart, and their files.

    Its values: the folder of the files, the map, the new number of each vertex, which vertices of the copy have no
    counterpart, and the attributes.
    """
    folder = tmp_path_factory.mktemp("saved_map")
    vertices, faces = np.array(shape[0], np.float32).astype(float), np.array(shape[1])
    rng = np.random.default_rng(0)
    number = rng.permutation(len(vertices))
    moved = np.empty_like(vertices)
    moved[number] = vertices
    picture = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (8, 8, 3), dtype=np.uint8)).save(picture, "PNG")
    colors = rng.integers(0, 256, (len(vertices), 4), dtype=np.uint8)
    uv = (vertices[:, :2] / 10 + 0.5)[faces]
    attributes = {"colors": colors, "uv": uv, "image": picture.getvalue(), "labels": np.arange(len(faces)) % 7}
    for path, content in {
        **mesh_files(folder / "one.ply", vertices, faces, **attributes),
        **mesh_files(folder / "two.ply", moved, number[faces]),
    }.items():
        path.write_bytes(content)
    one, two = (repair(mm.read_mesh(folder / name)) for name in ("one.ply", "two.ply"))
    lost = moved[:, 2] > np.sort(moved[:, 2])[-40]
    surface_map = SurfaceMap(
        one, two, at_vertices(two, number), at_vertices(one, np.argsort(number)), ~lost[number], ~lost
    )
    surface_map.save(folder / "map.npz")
    return folder, surface_map, number, lost, attributes
