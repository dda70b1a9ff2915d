"""An envelope closes what is narrow, keeps its distance, and is told in the user's numbers."""

from dataclasses import replace

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.geometry.points import SurfacePoints
from mobius_match.mesh import Mesh, repair
from mobius_match.mesh import topology as tp
from mobius_match.mesh.envelope import _points_on, envelopes
from mobius_match.mesh.handles import is_wild, number_of_handles
from mobius_match.mesh.parameters import EnvelopeParameters
from mobius_match.surface.parameters import SurfaceParameters
from tests.shapes import icosphere, lump, rotation, torus

COARSE = EnvelopeParameters(most_handles=10, close=0.04)
"""The step of the grid is half of the distance of the close envelope."""


def perforated(vertices, faces, tunnels, widest=0.1, wide=False, seed=0):
    """A thick shell around the origin with tunnels through it: a closed surface with one handle less than tunnels.

    All are narrow, or all but the first one.
    """
    n, rng = len(vertices), np.random.default_rng(seed)
    edges = tp.edge_table(faces).edges
    length, width = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1), np.zeros(n)
    np.maximum.at(width, edges, length[:, None])
    six, gone = np.bincount(faces.ravel()) == 6, np.zeros(len(faces), dtype=bool)
    centres = [int((width * six).argmax())] if wide else []
    if wide:  # the faces around its neighbours as well
        gone |= np.isin(faces, faces[(faces == centres[0]).any(axis=1)]).any(axis=1)
    for vertex in rng.permutation(n):
        near = np.linalg.norm(vertices[centres] - vertices[vertex], axis=1)
        narrow = width[vertex] < widest and (near > 1.1 * (width[vertex] + width[centres])).all()
        if narrow and six[vertex] and len(centres) < tunnels:
            centres.append(int(vertex))
    assert len(centres) == tunnels
    gone |= np.isin(faces, centres).any(axis=1)
    open_ = faces[~gone]
    ahead = np.concatenate([faces[gone][:, [k, (k + 1) % 3]] for k in range(3)])
    a, b = ahead[~(ahead[:, None] == ahead[None, :, ::-1]).all(axis=2).any(axis=1)].T
    rims = np.concatenate([np.stack([a, b, b + n], axis=1), np.stack([a, b + n, a + n], axis=1)])
    both = np.concatenate([open_, open_[:, ::-1] + n, rims])
    return np.concatenate([vertices, 0.9 * vertices]), both


def test_the_envelope_of_a_perforated_sphere_is_a_sphere():
    vertices, faces = perforated(*icosphere(4), 70)
    mesh = repair(Mesh(vertices, faces))
    assert number_of_handles(mesh.faces) == 69 and is_wild(69)
    for one, offset in zip(envelopes(mesh), (0.016, 0.056), strict=True):
        assert one.offset == pytest.approx(offset)
        check_envelope(vertices, one.mesh, offset * np.sqrt(4 * np.pi * (1 + 0.9**2)))


def check_envelope(vertices, made, offset):
    assert number_of_handles(made.faces) == 0 and tp.components(made.faces)[0] == 1
    radius = np.linalg.norm(made.vertices, axis=1)
    assert [radius.max(), np.median(radius)] == pytest.approx([1 + offset, 1 + offset], abs=0.01)
    # It dips into the tunnels, but does not go through.
    assert radius.min() > 1
    apart = np.linalg.norm(vertices[made.vertex_ids] - made.vertices, axis=1)
    assert apart.min() > 0.9 * offset and apart.max() < 2 * offset
    assert "69 handles are more than the samples can tell apart; an envelope with 0 handles" in made.notes[-1]


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_units_do_not_matter(scale):
    vertices, faces = perforated(*icosphere(3), 20, widest=0.2)
    plain, scaled = (envelopes(repair(Mesh(vertices * s, faces)), COARSE)[0].mesh for s in (1.0, scale))
    assert number_of_handles(plain.faces) == number_of_handles(scaled.faces)
    np.testing.assert_allclose(scaled.vertices / scale, plain.vertices, atol=1e-9)


def test_wide_handles_are_left():
    mesh = repair(Mesh(*torus()))
    (made,) = envelopes(mesh, replace(COARSE, most_handles=0))
    assert number_of_handles(made.mesh.faces) == 1 and not is_wild(1)
    assert made.offset == EnvelopeParameters().wide


def test_points_leave_no_gap():
    rng = np.random.default_rng(0)
    vertices, faces = rng.random((9, 3)), np.arange(9).reshape(3, 3)
    points = np.concatenate(_points_on(vertices, faces, 0.05))
    weights = rng.dirichlet(np.ones(3), 500)
    for face in faces:
        apart = np.linalg.norm((weights @ vertices[face])[:, None] - points[None], axis=2).min(axis=1)
        assert apart.max() < 0.05


def test_a_sponge_is_matched_in_its_own_numbers(tmp_path):
    """A lump with tunnels against the same lump with other tunnels, turned.

    A wide tunnel leads into the close envelope of the one, and none into that of the other: only the wide ones agree.
    """
    vertices, faces = lump(4)
    n, turn = len(vertices), rotation(3)
    first, second = (perforated(vertices, faces, 60, wide=seed == 0, seed=seed) for seed in (0, 1))
    smaller = SurfaceParameters(proxy_size=600)
    one, two = (
        mm.prepare((v, f), samples=60, resolution=2000, parameters=smaller)
        for v, f in (first, (second[0] @ turn.T, second[1]))
    )
    assert one.detail is not None and one.whole_mesh.n_file_vertices == 2 * n
    assert one.area > 1.4 * two.area and one.other.area == pytest.approx(two.other.area, rel=0.02)
    result = mm.match(one, two, votes=5000)
    assert len(np.unique(result.pairs[:, 0])) == len(np.unique(result.pairs[:, 1])) == len(result.pairs) > 50
    assert any("an envelope with 0 handles stands for the surface" in line for line in result.warnings)
    both = (
        "envelope at 0.056 sqrt(area) from the source and envelope at 0.056 sqrt(area) from the target, which fits best"
    )
    assert any(line.startswith(both) for line in result.warnings)
    dense = result.dense()
    assert np.flatnonzero(dense.vertex_map >= 0).tolist() == np.unique(one.whole_mesh.vertex_ids).tolist()
    there = dense.target_points.values(dense.target.vertices)
    true = one.whole_mesh.vertices @ turn.T
    error, outer = np.linalg.norm(there - true, axis=1) / one.scale, one.whole_mesh.vertex_ids < n
    assert error[outer].mean() < 0.02 and error[~outer].mean() < 0.02
    # The inner wall is mapped to the inner wall.
    assert (dense.vertex_map[one.whole_mesh.vertex_ids][~outer] >= n).mean() > 0.9
    one.save(tmp_path / "one.npz")
    again = mm.Surface.load(tmp_path / "one.npz")
    np.testing.assert_array_equal(again.detail.kept, one.detail.kept)
    assert isinstance(again.detail.places(again.mesh), SurfacePoints)
