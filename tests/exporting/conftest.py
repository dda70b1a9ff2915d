"""A matched pair of meshes with its dense map and the positions of its matches."""

import numpy as np
import pytest

import mobius_match as mm
from tests.shapes import lump, renumbered

SIDES = ("source", "target")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    source, (target, _) = lump(2), renumbered(lump(2))
    # Coordinates without a short decimal representation.
    for name, (vertices, faces), shift in (("one.ply", source, 1 / 3), ("two <&> -- “b”.ply", target, 1 / 7)):
        rows = np.empty(len(faces), [("n", "u1"), ("corners", "<i4", 3)])
        rows["n"], rows["corners"] = 3, faces
        head = "ply\nformat binary_little_endian 1.0\n" + "".join(
            [f"element vertex {len(vertices)}\n", *(f"property double {axis}\n" for axis in "xyz")]
        )
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        (folder / name).write_bytes(head.encode() + (vertices / 3 + shift).astype("<f8").tobytes() + rows.tobytes())
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return mm.match(*sorted(folder.iterdir()), samples=30)


@pytest.fixture(scope="module")
def dense(result):
    return result.dense()


@pytest.fixture(scope="module")
def places(result):
    """Positions of the matches on both shapes, computed from the result alone."""
    meshes = [mm.read_mesh(info["path"]) for info in (result.source_info, result.target_info)]
    there = result.target_points
    return (
        meshes[0].vertices[result.pairs[:, 0]],
        np.einsum("qk,qki->qi", there.barycentric, meshes[1].vertices[there.corners]),
    )


@pytest.fixture(scope="module")
def partial(dense):
    """The map with some vertices without a counterpart."""
    lost = np.arange(len(dense.source_mapped)) % 7 == 3
    return type(dense)(dense.source, dense.target, dense.target_points, dense.source_points, ~lost, dense.target_mapped)
