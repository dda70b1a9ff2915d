"""Section 4: curvature, its maxima, and the bounds of farthest point sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import mobius_match as mm
from mobius_match.geometry.curvature import gauss_curvature
from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.geometry.laplacian import intrinsic_mesh, vertex_areas
from mobius_match.surface.parameters import SurfaceParameters
from mobius_match.surface.sampling import sample_points, thin_out
from tests.shapes import bent, ellipsoid, grid, icosphere, lump, renumbered, rotation

PARAMETERS = SurfaceParameters()


def test_sphere_has_constant_curvature_that_integrates_to_four_pi():
    mesh = intrinsic_mesh(*icosphere(4))
    areas = vertex_areas(mesh)
    curvature = gauss_curvature(mesh, PARAMETERS.sampling_smoothing)  # times the area, so 4 pi on any sphere
    np.testing.assert_allclose(curvature, 4 * np.pi, rtol=0.02)
    assert curvature @ areas / areas.sum() == pytest.approx(4 * np.pi, rel=1e-9)


def test_a_rolled_sheet_has_no_curvature_at_its_boundary_either():
    vertices, faces = grid(20, 15)
    vertices[:, 2] = np.cos(vertices[:, 0] * 0.3)
    curvature = gauss_curvature(intrinsic_mesh(vertices, faces), PARAMETERS.sampling_smoothing)
    assert np.abs(curvature).max() < 0.2


def test_ellipsoid_has_its_textbook_curvature():
    axes = np.array([1.0, 1.2, 1.6])
    vertices, faces = ellipsoid(tuple(axes), 5)
    mesh = intrinsic_mesh(vertices, faces)
    expected = 1 / (axes.prod() ** 2 * (vertices**2 / axes**4).sum(axis=1) ** 2) * vertex_areas(mesh).sum()
    np.testing.assert_allclose(gauss_curvature(mesh, PARAMETERS.sampling_smoothing), expected, rtol=0.07)


def test_maxima_are_the_tips():
    """A sphere with five bumps: every bump's tip is a maximum, and the tips come first."""
    vertices, faces = lump(4)
    mesh = intrinsic_mesh(vertices, faces)
    samples = sample_points(mesh, geodesic_solver(vertices, faces), 40, PARAMETERS)
    assert samples.n_maxima >= 5
    maxima = vertices[samples.vertices[: samples.n_maxima]]
    directions = np.array([[1, 0.2, 0.1], [-0.5, 1, 0.3], [0.1, -0.6, 1], [-0.3, -0.4, -1], [0.3, -1, -0.3]])
    for direction in directions:
        cosine = maxima @ direction / np.linalg.norm(maxima, axis=1) / np.linalg.norm(direction)
        assert cosine.max() > 0.99, f"no maximum at {direction}"


@pytest.mark.parametrize("shape", [icosphere(3), lump(3), bent(grid(20, 20))])
@pytest.mark.parametrize("method", ["heat", "dijkstra"])
def test_farthest_points_cover_and_keep_apart(shape, method):
    """After the maxima each point is the farthest: the last gap bounds the covering, and all later gaps."""
    mesh = intrinsic_mesh(*shape)
    samples = sample_points(mesh, geodesic_solver(*shape, method), 50, PARAMETERS)
    assert len(set(samples.vertices.tolist())) == 50
    gaps = []
    for k in range(max(samples.n_maxima, 1), 50):
        nearest = samples.distances[:k].min(axis=0)
        assert nearest[samples.vertices[k]] == pytest.approx(nearest.max(), rel=1e-12)
        gaps.append(nearest.max())
    assert (np.diff(gaps) <= 1e-12).all()
    assert samples.covering_radius <= gaps[-1]


def test_rotation_scale_and_numbering_give_the_same_points():
    vertices, faces = lump(3)
    (moved, moved_faces), new = renumbered((0.01 * vertices @ rotation().T, faces))
    first = sample_points(intrinsic_mesh(vertices, faces), geodesic_solver(vertices, faces), 30, PARAMETERS)
    second = sample_points(intrinsic_mesh(moved, moved_faces), geodesic_solver(moved, moved_faces), 30, PARAMETERS)
    np.testing.assert_array_equal(new[first.vertices], second.vertices)


