"""Surfaces that are prepared already: settings that cannot take effect are refused, and results record the others."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.mesh.writing import mesh_files
from tests.shapes import lump, rotation

FEW = {"samples": 30, "geodesics": "dijkstra"}
REST = {"triangulation": "delaunay", "placement": "mean", "resolution": 8000, "pieces": "largest"}
PREPARATION = ("samples", "geodesics", "triangulation", "placement", "resolution", "pieces")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two mesh files, one.ply and two.ply, and each prepared with 30 and with 40 samples."""
    folder = tmp_path_factory.mktemp("meshes")
    vertices, faces = lump(3)
    for name, turned in (("one", vertices), ("two", vertices @ rotation(1).T)):
        for path, content in mesh_files(folder / f"{name}.ply", turned, faces).items():
            path.write_bytes(content)
        mm.prepare(folder / f"{name}.ply", **FEW).save(folder / f"{name}-30.npz")
        mm.prepare(folder / f"{name}.ply", samples=40).save(folder / f"{name}-40.npz")
    return folder


def rematched(result, folder):
    result.save(folder / "result.json")
    return mm.rematch(mm.Correspondence.load(folder / "result.json"))


def assert_same(first, second):
    for name in ("pairs", "confidence", "kind"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert first.settings == second.settings


@pytest.mark.parametrize("loaded", [False, True])
def test_results_of_prepared_surfaces_record_their_settings_and_are_matched_again(folder, loaded):
    surfaces = [folder / f"{name}-30.npz" for name in ("one", "two")]
    if loaded:
        surfaces = [mm.Surface.load(path) for path in surfaces]
    result = mm.match(*surfaces, seed=2, threshold=0.1)
    assert {name: result.settings[name] for name in PREPARATION} == {
        **FEW,
        **REST,
    }
    assert result.warnings == ()
    assert_same(rematched(result, folder), result)
    assert_same(mm.match(folder / "one.ply", folder / "two.ply", seed=2, threshold=0.1, **FEW), result)


def test_surfaces_that_differ_are_both_recorded_and_matched_again(folder):
    result = mm.match(folder / "one-30.npz", folder / "two-40.npz", threshold=0.1)
    assert (result.settings["samples"], result.settings["geodesics"]) == (30, "dijkstra")
    target = result.settings["target_preparation"]
    assert target == {
        "samples": 40,
        "geodesics": "heat",
        **REST,
    }
    assert len(result.source.samples) == 30
    assert len(result.target.samples) == 40
    (warning,) = result.warnings
    assert warning.startswith(
        "source and target were prepared with different settings (samples 30 and 40, geodesics dijkstra and heat)"
    )
    assert_same(rematched(result, folder), result)


def test_a_mesh_beside_a_prepared_surface_is_prepared_with_the_settings_of_the_call(folder):
    alike = mm.match(folder / "one-40.npz", folder / "two.ply", samples=40, threshold=0.1)
    assert (alike.warnings, len(alike.target.samples)) == ((), 40)
    assert "target_preparation" not in alike.settings
    differing = mm.match(folder / "one-40.npz", folder / "two.ply", threshold=0.1)
    assert len(differing.target.samples) == 100
    assert "(samples 40 and 100)" in differing.warnings[0]
    assert_same(rematched(differing, folder), differing)


@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("argument", ["source", "target"])
def test_settings_that_a_prepared_surface_does_not_have_are_refused(folder, argument, loaded):
    things = {"source": folder / "one.ply", "target": folder / "two.ply"}
    file = folder / ("one-30.npz" if argument == "source" else "two-30.npz")
    things[argument] = mm.Surface.load(file) if loaded else file
    with pytest.raises(mm.SettingsError) as caught:
        mm.match(**things, samples=40, geodesics="dijkstra", seed=1)
    name = "one.ply" if argument == "source" else "two.ply"
    assert str(caught.value) == (
        f"`samples` is 40, but the {argument} {name} was prepared with `samples` 30; "
        "give the mesh itself, prepare it with `samples` 40, or set `samples` to 30"
    )


def test_a_preset_counts_as_given(folder):
    with pytest.raises(
        mm.SettingsError, match=r"^`preset` 'paper' sets `samples` to 100, .* prepare it with `preset` 'paper'"
    ):
        mm.match(folder / "one-30.npz", folder / "two-30.npz", preset="paper")
    with pytest.raises(
        mm.SettingsError, match=r"^`preset` 'paper' sets `triangulation` to 'mesh', but the source one\.ply"
    ):
        mm.match(folder / "one-30.npz", folder / "two-30.npz", preset="paper", samples=30)
    surfaces = [mm.prepare(folder / name, preset="paper", samples=30) for name in ("one.ply", "two.ply")]
    result = mm.match(*surfaces, preset="paper", samples=30, votes=20_000)
    assert_same(rematched(result, folder), result)


def test_the_papers_number_of_votes_follows_the_samples_that_are_used(folder, monkeypatch):
    monkeypatch.setattr("mobius_match.settings.PAPER_VOTES_RANGE", (0, 10**9))
    result = mm.match(*(folder / f"{name}-30.npz" for name in ("one", "two")), proposal="uniform")
    assert result.settings["votes"] == result.votes.n_triplets == 10 * 30**3


def test_prepare_refuses_what_it_would_not_do(folder):
    surface = mm.Surface.load(folder / "one-30.npz")
    assert mm.prepare(surface) is surface
    assert mm.prepare(surface, samples=30) is surface
    assert mm.prepare(surface, surface.settings) is surface
    for thing in (surface, folder / "one-30.npz"):
        for given in ({"samples": 40}, {"settings": mm.PrepareSettings(samples=40)}, {"preset": "paper"}):
            with pytest.raises(mm.SettingsError, match=r"but the mesh one\.ply was prepared with `samples` 30"):
                mm.prepare(thing, **given)


def test_prepare_puts_keywords_in_place_of_the_settings():
    surface = mm.prepare(lump(2), mm.PrepareSettings(samples=50, placement="closest"), samples=20)
    assert surface.settings == mm.PrepareSettings(samples=20, placement="closest")
    assert len(surface.samples) == 20


def test_symmetry_records_and_refuses_as_match_does(folder):
    surface = mm.prepare(folder / "one.ply", samples=60, geodesics="dijkstra")
    with pytest.raises(mm.SettingsError, match=r"^`samples` is 50, but the mesh one\.ply was .* `samples` 60; "):
        mm.symmetry(surface, samples=50)
    found = mm.symmetry(surface, seed=1)
    assert (found.settings["samples"], found.settings["geodesics"], found.settings["seed"]) == (60, "dijkstra", 1)
