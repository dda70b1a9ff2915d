"""The changes that the benchmarks make to meshes, and how the truth follows them."""

from pathlib import Path

import igl
import numpy as np
import pytest

from benchmarks.changes import CHANGES, cases, cut, errors, flipped, noisy
from mobius_match.errors import FormatError
from mobius_match.evaluation import Case, Truth
from mobius_match.mesh import Mesh, repair
from mobius_match.mesh.measure import areas
from mobius_match.mesh.topology import components, edge_table, genus, sides
from tests.shapes import bent, grid, lump, tube

SHAPE = lump(3)
KEEP_VERTICES = [name for name in CHANGES if not name.startswith(("decimated", "remeshed"))]
RIGID = {
    "unchanged",
    "rotated",
    "scaled by 1000",
    "vertices renumbered",
    "inside out",
    "mirrored",
    "mirrored, inside out",
}


def change(name, arrays=SHAPE):
    return CHANGES[name](*arrays, np.random.default_rng(0))


def volume(vertices, faces):
    return np.linalg.det(vertices[faces]).sum() / 6


def edges(faces):
    return set(map(tuple, edge_table(np.asarray(faces)).edges.tolist()))


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_sphere_is_one_with_agreeing_faces(name):
    faces = np.asarray(change(name).faces)
    table = edge_table(faces)
    assert genus(faces, table) == 0  # None for what is no manifold
    assert (table.counts == 2).all()
    assert components(faces, table)[0] == 1
    assert not sides(faces, table)[1].any()


@pytest.mark.parametrize("name", CHANGES)
def test_the_truth_as_matches_has_no_error_after_any_change(name):
    changed, numbers = change(name), np.arange(len(SHAPE[0]))
    truth = Truth(numbers, numbers, np.roll(numbers, 7))
    case = Case("lump-lump", "lump", Path(), Path(), changed.carry(truth))
    source, target = repair(Mesh(*SHAPE)), repair(Mesh(changed.vertices, changed.faces))
    some = numbers[::40]
    found = errors(case, source, target, np.stack([some, changed.home[some]], axis=1))
    assert (found["direct"] == 0).all()
    assert found["mirrored"].mean() > 0.1
    found = errors(case, source, target, np.stack([some, changed.home[truth.mirrored[some]]], axis=1))
    assert (found["mirrored"] == 0).all()


@pytest.mark.parametrize("name", CHANGES)
def test_points_stay_in_their_places(name):
    """A point and its vertex, both seen from the other points, are as far apart as `apart` says."""
    changed = change(name)
    places = changed.vertices[changed.home]
    if name in RIGID:
        scale = 1000 if name.startswith("scaled") else 1
        for row in (0, 100, 641):
            was = np.linalg.norm(SHAPE[0] - SHAPE[0][row], axis=1)
            assert np.linalg.norm(places - places[row], axis=1) == pytest.approx(scale * was, rel=1e-12, abs=1e-12)
    elif name in KEEP_VERTICES:
        assert np.abs(places - SHAPE[0]).max() < (0.1 if name.startswith("noise") else 1e-15)
    else:
        assert np.linalg.norm(places - SHAPE[0], axis=1) == pytest.approx(changed.apart, abs=1e-15)
        assert changed.apart.mean() > 0
        edge = np.linalg.norm(np.diff(changed.vertices[edge_table(changed.faces).edges], axis=1), axis=2).mean()
        assert changed.apart.mean() < edge / 2
    if name in KEEP_VERTICES:
        assert (changed.apart == 0).all()


def test_numbers_of_faces():
    count = len(SHAPE[1])
    assert len(change("decimated to 50 % of the faces").faces) == count // 2
    assert len(change("decimated to 25 % of the faces").faces) == count // 4
    assert len(change("refined to 4 times the faces").faces) == 4 * count
    assert len(change("remeshed").faces) == count


