"""Section 5 on shapes with known answers: similarity of faces, theorem 5.1, invariances, figure 5."""

import numpy as np
import pytest

from mobius_match.geometry.geodesics import geodesic_solver
from mobius_match.geometry.laplacian import intrinsic_mesh
from mobius_match.mesh.topology import boundary_loops
from mobius_match.surface.flattening import Flattening, choose_cut_face, flatten, vertex_positions
from mobius_match.voting.mobius import CANONICAL_TRIANGLE, apply, from_three_points
from tests.shapes import bent, ellipsoid, grid, icosphere, lump, renumbered, rotation, tube

TWO_HOLES = ((3, 3), (3, 4), (8, 2), (8, 3), (8, 4))
SHAPES = {
    "sphere": icosphere(3),
    "lump": lump(3),
    "disc": bent(grid()),
    "two holes": bent(grid(holes=TWO_HOLES)),
    "tube": tube(),
}


def triangles(flattening: Flattening, mesh) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the mid-edge faces in the plane (m - 1, 3) and which faces they are."""
    faces = np.flatnonzero(np.arange(len(mesh.faces)) != flattening.cut_face)
    return flattening.positions[mesh.face_edges[faces]], faces


@pytest.mark.parametrize("delaunay", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_every_mid_edge_triangle_is_similar_to_its_face(name, delaunay):
    """Zero discrete conformal error: side ratios and orientation of each face are those on the surface."""
    mesh = intrinsic_mesh(*SHAPES[name], delaunay=delaunay)
    flattening = flatten(mesh, cut_face=5)
    assert flattening.closure < 1e-12
    corners, faces = triangles(flattening, mesh)
    assert np.isfinite(corners).all()
    # The mid-edges opposite corners 0 and 1 lie apart by half the edge opposite corner 2, and so on.
    sides = np.abs(np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1))
    scale = sides.sum(axis=1) / mesh.lengths[faces].sum(axis=1)
    np.testing.assert_allclose(sides / scale[:, None], mesh.lengths[faces], rtol=1e-5)
    turn = ((corners[:, 1] - corners[:, 0]) * np.conj(corners[:, 2] - corners[:, 0])).imag
    assert len(set(np.sign(turn))) == 1, "some mid-edge faces are turned over"


@pytest.mark.parametrize("name", ["disc", "two holes", "tube"])
@pytest.mark.parametrize("delaunay", [False, True])
def test_theorem_5_1_boundaries_lie_on_horizontal_segments(name, delaunay):
    mesh = intrinsic_mesh(*SHAPES[name], delaunay=delaunay)
    on_boundary = np.flatnonzero(np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges) == 1)
    inner = next(f for f in range(len(mesh.faces)) if not np.isin(mesh.faces[f], _ends(mesh, on_boundary)).any())
    flattening = flatten(mesh, inner)
    loops = boundary_loops(SHAPES[name][1])
    assert len(loops) == {"disc": 1, "two holes": 3, "tube": 2}[name]
    extent = np.ptp(flattening.positions.imag)
    heights = []
    for loop in loops:
        edges = [e for e in on_boundary if np.isin(_ends(mesh, [e]), loop).all()]
        assert len(edges) == len(loop)
        height = flattening.positions.imag[edges]
        assert np.ptp(height) < 1e-12 * extent
        assert np.ptp(flattening.positions.real[edges]) > 0
        heights.append(height[0])
    assert len(np.unique(np.round(heights, 9))) == len(loops)


def _ends(mesh, edges):
    faces, corners = np.nonzero(np.isin(mesh.face_edges, edges))
    return np.unique(np.concatenate([mesh.faces[faces, (corners + 1) % 3], mesh.faces[faces, (corners + 2) % 3]]))


def fit_error(first: np.ndarray, second: np.ndarray, points: np.ndarray) -> float:
    """Mean distance between both flattenings of the same points (p, 3) of a surface, up to a Möbius map.

    Three points that lie far apart on the surface are moved to an equilateral triangle, and the rest is compared on
    the sphere, where no point is special.
    """
    gaps = np.linalg.norm(points[:, None] - points, axis=-1)
    a, b = np.unravel_index(gaps.argmax(), gaps.shape)
    three = [a, b, int(np.minimum(gaps[a], gaps[b]).argmax())]
    moved = [apply(from_three_points(z[three], CANONICAL_TRIANGLE), z) for z in (first, second)]
    lifted = [np.stack([2 * z.real, 2 * z.imag, np.abs(z) ** 2 - 1]) / (1 + np.abs(z) ** 2) for z in moved]
    return float(np.linalg.norm(lifted[0] - lifted[1], axis=0).mean())


def test_figure_5_cut_faces_differ_by_one_mobius_map():
    """Two flattenings of one mesh with poles far apart; finer meshes come closer to one map."""
    errors = []
    for subdivisions in (3, 4):
        vertices, faces = lump(subdivisions)
        mesh = intrinsic_mesh(vertices, faces)
        samples = np.arange(0, 642, 13)  # coarse vertices keep their numbers in finer spheres
        far = len(mesh.faces) // 2 + 7
        positions = [vertex_positions(flatten(mesh, cut), mesh, samples) for cut in (3, far)]
        errors.append(fit_error(*positions, vertices[samples]))
    assert errors[0] < 0.03
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("delaunay", [False, True])
def test_scale_rotation_and_numbering_do_not_matter(delaunay):
    vertices, faces = lump(3)
    (moved, moved_faces), new = renumbered((250 * vertices @ rotation().T + [1, 2, 3], faces))
    first, second = (
        intrinsic_mesh(vertices, faces, delaunay=delaunay),
        intrinsic_mesh(moved, moved_faces, delaunay=delaunay),
    )
    samples = np.arange(0, len(vertices), 7)
    corners = first.faces[10]
    twin = np.flatnonzero((np.sort(second.faces, axis=1) == np.sort(new[corners])).all(axis=1))[0]
    a = vertex_positions(flatten(first, 10), first, samples)
    b = vertex_positions(flatten(second, int(twin)), second, new[samples])
    assert fit_error(a, b, vertices[samples]) < 1e-9


def test_sphere_flattens_to_stereographic_projection():
    """The cut face goes to infinity, so positions are a Möbius map of the projection from its centre."""
    errors = []
    for subdivisions in (3, 5):
        vertices, faces = icosphere(subdivisions)
        mesh = intrinsic_mesh(vertices, faces)
        samples = np.arange(642)
        pole = vertices[mesh.faces[0]].mean(axis=0)
        pole /= np.linalg.norm(pole)
        right = np.cross(pole, [0.3, 0.2, 0.9])
        right /= np.linalg.norm(right)
        up = np.cross(pole, right)
        height = vertices[samples] @ pole
        projected = (vertices[samples] @ right + 1j * (vertices[samples] @ up)) / (1 - height)
        error = min(
            fit_error(vertex_positions(flatten(mesh, 0), mesh, samples), side, vertices[samples])
            for side in (projected, projected.conj())
        )
        errors.append(error)
    assert errors[0] < 0.1
    assert errors[1] < 0.3 * errors[0]


def test_tube_keeps_its_conformal_modulus():
    """Length over circumference is what flattenings of a cylinder share, whatever its radius and triangles."""
    samples = (np.arange(1, 20, 3)[:, None] * 24 + np.arange(0, 24, 4)).ravel()
    fine_samples = (np.arange(1, 20, 3)[:, None] * 2 * 48 + np.arange(0, 48, 8)).ravel()

    def flat(shape, cut, wanted):
        # On the mesh's own triangles: all quads are ties for Delaunay, and the place of the cut matters here.
        mesh = intrinsic_mesh(*shape, delaunay=False)
        return vertex_positions(flatten(mesh, cut), mesh, wanted)

    points = tube()[0][samples]
    reference = flat(tube(24, 20), 240, samples)
    wide = flat(tube(24, 20, radius=5.0, length=20.0), 240, samples)
    fine = flat(tube(48, 40), 960, fine_samples)
    longer = flat(tube(24, 20, length=8.0), 240, samples)
    assert fit_error(reference, wide, points) < 1e-9
    assert fit_error(reference, fine, points) < 0.05
    assert fit_error(reference, longer, points) > 0.2


def test_ellipsoids_mirror_image_flattens_to_the_conjugate():
    vertices, faces = ellipsoid()
    mirrored = vertices * [-1, 1, 1]
    samples = np.arange(0, len(vertices), 11)
    first, second = intrinsic_mesh(vertices, faces), intrinsic_mesh(mirrored, faces[:, [0, 2, 1]])
    cut = np.flatnonzero((np.sort(second.faces, axis=1) == np.sort(first.faces[4])).all(axis=1))[0]
    a = vertex_positions(flatten(first, 4), first, samples)
    b = vertex_positions(flatten(second, int(cut)), second, samples)
    assert fit_error(a.conj(), b, vertices[samples]) < 1e-9
    assert fit_error(a, b, vertices[samples]) > 0.1


def test_cut_face_is_at_the_most_central_vertex():
    vertices, faces = tube(around=16, along=30)
    mesh = intrinsic_mesh(vertices, faces)
    solver = geodesic_solver(vertices, faces)
    average = np.mean([solver(v) for v in range(0, len(vertices), 9)], axis=0)
    cut = choose_cut_face(mesh, average)
    assert np.argmin(average) in mesh.faces[cut]
    assert abs(vertices[mesh.faces[cut], 2].mean() - 2.0) < 0.3


def test_cut_face_is_none_that_holds_a_vertex_of_its_own():
    """An ear: a triangle that shares one edge with a grid. Cut out, its tip would have no place."""
    vertices, faces = grid()
    tip = len(vertices)
    vertices = np.vstack([vertices, [5.5, -0.9, 0.0]])
    mesh = intrinsic_mesh(vertices, np.vstack([faces, [6, 5, tip]]), delaunay=False)
    cut = choose_cut_face(mesh, np.linalg.norm(vertices - [5.4, -0.5, 0.0], axis=1))
    assert 5 in mesh.faces[cut]
    assert tip not in mesh.faces[cut]
    assert np.isfinite(vertex_positions(flatten(mesh, cut), mesh, np.arange(tip + 1))).all()


def test_samples_keep_apart_in_the_plane_where_the_cut_is_central():
    vertices, faces = lump(4)
    mesh = intrinsic_mesh(vertices, faces)
    samples = np.arange(100)
    positions = vertex_positions(flatten(mesh, 0), mesh, samples)
    gaps = np.abs(positions[:, None] - positions) + 9 * np.eye(100)
    assert gaps.min() > 1e-12 * np.ptp(positions.real)


def test_placements():
    """The closest mid-edge is one of the mid-edges; the mean of a flat regular ring is the vertex itself."""
    vertices, faces = bent(grid())
    mesh = intrinsic_mesh(vertices, faces, delaunay=False)
    flattening = flatten(mesh, 100)
    wanted = np.array([30, 45, 60])
    closest = vertex_positions(flattening, mesh, wanted, "closest")
    assert np.isin(closest, flattening.positions).all()
    for vertex, position in zip(wanted, closest, strict=True):
        edge = np.flatnonzero(flattening.positions == position)[0]
        assert vertex in _ends(mesh, [edge])
        length = mesh.lengths[mesh.face_edges == edge][0]
        around = mesh.faces == vertex
        sides = np.roll(around, 1, axis=1) | np.roll(around, 2, axis=1)
        assert length == pytest.approx(mesh.lengths[sides].min())
    mean = vertex_positions(flattening, mesh, wanted, "mean")
    assert (np.abs(mean - closest) < np.ptp(flattening.positions.real) / 4).all()
