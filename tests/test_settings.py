"""Settings are checked when they are made, and presets give way to what is asked for."""

import inspect
from dataclasses import fields
from typing import Unpack, get_type_hints

import pytest

import mobius_match as mm
from mobius_match import MatchSettings, PrepareSettings, SettingsError
from mobius_match.settings import (
    PRESETS,
    MatchOptions,
    PrepareOptions,
    SymmetryOptions,
    make_prepare_settings,
    make_settings,
)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("samples", 3, "from 4 to 5000"),
        ("samples", 10.0, "whole number"),
        ("samples", True, "whole number"),
        ("votes", 0, "from 1"),
        ("proposal", "lucky", "guided, uniform"),
        ("distance", "taxi", "euclidean, spherical"),
        ("min_fraction", 1.1, "from 0 to 1"),
        ("min_fraction", float("nan"), "from 0 to 1"),
        ("min_fraction", "half", "from 0 to 1"),
        ("threshold", -0.1, "from 0 to 1"),
        ("epsilon", 0, "positive"),
        ("epsilon", float("inf"), "positive"),
        ("recovery_radius", 2, "from 0 to 1"),
        ("spacing", 0.3, "from 0 to 0.2"),
        ("spacing", "near", "from 0 to 0.2"),
        ("geodesics", "guess", "heat, dijkstra"),
        ("triangulation", "best", "delaunay, mesh"),
        ("placement", "near", "mean, closest"),
        ("assignment", "best", "greedy, linear"),
        ("reflect", True, "no, yes, auto"),
        ("seed", -1, "from 0"),
        ("jobs", 0, "from 1"),
    ],
)
def test_values_out_of_range_are_named(name, value, words):
    with pytest.raises(SettingsError) as caught:
        MatchSettings(**{name: value})
    assert name in str(caught.value)
    assert repr(value) in str(caught.value)
    assert words in str(caught.value)


def test_unknown_setting_and_preset():
    with pytest.raises(SettingsError, match=r"^match has no setting 'smaples'; did you mean 'samples'\? Its .* votes$"):
        make_settings(smaples=3)
    with pytest.raises(SettingsError, match=r"^match has no setting 'colour'; its settings are assignment, .* votes$"):
        make_settings(colour="red")
    with pytest.raises(SettingsError, match=r"'journal'.*paper"):
        make_settings("journal")


def test_paper_preset_is_the_papers_and_gives_way():
    paper = make_settings("paper")
    assert (paper.proposal, paper.min_fraction, paper.distance) == ("uniform", 0.4, "euclidean")
    assert (paper.geodesics, paper.triangulation, paper.placement) == ("dijkstra", "mesh", "closest")
    assert paper.number_of_votes() == 10 * 100**3
    assert make_settings("paper", samples=80).number_of_votes() == 10 * 80**3
    assert make_settings("paper", samples=200).number_of_votes() == 20_000_000
    assert make_settings("paper", samples=20).number_of_votes() == 5_000_000
    assert make_settings("paper", distance="spherical").distance == "spherical"


def test_votes_given_are_votes_cast():
    assert MatchSettings(votes=123).number_of_votes() == 123


def test_preparation_is_the_part_that_one_mesh_depends_on():
    assert MatchSettings(samples=50, votes=7).preparation() == PrepareSettings(samples=50)


@pytest.mark.parametrize(
    ("function", "wrong", "meant"),
    [
        (lambda **settings: mm.match(None, None, **settings), "sed", "seed"),
        (lambda **settings: mm.prepare(None, **settings), "sample", "samples"),
        (lambda **settings: mm.symmetry(None, **settings), "vote", "votes"),
    ],
    ids=["match", "prepare", "symmetry"],
)
def test_a_misspelt_setting_is_refused_before_the_mesh_is_read(function, wrong, meant):
    with pytest.raises(SettingsError, match=rf"has no setting '{wrong}'; did you mean '{meant}'\?"):
        function(**{wrong: 1})


def test_settings_of_a_preparation_from_a_record_a_preset_and_keywords():
    assert make_prepare_settings(None, None, {}) == PrepareSettings()
    record = PrepareSettings(samples=50, geodesics="dijkstra")
    assert make_prepare_settings(record, None, {}) == record
    assert make_prepare_settings(record, None, {"samples": 60}) == PrepareSettings(samples=60, geodesics="dijkstra")
    assert make_prepare_settings(record, "paper", {"samples": 60}) == make_settings("paper", samples=60).preparation()
    of_match = make_prepare_settings(MatchSettings(samples=70, seed=3), None, {"resolution": 0})
    assert of_match == PrepareSettings(samples=70, resolution=0)
    assert type(of_match) is PrepareSettings
    with pytest.raises(SettingsError, match="samples"):
        make_prepare_settings(record, None, {"samples": 1})
    with pytest.raises(SettingsError, match="paper"):
        make_prepare_settings(None, "journal", {})
    with pytest.raises(SettingsError, match=r"PrepareSettings, or its fields"):
        make_prepare_settings({"samples": 50}, None, {})


@pytest.mark.parametrize(
    ("keywords", "record"), [(PrepareOptions, PrepareSettings), (MatchOptions, MatchSettings)], ids=["prepare", "match"]
)
def test_keywords_that_editors_complete_are_the_fields_of_the_records(keywords, record):
    assert get_type_hints(keywords) == get_type_hints(record)
    assert keywords.__optional_keys__ == {field.name for field in fields(record)}
    assert keywords.__required_keys__ == set()


def test_keywords_of_symmetry_are_some_of_match():
    mine, of_match = get_type_hints(SymmetryOptions), get_type_hints(MatchOptions)
    assert mine == get_type_hints(PrepareOptions) | {name: of_match[name] for name in ("votes", "seed", "jobs")}


@pytest.mark.parametrize(
    ("function", "keywords"),
    [(mm.match, MatchOptions), (mm.prepare, PrepareOptions), (mm.symmetry, SymmetryOptions)],
    ids=["match", "prepare", "symmetry"],
)
def test_functions_have_typed_keywords(function, keywords):
    *_, last = inspect.signature(function).parameters.values()
    assert last.kind is inspect.Parameter.VAR_KEYWORD
    assert get_type_hints(function)[last.name] == Unpack[keywords]


def test_presets_hold_settings_only():
    for preset in PRESETS.values():
        assert preset.keys() <= {field.name for field in fields(MatchSettings)}
        MatchSettings(**preset)