@pytest.mark.parametrize("name", ["decimated to 50 % of the faces", "remeshed"])
def test_other_triangulations_are_the_same_surface(name):
    changed = change(name)
    vertices, faces = np.ascontiguousarray(changed.vertices), np.ascontiguousarray(changed.faces, np.int64)
    off = np.sqrt(igl.point_mesh_squared_distance(vertices, *SHAPE)[0])
    assert off.max() < 0.02 * np.ptp(SHAPE[0], axis=0).max()
    assert areas(vertices, faces).sum() / areas(*SHAPE).sum() == pytest.approx(1, abs=0.15)
    old = set(map(tuple, SHAPE[0].round(9).tolist()))
    assert sum(tuple(row) in old for row in vertices.round(9).tolist()) < len(vertices) / 2


def test_thin_sheets_keep_their_sides():
    """Two spheres of nearly one size, one inside out in the other: the nearest vertex is often one of the wrong one."""
    vertices, faces = lump(3)
    count = len(vertices)
    both = np.vstack([vertices, 0.98 * vertices]), np.vstack([faces, faces[:, ::-1] + count])
    changed = CHANGES["decimated to 50 % of the faces"](*both, np.random.default_rng(0))
    piece = components(np.asarray(changed.faces))[1]
    outer = np.zeros(len(changed.vertices), dtype=bool)
    first = piece == piece[np.linalg.norm(changed.vertices[changed.faces], axis=2).sum(axis=1).argmax()]
    outer[np.asarray(changed.faces)[first]] = True
    assert 0 < outer.sum() < len(outer)
    assert np.mean(outer[changed.home[:count]]) > 0.99
    assert np.mean(outer[changed.home[count:]]) < 0.01


def test_orientation():
    before = volume(*SHAPE)
    assert before > 0
    for name in ("inside out", "mirrored, inside out"):
        assert volume(change(name).vertices, change(name).faces) == pytest.approx(-before)
    for name in ("unchanged", "rotated", "mirrored", "vertices renumbered"):
        assert volume(change(name).vertices, change(name).faces) == pytest.approx(before)


@pytest.mark.parametrize(("name", "sign"), [("rotated", 1), ("inside out", 1), ("mirrored", -1)])
def test_a_mirror_image_has_the_other_hand(name, sign):
    changed = change(name)
    hands = [
        np.linalg.det(np.diff(points[[0, 5, 50, 500]], axis=0)) for points in (SHAPE[0], changed.vertices[changed.home])
    ]
    assert abs(hands[0]) > 0.1
    assert hands[1] == pytest.approx(sign * hands[0])


@pytest.mark.parametrize("amount", [0.01, 0.1])
def test_noise_has_the_size_that_is_asked_for(amount):
    vertices, faces = lump(4)
    changed = noisy(vertices, faces, np.random.default_rng(1), amount)
    ends = vertices[edge_table(faces).edges]
    edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    moved = changed.vertices - vertices
    assert np.sqrt((moved**2).mean(axis=0)) == pytest.approx(np.full(3, amount * edge), rel=0.06)
    assert np.abs(moved.mean(axis=0)).max() < 0.1 * amount * edge
    assert np.array_equal(changed.faces, faces)


@pytest.mark.parametrize("arrays", [lump(3), tube(), bent(grid(20, 15, holes=((4, 4),)))])
@pytest.mark.parametrize("share", [0.05, 0.2])
def test_flips(arrays, share):
    vertices, faces = arrays
    changed = flipped(vertices, faces, np.random.default_rng(3), share)
    old, new = edges(faces), edges(changed.faces)
    asked = round(share * (edge_table(faces).counts == 2).sum())
    assert changed.vertices is vertices
    assert len(new - old) == len(old - new) == asked
    assert len(changed.faces) == len(faces)
    assert set(np.ravel(changed.faces)) == set(faces.ravel())
    table = edge_table(changed.faces)
    assert genus(changed.faces, table) == genus(faces)
    assert not sides(changed.faces, table)[1].any()
    assert (table.counts == 1).sum() == (edge_table(faces).counts == 1).sum()
    # No fold: both faces of a new edge are within 60 degrees of those that were there.
    normals = np.cross(
        vertices[changed.faces][:, 1] - vertices[changed.faces][:, 0],
        vertices[changed.faces][:, 2] - vertices[changed.faces][:, 0],
    )
    fresh = [row for row, edge in enumerate(map(tuple, table.edges.tolist())) if edge not in old]
    one, two = normals[table.edge_faces[fresh]].transpose(1, 0, 2)
    assert ((one * two).sum(axis=1) > -0.5 * np.linalg.norm(one, axis=1) * np.linalg.norm(two, axis=1)).all()


