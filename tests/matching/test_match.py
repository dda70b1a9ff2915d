"""The whole method on shapes whose correspondence is known."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.geometry.geodesics import geodesic_solver
from tests.shapes import bent, grid, lump, renumbered, rotation, tube

PAPER = {"preset": "paper", "votes": 300_000, "samples": 30}
"""The paper's method, cut down to what a copy of a shape needs."""


def moved_copy(shape, seed=0):
    (vertices, faces), new = renumbered(shape, seed)
    return (3.7 * vertices @ rotation(seed).T + [5, -2, 1], faces), new


@pytest.mark.parametrize("seed", [0, 1])
def test_copy_rotated_scaled_and_renumbered_is_the_identity(seed):
    shape = lump(4)
    copy, new = moved_copy(shape, seed)
    result = mm.match(shape, copy, seed=seed)
    assert len(result) >= 90
    np.testing.assert_array_equal(new[result.pairs[:, 0]], result.pairs[:, 1])
    assert result.confidence.min() > 0.9
    assert (np.diff(result.confidence) <= 0).all()


@pytest.mark.parametrize(
    "options",
    [
        {**PAPER},
        {**PAPER, "distance": "spherical"},
        {**PAPER, "assignment": "linear"},
        {"distance": "spherical"},
        {"assignment": "linear"},
        {"triangulation": "mesh", "geodesics": "dijkstra", "placement": "closest"},
        {"min_fraction": 0.3, "samples": 60},
    ],
    ids=str,
)
def test_every_variant_finds_a_copy(options):
    shape = lump(3)
    copy, new = moved_copy(shape)
    result = mm.match(shape, copy, **options)
    assert len(result) >= 20
    correct = new[result.pairs[:, 0]] == result.pairs[:, 1]
    assert correct[: len(correct) // 2].all()
    assert correct.mean() > 0.9


@pytest.mark.parametrize("shape", [bent(grid(16, 13)), bent(grid(16, 13, holes=((4, 4), (11, 7), (11, 8))))])
def test_surfaces_with_boundaries_find_their_copy(shape):
    copy, _ = moved_copy(shape)
    result = mm.match(shape, copy, samples=60)
    # A sheet that waves in one direction is bent without stretching in it: its intrinsic mirror images match as well,
    # so distances are what must agree.
    first = np.array([geodesic_solver(*shape)(int(v))[result.pairs[:20, 0]] for v in result.pairs[:20, 0]])
    second = np.array([geodesic_solver(*copy)(int(v))[result.pairs[:20, 1]] for v in result.pairs[:20, 1]])
    np.testing.assert_allclose(second / 3.7, first, atol=0.06 * first.max())


@pytest.mark.parametrize("name", examples.names())
def test_shipped_pairs_have_small_errors(shipped_match, name):
    """Other poses, other triangulations: geodesic errors per diameter against the exact truth."""
    result = shipped_match(name)
    mesh = result.target.mesh
    faces, barycentric = examples.truth(name)
    solver = geodesic_solver(mesh.vertices, mesh.faces)
    errors = []
    for i, j in result.pairs[:45]:
        distances = solver(int(j))
        errors.append(distances[mesh.faces[faces[i]]] @ barycentric[i] / result.target_info["diameter"])
    assert np.mean(errors[:15]) < 0.02
    assert np.mean(errors) < 0.025
    assert max(errors) < 0.1


@pytest.mark.parametrize("options", [{}, {"preset": "paper", "votes": 60_000}])
def test_same_seed_same_result_whatever_the_threads(quadruped, options):
    surfaces = quadruped
    if options:
        surfaces = [mm.prepare(surface.mesh, preset=options["preset"]) for surface in quadruped]
    results = [mm.match(*surfaces, seed=5, jobs=jobs, **options) for jobs in (1, 2, 1, 3)]
    if not options:
        results.append(mm.match(*examples.paths("quadruped"), seed=5, jobs=2))
    for other in results[1:]:
        np.testing.assert_array_equal(results[0].pairs, other.pairs)
        np.testing.assert_array_equal(results[0].confidence, other.confidence)  # to the last bit
        np.testing.assert_array_equal(results[0].kind, other.kind)
    different = mm.match(*surfaces, seed=6, jobs=2, **options)
    assert (different.votes.matrix != results[0].votes.matrix).any()


def test_vertex_numbers_are_those_of_the_input():
    """Unused vertices in front shift every number by as many."""
    shape = lump(3)
    result = mm.match(shape, shape, samples=30)
    padded = (np.concatenate([np.full((5, 3), 9.0), shape[0]]), shape[1] + 5)
    shifted = mm.match(padded, shape, samples=30)
    np.testing.assert_array_equal(shifted.pairs, result.pairs + np.array([5, 0]))
    assert any("5 unused vertices" in line for line in shifted.warnings)
    assert shifted.source_info["vertices"] == len(shape[0]) + 5


def test_anything_with_vertices_and_faces_will_do():
    import trimesh

    vertices, faces = lump(3)
    arrays = mm.match((vertices, faces), (vertices.tolist(), faces.tolist()), samples=30)
    objects = mm.match(trimesh.Trimesh(vertices, faces, process=False), mm.Mesh(vertices, faces), samples=30)
    np.testing.assert_array_equal(arrays.pairs, objects.pairs)


def test_nothing_found_says_what_to_do():
    with pytest.raises(mm.NothingFoundError, match=r"50 triplets.*`min_fraction`"):
        mm.match(lump(2), tube(), preset="paper", votes=50, min_fraction=1.0, samples=30)


@pytest.mark.parametrize("spacing", [0.0, 0.025, 0.06, 0.2])
def test_matches_between_the_samples_keep_their_distance(person, spacing):
    result, few = (mm.match(*person, threshold=0.0, spacing=one) for one in (spacing, 0.2))
    source = person[0]
    sampled = np.isin(result.pairs[:, 0], source.mesh.vertex_ids[source.samples])
    assert np.isin(few.pairs[:, 0], source.mesh.vertex_ids[source.samples]).all()
    # No sample is left out, unless a match of higher confidence has the same vertex of the target.
    assert sampled.sum() >= 0.95 * len(few)
    places = np.searchsorted(source.proxy, np.searchsorted(source.mesh.vertex_ids, result.pairs[:, 0]))
    ways = source.proxy_geodesics[np.ix_(places, places)] + np.diag(np.full(len(places), np.inf))
    assert (ways[~sampled] >= spacing).all()
    # As many as there is room for: each vertex of the proxy without a match lies close to one with a match.
    left = np.setdiff1d(np.arange(len(source.proxy)), places)
    if spacing:
        assert (source.proxy_geodesics[np.ix_(left, places)].min(axis=1) < spacing + 0.02).all()
    assert len(result) == pytest.approx({0.0: 1170, 0.025: 600, 0.06: 180, 0.2: 100}[spacing], rel=0.1)
    assert (np.diff(result.confidence) <= 0).all()


def test_no_match_that_is_likely_says_what_to_do():
    with pytest.raises(mm.NothingFoundError, match=r"likely enough.*`threshold`"):
        mm.match(lump(3), tube(), threshold=1.0)


def test_alternatives_without_a_likely_match_are_empty(person, shipped_match):
    """With a threshold that the most confident match of the chosen alignment reaches, and none of the alternative's."""
    usual = shipped_match("person")
    assert [len(one.pairs) > 0 for one in usual.alternatives] == [True]
    result = mm.match(*person, seed=0, threshold=float(usual.confidence.max()))
    assert len(result) > 0
    assert [len(one.pairs) for one in result.alternatives] == [0]


def test_small_meshes_use_all_their_vertices_and_say_so():
    result = mm.match(lump(1), lump(1))
    assert any("only 42 vertices" in line for line in result.warnings)
    np.testing.assert_array_equal(result.pairs[:, 0], result.pairs[:, 1])


def test_tiny_and_huge_units_do_not_matter():
    vertices, faces = lump(3)
    reference = mm.match((vertices, faces), (vertices, faces), samples=40)
    for scale in (1e-12, 1e12):
        scaled = mm.match((scale * vertices, faces), (vertices, faces), samples=40)
        np.testing.assert_array_equal(scaled.pairs, reference.pairs)
        assert scaled.source_info["area"] == pytest.approx(scale**2 * reference.source_info["area"], rel=1e-6)


def test_progress_is_reported_from_start_to_end():
    calls = []
    mm.match(lump(2), lump(2), progress=lambda *call: calls.append(call))
    stages = [stage for stage, _, _ in calls]
    assert stages[0].startswith("sampling")
    assert stages[-1] == "voting"
    assert calls[-1][1] == calls[-1][2] > 0
    assert all(0 <= done <= total for _, done, total in calls)


def test_an_error_in_progress_ends_the_match_at_once():
    """How Ctrl-C reaches the voting threads: what the callback raises comes out, and no thread goes on."""

    def interrupt(stage, done, total):
        if stage == "voting":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mm.match(lump(2), lump(2), preset="paper", progress=interrupt)


@pytest.fixture
def loaded(tmp_path):
    """A loaded result of two files, and what was saved."""
    for name in ("one.off", "two.off"):
        vertices, faces = lump(2)
        vertices = vertices @ rotation(1) if name == "two.off" else vertices
        lines = [f"OFF\n{len(vertices)} {len(faces)} 0", *(" ".join(map(repr, row)) for row in vertices.tolist())]
        (tmp_path / name).write_text("\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in faces.tolist())]) + "\n")
    result = mm.match(tmp_path / "one.off", tmp_path / "two.off", samples=40, seed=5, threshold=0.4)
    result.save(tmp_path / "result.json")
    return mm.Correspondence.load(tmp_path / "result.json"), result, tmp_path


def test_a_loaded_result_is_matched_again_to_the_last_bit(loaded):
    again, result = mm.rematch(loaded[0]), loaded[1]
    for name in ("pairs", "confidence", "kind"):
        np.testing.assert_array_equal(getattr(again, name), getattr(result, name))
    assert again.settings == result.settings
    np.testing.assert_array_equal(again.dense().positions, result.dense().positions)
    with pytest.raises(mm.SettingsError, match="rematch"):
        loaded[0].dense()


def test_changed_and_missing_files_are_not_matched_again(loaded):
    result, _, folder = loaded
    with (folder / "two.off").open("a") as file:
        file.write("\n")
    with pytest.raises(mm.MeshError, match=r"two\.off: the file has changed since the match"):
        mm.rematch(result)
    (folder / "two.off").unlink()
    with pytest.raises(mm.FormatError, match=r"two\.off: no such file"):
        mm.rematch(result)
    arrays = mm.match(lump(2), lump(2), samples=20)
    with pytest.raises(mm.MeshError, match="given as arrays"):
        mm.rematch(arrays)
