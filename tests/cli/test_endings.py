"""Exit codes, the one line that goes with them, and what is left on the disk."""

import os
import signal
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest

import mobius_match as mm
from mobius_match.cli.common import exit_code, option_names
from mobius_match.cli.signals import Terminated
from mobius_match.errors import MobiusError

LONG = ("--preset", "paper", "--samples", 60, "--votes", 10**9)


def ended_with(ended, code, *words):
    """Check the exit code, that one line on standard error has the words, and that there is nothing else."""
    assert ended.code == code, ended.err
    assert ended.out == ""
    assert len(ended.err.strip().split("\n")) == 1, ended.err
    for word in words:
        assert str(word) in ended.err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--samples", 3], ["samples", "3"]),
        (["--votes", 0], ["votes"]),
        (["--proposal", "best"], ["proposal", "guided", "uniform"]),
        (["--preset", "papers"], ["preset", "paper"]),
        (["--distance", "manhattan"], ["distance", "euclidean", "spherical"]),
        (["--min-fraction", 1.5], ["--min-fraction", "1.5"]),
        (["--min-fraction", "nan"], ["--min-fraction", "nan"]),
        (["--geodesics", "exactly"], ["geodesics", "heat", "dijkstra"]),
        (["--triangulation", "none"], ["triangulation", "delaunay", "mesh"]),
        (["--assignment", "none"], ["assignment", "greedy", "linear"]),
        (["--threshold", -1], ["threshold"]),
        (["--seed", -1], ["seed"]),
        (["--jobs", 0], ["jobs"]),
        (["--picture", "matches.jpg"], ["matches.jpg", ".png"]),
        (["-o", "missing/result.json"], ["missing", "does not exist"]),
        (["-o", "."], ["directory"]),
        (["--picture", "missing/matches.png"], ["missing", "does not exist"]),
        (["-o", "same.png", "--picture", "same.png"], ["same.png"]),
    ],
)
def test_wrong_values_are_refused_before_any_mesh_is_read(mobius, options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ended_with(mobius("match", "no.off", "such.off", *options), 2, *words)


@pytest.mark.parametrize(
    "arguments",
    [[], ["match"], ["match", "one.off"], ["match", "a", "b", "--sample", 3], ["guess"], ["info"]],
)
def test_wrong_usage(mobius, arguments):
    ended = mobius(*arguments)
    assert ended.code == 2
    assert "Usage: mobius" in ended.out + ended.err
    assert "Traceback" not in ended.err


def test_number_that_is_none(mobius):
    ended = mobius("match", "a.off", "b.off", "--samples", "many")
    assert ended.code == 2
    assert "--samples" in ended.err
    assert "integer" in ended.err


@pytest.mark.parametrize("option", ["-o", "--picture"])
@pytest.mark.parametrize("role", [0, 1])
def test_an_input_is_not_overwritten(mobius, pair, tmp_path, option, role):
    inputs = [tmp_path / "one.png", tmp_path / "two.png"]
    for path, original in zip(inputs, pair[:2], strict=True):
        path.write_bytes(original.read_bytes())
    other = tmp_path / "link.png"
    other.symlink_to(inputs[role])
    before = inputs[role].read_bytes()
    ended_with(mobius("match", *inputs, option, other), 2, other, "input")
    assert inputs[role].read_bytes() == before


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of folders are of POSIX")
@pytest.mark.skipif(getattr(os, "geteuid", int)() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(mobius, tmp_path):
    tmp_path.chmod(0o500)
    ended_with(mobius("match", "a.off", "b.off", "-o", tmp_path / "result.json"), 2, "cannot be written")
    tmp_path.chmod(0o700)


@pytest.mark.parametrize("role", [0, 1])
def test_unusable_input_leaves_the_old_output(mobius, pair, broken, klein, tmp_path, role):
    folder = tmp_path / "results"
    folder.mkdir()
    output, picture = folder / "result.json", folder / "matches.png"
    output.write_text("an older result")
    for bad, words in [
        (broken, [broken]),
        (klein, ["klein.off", "one side"]),
        (tmp_path / "no.off", ["no.off"]),
    ]:
        inputs = [pair[0], pair[0]]
        inputs[role] = bad
        ended_with(mobius("match", *inputs, "-o", output, "--picture", picture), 3, *words)
    assert list(folder.iterdir()) == [output]
    assert output.read_text() == "an older result"


def test_nothing_found(mobius, pair, tmp_path):
    output = tmp_path / "result.json"
    options = ("--samples", 40, "--votes", 10, "--proposal", "uniform", "--min-fraction", 1)
    ended_with(mobius("match", *pair[:2], *options, "-o", output), 4, "one.off", "two.off")
    assert not output.exists()


def test_a_failing_picture_leaves_no_file(mobius, pair, tmp_path, monkeypatch):
    monkeypatch.setattr("mobius_match.cli.match.draw", lambda result: b"" / 2)
    options = ("--samples", 20, "--votes", 500, "--picture", tmp_path / "p.png", "-o", tmp_path / "r.json")
    assert mobius("match", *pair[:2], *options).code == 1
    assert list(tmp_path.iterdir()) == []


def test_a_defect_is_one_line_and_a_traceback_on_demand(mobius, pair, monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("boom\nand more")

    monkeypatch.setattr("mobius_match.matching.match.match", fail)
    ended_with(mobius("match", *pair[:2]), 1, "internal error: RuntimeError: boom and more", "--verbose")
    shown = mobius("match", *pair[:2], "--verbose")
    assert shown.code == 1
    assert "Traceback" in shown.err
    assert "in fail" in shown.err
    assert shown.err.strip().split("\n")[-1].startswith("internal error: RuntimeError")


def test_every_error_of_the_package_has_its_code():
    codes = {kind.__name__: exit_code(kind("")) for kind in _family(MobiusError)}
    assert codes == {
        "MobiusError": 1,
        "MeshError": 3,
        "FormatError": 3,
        "TopologyError": 3,
        "SettingsError": 2,
        "NothingFoundError": 4,
        "MissingPackageError": 1,
    }


def _family(kind):
    return {kind}.union(*map(_family, kind.__subclasses__()))


def test_a_device_is_written_to_and_not_replaced(mobius, pair):
    quick = ("--samples", 20, "--votes", 500)
    assert mobius("match", *pair[:2], *quick, "-o", os.devnull).code == 0
    assert Path(os.devnull).is_char_device()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
def test_a_full_disk(mobius, pair):
    ended_with(mobius("match", *pair[:2], "--samples", 20, "--votes", 500, "-o", "/dev/full"), 1, "No space left")


def test_output_goes_through_a_link(mobius, pair, tmp_path):
    real, link = tmp_path / "real.json", tmp_path / "link.json"
    real.write_text("old")
    link.symlink_to(real)
    assert mobius("match", *pair[:2], "--samples", 20, "--votes", 500, "-o", link).code == 0
    assert link.is_symlink()
    assert real.read_text().startswith("{")


@pytest.mark.parametrize(
    ("sent", "code", "word"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")]
)
def test_interruption_at_work(start_mobius, pair, tmp_path, sent, code, word):
    """On a terminal, where progress is shown: wait for the voting, then interrupt it."""
    pty = pytest.importorskip("pty")
    terminal, theirs = pty.openpty()
    output = tmp_path / "result.json"
    process = start_mobius("match", *pair[:2], *LONG, "-o", output, stderr=theirs)
    os.close(theirs)
    seen = _read_until(terminal, "voting")
    process.send_signal(sent)
    too_long = threading.Timer(60, process.kill)
    too_long.start()
    rest = _read_until(terminal, None)  # to its end: a terminal that nobody reads fills up and blocks
    too_long.cancel()
    assert process.wait(timeout=60) == code
    os.close(terminal)
    assert rest.strip().endswith(word)
    assert "Traceback" not in seen + rest
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("error", "code", "line"), [(KeyboardInterrupt, 130, "interrupted\n"), (Terminated, 143, "terminated\n")]
)
def test_interruption_before_work(mobius, monkeypatch, error, code, line):
    def stop(**_):
        raise error

    monkeypatch.setattr("mobius_match.cli.app.app", stop)
    assert mobius("match", "a.off", "b.off") == (code, "", line)


def _read_until(terminal, word):
    """Read a terminal until a word has come, or all of it."""
    seen = ""
    while word is None or word not in seen:
        try:
            piece = os.read(terminal, 4096).decode()
        except OSError:  # how a terminal ends on Linux
            piece = ""
        if not piece:
            assert word is None, f"{word!r} never came: {seen}"
            break
        seen += piece
    return seen


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGPIPE")
def test_a_closed_pipe_ends_quietly(start_mobius, pair):
    process = start_mobius("match", *pair[:2], "--samples", 40, "--votes", 500, "--json", "--quiet")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(timeout=60) == 128 + signal.SIGPIPE


def test_no_colours_and_no_progress_where_there_is_no_terminal(start_mobius, pair):
    process = start_mobius("match", *pair[:2], "--samples", 40, "--votes", 500)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "\x1b" not in out + err
    assert "\r" not in out + err
    assert "voting" not in err


@pytest.mark.parametrize(
    ("command", "arguments", "value", "shown"),
    [
        ("match", ("no.off", "such.off", "--threshold", 2), {"threshold": 2.0}, "--threshold is 2.0"),
        ("match", ("no.off", "such.off", "--min-fraction", 2), {"min_fraction": 2.0}, "--min-fraction is 2.0"),
        ("symmetry", ("no.off", "--samples", 1), {"samples": 1}, "--samples is 1"),
        ("prepare", ("no.off", "-o", ".", "--geodesics", "flat"), {"geodesics": "flat"}, "--geodesics is 'flat'"),
    ],
)
def test_python_names_the_argument_and_the_command_its_option(mobius, command, arguments, value, shown):
    with pytest.raises(mm.SettingsError) as error:
        mm.match("no.off", "such.off", **value)
    (name, given), *_ = value.items()
    assert str(error.value).startswith(f"`{name}` is {given!r}; ")
    rest = str(error.value).split(";")[1]
    assert mobius(command, *arguments).err == f"error: {shown};{rest}\n"


def test_a_hint_names_the_options_of_the_command(mobius, pair):
    options = {"samples": 40, "votes": 10, "proposal": "uniform", "min_fraction": 1}
    with pytest.raises(mm.NothingFoundError, match="lower `min_fraction` or raise `votes`"):
        mm.match(*pair[:2], **options)
    words = [part for name, value in options.items() for part in (f"--{name.replace('_', '-')}", value)]
    assert "lower --min-fraction or raise --votes" in mobius("match", *pair[:2], *words).err


def test_warnings_of_a_result_name_the_options_of_the_command(mobius, pair, monkeypatch):
    from mobius_match.matching import match as module

    found = mm.match(*pair[:2], samples=30, votes=2000)
    warned = replace(found, warnings=("ambiguous; give `landmarks`, or a `flag` or `alternatives` to `mobius`",))
    monkeypatch.setattr(module, "match", lambda *_, **__: warned)
    ended = mobius("match", *pair[:2])
    assert ended.err == "ambiguous; give --landmarks, or a `flag` or --alternatives to `mobius`\n"


def test_arguments_have_the_names_of_the_usage_line():
    from mobius_match.cli.bench import bench
    from mobius_match.cli.match import match

    assert option_names(match)["source"] == "SOURCE"
    assert option_names(match)["min_fraction"] == "--min-fraction"
    assert option_names(bench)["output"] == "--output"