def test_flips_that_would_spoil_the_mesh_are_left_out():
    """On a flat tetrahedron the other diagonal is an edge already; on an arrow head it lies outside."""
    pillow = np.array([(1.0, 0, 0.1), (-1, 0, 0.1), (0, 1, 0), (0, -1, 0)])
    tetrahedron = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    assert np.array_equal(flipped(pillow, tetrahedron, np.random.default_rng(0), 1.0).faces, tetrahedron)
    arrow = np.array([(0.0, 0, 0), (0, 1, 0), (2, -1, 0), (-2, -1, 0)])
    two = np.array([(0, 2, 1), (0, 1, 3)])
    assert np.array_equal(flipped(arrow, two, np.random.default_rng(0), 1.0).faces, two)
    kite = arrow * (1, -1, 1) + np.array([(0, 0, 0), (0, 3, 0), (0, 0, 0), (0, 0, 0)])
    assert edges(flipped(kite, two, np.random.default_rng(0), 1.0).faces) - edges(two) == {(2, 3)}


def test_a_cut_keeps_one_side_and_numbers_lead_back():
    vertices, faces = lump(3)
    normal = (0.3, -1.0, 0.5)
    height = vertices @ normal
    plane = height.mean() + 0.1 * np.ptp(height)
    points, piece, numbers = cut(vertices, faces, normal, 0.1)
    assert np.array_equal(points, vertices[numbers])
    assert (height[numbers] >= plane).all()
    assert set(np.unique(piece)) == set(range(len(points)))
    # These are faces of the whole, turned as they were, and all of that side which hang together are there.
    whole, part = set(map(tuple, faces.tolist())), set(map(tuple, numbers[piece].tolist()))
    above = {face for face in whole if (height[list(face)] >= plane).all()}
    assert part == above
    assert 0 < len(part) < len(whole)


def test_a_cut_keeps_the_largest_piece_alone():
    """A comb of three teeth, 2, 4 and 3 wide, cut off its back: the second tooth is left."""
    teeth = tuple((x, y) for y in range(2, 6) for x in range(13) if not (x < 2 or 4 <= x < 8 or x >= 10))
    vertices, faces = grid(13, 6, holes=teeth)
    points, piece, numbers = cut(vertices, faces, (0, 1, 0), 0.0)
    assert components(piece)[0] == 1
    assert (points[:, 0].min(), points[:, 0].max()) == (4, 8)
    assert np.array_equal(vertices[numbers], points)


def test_a_cut_that_leaves_nothing_says_so():
    with pytest.raises(ValueError, match="no face"):
        cut(*lump(1), (0, 0, 1), 0.99)


def test_pairs_are_those_with_mirrored_lists(tmp_path):
    folder = tmp_path / "set"
    (folder / "corres").mkdir(parents=True)
    vertices, faces = lump(1)
    text = f"OFF\n{len(vertices)} {len(faces)} 0\n"
    text += "".join(f"{x} {y} {z}\n" for x, y, z in vertices) + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    for name in ("lump0", "lump1"):
        (folder / f"{name}.off").write_text(text)
        (folder / "corres" / f"{name}.vts").write_text("1\n2\n3\n")
    with pytest.raises(FormatError, match=r"sym\.vts"):
        cases(tmp_path)
    (folder / "corres" / "lump1.sym.vts").write_text("2\n3\n1\n")
    for given in (tmp_path, folder):
        (case,) = cases(given)
        assert (case.name, case.truth.mirrored.tolist()) == ("lump0-lump1", [1, 2, 0])
    with pytest.raises(FormatError, match="no such folder"):
        cases(tmp_path / "nothing")
