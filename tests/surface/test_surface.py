"""Prepared surfaces on the disk."""

from dataclasses import fields

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.errors import FormatError
from tests.shapes import icosphere, lump


@pytest.fixture(scope="module")
def surface(tmp_path_factory):
    import trimesh

    vertices, faces = lump(2)
    path = tmp_path_factory.mktemp("mesh") / "lump.off"
    # One vertex more, that no face uses: numbers of the file and of the repaired mesh differ.
    mesh = trimesh.Trimesh(np.vstack([[9.0, 9.0, 9.0], vertices]), faces + 1, process=False)
    path.write_bytes(mesh.export(file_type="off", digits=17).encode())
    return mm.prepare(path, samples=20)


def same(first, second):
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and np.array_equal(first, second)
    return type(first) is type(second) and first == second


def test_a_saved_surface_comes_back_as_it_was(surface, tmp_path):
    surface.save(tmp_path / "surface.npz")
    found = mm.Surface.load(tmp_path / "surface.npz")
    assert surface.mesh.vertex_ids[0] == 1
    assert surface.mesh.notes
    for record, loaded in ((surface, found), (surface.mesh, found.mesh)):
        for field in fields(record):
            if field.name != "mesh":
                assert same(getattr(record, field.name), getattr(loaded, field.name)), field.name
    with pytest.raises(ValueError, match="read-only"):
        found.mesh.vertices[0] = 0


def test_curvature_features_do_not_change_with_scale_and_vanish_on_a_sphere():
    vertices, faces = lump(4)
    found = mm.prepare((vertices, faces))
    assert np.abs(np.median(found.curvature_features[found.proxy], axis=0)).max() < 1e-3
    assert found.curvature_features[found.proxy].std(axis=0) == pytest.approx([1, 1], abs=0.15)
    bumps, middle = np.argmax(np.linalg.norm(vertices, axis=1)), np.argmin(np.linalg.norm(vertices, axis=1))
    assert (found.curvature_features[bumps] > found.curvature_features[middle] + 2).all()
    np.testing.assert_allclose(
        mm.prepare((1000 * vertices + 5, faces)).curvature_features, found.curvature_features, atol=2e-3
    )
    assert np.abs(mm.prepare(icosphere(3)).curvature_features).max() < 0.5


def test_a_mesh_without_a_file_is_saved_without_a_path(tmp_path):
    surface = mm.prepare(lump(2), samples=10)
    surface.save(tmp_path / "surface.npz")
    assert mm.Surface.load(tmp_path / "surface.npz").mesh.path is None


def test_damaged_files_are_refused(surface, tmp_path):
    whole, path = tmp_path / "whole.npz", tmp_path / "bad.npz"
    surface.save(whole)
    for content in (b"", b"no archive", whole.read_bytes()[:5000]):
        path.write_bytes(content)
        with pytest.raises(FormatError, match=r"bad\.npz"):
            mm.Surface.load(path)
    np.savez(path, values=np.array('{"format": "other", "version": 1}'))
    with pytest.raises(FormatError, match=r"bad\.npz.*prepare the mesh again"):
        mm.Surface.load(path)
    with pytest.raises(FormatError, match=r"none\.npz"):
        mm.Surface.load(tmp_path / "none.npz")


def test_a_prepared_file_stands_for_its_mesh(surface, tmp_path):
    mesh, path = surface.mesh.path, tmp_path / "surface.npz"
    surface.save(path)
    settings = {"samples": 20, "votes": 2000, "threshold": 0}
    wanted = mm.match(mesh, mesh, **settings).to_dict() | {"timings": None}
    for pair in ((path, path), (str(path), mesh), (mesh, surface)):
        assert mm.match(*pair, **settings).to_dict() | {"timings": None} == wanted
    assert mm.prepare(path).settings.samples == 20
