"""Settings from a file."""

import json

import pytest


@pytest.fixture
def config(tmp_path):
    """Make a file of settings."""

    def make(text):
        path = tmp_path / "settings.toml"
        path.write_text(text)
        return path

    return make


@pytest.fixture
def settings(mobius, pair):
    """The settings that a quick match was made with."""

    def match(*options):
        ended = mobius("match", *pair[:2], "--votes", 2000, "--json", *options)
        assert ended.code == 0, ended.err
        return json.loads(ended.out)["settings"]

    return match


def test_settings_are_taken_from_the_file(config, settings):
    found = settings("--config", config('samples = 30\nmin-fraction = 0.2\nseed = 5\ndistance = "spherical"'))
    assert (found["samples"], found["min_fraction"], found["seed"]) == (30, 0.2, 5)
    assert found["distance"] == "spherical"


def test_the_command_line_wins(config, settings):
    found = settings("--config", config("samples = 30\nmin_fraction = 0.2"), "--samples", 25)
    assert (found["samples"], found["min_fraction"]) == (25, 0.2)


def test_a_preset_of_the_file_yields_to_its_own_settings_and_to_the_command_line(config, settings):
    file = config('preset = "paper"\nsamples = 30\nmin-fraction = 0.2')
    found = settings("--config", file, "--geodesics", "heat")
    assert (found["samples"], found["min_fraction"], found["geodesics"]) == (30, 0.2, "heat")
    assert (found["proposal"], found["triangulation"]) == ("uniform", "mesh")


def test_a_preset_of_the_command_line_wins_over_the_file(config, settings):
    file = config('samples = 30\nmin-fraction = 0.2\nproposal = "guided"\nseed = 4')
    found = settings("--config", file, "--preset", "paper", "--samples", 25)
    assert (found["samples"], found["min_fraction"], found["proposal"]) == (25, 0.4, "uniform")
    assert found["seed"] == 4  # no matter of the preset


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sample = 30", ["unknown", "'sample'", "known keys are", "min_fraction", "samples"]),
        ("[match]\nsamples = 30", ["unknown", "'match'"]),
        ("samples = 3", ["samples", "3"]),
        ('samples = "30"', ["samples", "'30'"]),
        ("samples = 30.5", ["samples", "30.5"]),
        ("seed = true", ["seed", "True"]),
        ("preset = 5", ["preset", "5"]),
        ("samples 30", ["TOML"]),
    ],
)
def test_a_wrong_file_is_refused_by_name(mobius, config, text, words):
    path = config(text)
    ended = mobius("match", "no.off", "such.off", "--config", path)
    assert ended.code == 2
    assert ended.out == ""
    for word in [str(path), *words]:
        assert word in ended.err
    assert len(ended.err.strip().split("\n")) == 1


def test_a_file_that_cannot_be_read(mobius, tmp_path):
    (tmp_path / "latin.toml").write_bytes(b'proposal = "\xe9"')
    for path in (tmp_path, tmp_path / "missing.toml", tmp_path / "latin.toml"):
        ended = mobius("match", "no.off", "such.off", "--config", path)
        assert ended.code == 2
        assert str(path) in ended.err
        assert "Traceback" not in ended.err