def test_curvature_is_stable_between_triangulations():
    """Maxima of two independent triangulations of one shape lie at the same places."""
    from scipy.spatial import cKDTree

    coarse, fine = lump(4), lump(5)
    rng = np.random.default_rng(0)
    directions = fine[0] / np.linalg.norm(fine[0], axis=1, keepdims=True)
    chosen = rng.permutation(len(directions))[:3000]
    from scipy.spatial import ConvexHull

    hull = ConvexHull(directions[chosen])  # another triangulation of a random part of the vertices
    vertices, faces = fine[0][chosen], hull.simplices
    outward = np.einsum(
        "ij,ij->i",
        np.cross(*(directions[chosen][faces[:, k]] - directions[chosen][faces[:, 0]] for k in (1, 2))),
        directions[chosen][faces[:, 0]],
    )
    faces = np.where(outward[:, None] > 0, faces, faces[:, ::-1])
    found = []
    for shape in (coarse, (vertices, faces.astype(np.int64))):
        samples = sample_points(intrinsic_mesh(*shape), geodesic_solver(*shape), 40, PARAMETERS)
        found.append(shape[0][samples.vertices[: samples.n_maxima]])
    # The five strongest are the five tips in both.
    gaps = cKDTree(found[1]).query(found[0][:5])[0]
    assert gaps.max() < 0.15


def test_fewer_vertices_than_samples_gives_all_of_them():
    shape = icosphere(0)
    samples = sample_points(intrinsic_mesh(*shape), geodesic_solver(*shape), 50, PARAMETERS)
    assert sorted(samples.vertices.tolist()) == list(range(12))


def test_thinning_by_hand():
    ways = np.abs(np.subtract.outer(np.arange(7.0), np.arange(7.0)))
    nothing = np.zeros(7, bool)
    everyone = np.arange(7)
    assert thin_out(ways, 2.0, nothing, everyone).tolist() == [0, 2, 4, 6]
    assert thin_out(ways, 2.0, everyone == 3, everyone).tolist() == [0, 3, 5]
    assert thin_out(ways, 0.0, nothing, everyone).tolist() == list(range(7))
    assert thin_out(ways, 9.0, everyone > 4, everyone).tolist() == [5, 6]
    assert thin_out(ways[:0, :0], 1.0, nothing[:0], everyone[:0]).tolist() == []
    assert thin_out(ways, 2.0, nothing[:5], np.array([5, 6, 1, 0, 3])).tolist() == [5, 1, 3]


@given(
    points=arrays(float, st.tuples(st.integers(1, 25), st.just(2)), elements=st.floats(0, 1)),
    spacing=st.floats(0, 0.7),
    data=st.data(),
)
def test_thinned_points_keep_the_spacing_and_leave_no_room(points, spacing, data):
    n = len(points)
    ways = np.linalg.norm(points[:, None] - points, axis=2)
    always = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    order = np.array(data.draw(st.permutations(range(n))))
    rank = np.argsort(order)
    kept = thin_out(ways, spacing, always, order)
    assert set(order[always].tolist()) <= set(kept.tolist())
    assert (np.diff(rank[kept]) > 0).all()
    for k in range(n):
        before = [j for j in kept if j != k and (always[rank[j]] or rank[j] < rank[k])]
        crowded = bool(before) and ways[k, before].min() < spacing
        assert (k in kept) == (always[rank[k]] or not crowded)


def test_long_thin_faces_are_no_shortcuts():
    """A sheet rolled to more than half a tube, with a strip of six long faces across from one edge to the other."""
    vertices, faces = grid(40, 30)
    angle = 1.2 * np.pi * vertices[:, 0] / 40
    sheet = np.column_stack([np.cos(angle), np.sin(angle), 1.2 * np.pi * vertices[:, 1] / 40])
    assert mm.prepare((sheet, faces)).warnings == ()
    rows = 41 * np.arange(12, 15)
    left, right, above = rows, rows + 40, rows + 41
    strip = np.concatenate([np.stack([left, above, right], axis=1), np.stack([above, right + 41, right], axis=1)])
    bridged = mm.prepare((sheet, np.concatenate([faces, strip])))
    assert bridged.mesh.notes == ()
    assert len(bridged.warnings) == 1 and "shortest paths along edges" in bridged.warnings[0]
    exact = geodesic_solver(bridged.mesh.vertices, bridged.mesh.faces, "exact")(int(bridged.samples[0]))
    np.testing.assert_array_less(exact[bridged.samples[1:]], bridged.distances[0, 1:] * (1 + 1e-9))
