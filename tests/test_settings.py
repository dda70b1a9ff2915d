"""Settings are checked when they are made, and presets give way to what is asked for."""

import pytest

from mobius_match import MatchSettings, PrepareSettings, SettingsError
from mobius_match.settings import make_settings


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
    with pytest.raises(SettingsError, match=r"'smaples'.*samples"):
        make_settings(smaples=3)
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
