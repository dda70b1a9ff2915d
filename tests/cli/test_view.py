"""``mobius view``, and the page of ``mobius match``; what a page does is tested in tests/viewer."""

import json
import re
import shutil
import webbrowser
from pathlib import Path
from urllib.parse import unquote, urlparse

import numpy as np
import pytest
from matplotlib.image import imread

QUICK = ("--samples", 30, "--votes", 4000)


@pytest.fixture(scope="module")
def made(pair, tmp_path_factory, start_once):
    """A result, its map and its page, of one match; and the mesh files beside them."""
    folder = tmp_path_factory.mktemp("made")
    for path in pair[:2]:
        shutil.copy(path, folder)
    names = {name: folder / f"result.{name}" for name in ("json", "npz", "html")}
    start_once(
        "match", folder / "one.off", folder / "two.off", *QUICK, "--alternatives",
        "-o", names["json"], "--dense", names["npz"], "--html", names["html"],
    )  # fmt: skip
    return names


@pytest.fixture(scope="module")
def start_once():
    """Run the command line in this process, for a fixture that several tests share."""

    def run(*arguments):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("sys.argv", ["mobius", *map(str, arguments)])
            from mobius_match.cli.app import app

            with pytest.raises(SystemExit) as ending:
                app()
            assert not ending.value.code

    return run


@pytest.fixture
def opened(monkeypatch):
    """What the browser was asked to open."""
    addresses = []
    monkeypatch.setattr(webbrowser, "open", lambda address: addresses.append(address) or True)
    return addresses


def test_the_page_of_a_match_and_that_of_its_files_are_one(mobius, made, tmp_path):
    page = tmp_path / "page.html"
    ended = mobius("view", made["json"], "--with-map", made["npz"], "--explain", "-o", page)
    assert ended == (0, "", f"page written to {page}\n")
    assert '"Checkerboard"' in page.read_text(encoding="utf-8")
    assert page.read_bytes() == made["html"].read_bytes()
    assert mobius("view", made["json"], "-o", "-", "--quiet").err == ""


def test_the_browser_opens_the_page(mobius, made, opened, monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    ended = mobius("view", made["json"])
    (address,) = opened
    path = Path(unquote(urlparse(address).path))
    assert ended == (0, "", f"opened {path}\n")
    assert path.parent == tmp_path
    text = path.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert "one.off" in text
    assert '"Checkerboard"' not in text
    assert '"paired"' not in text
    assert '"errors"' not in text


def test_errors_against_known_correspondence(mobius, made, tmp_path):
    known, page = tmp_path / "known.txt", tmp_path / "page.html"
    pairs = [(one["source"], one["target"]) for one in json.loads(made["json"].read_text())["correspondences"]]
    known.write_text("".join(f"{i} {j}\n" for i, j in pairs))
    assert mobius("view", made["json"], "--truth", known, "-o", page).code == 0
    (errors, *_) = re.findall(r'"errors": (\[[^\]]*\])', page.read_text(encoding="utf-8"))
    assert json.loads(errors) == [0.0] * len(pairs)


def test_a_picture_without_a_browser(mobius, made, opened, tmp_path):
    picture, page = tmp_path / "matches.png", tmp_path / "page.html"
    ended = mobius("view", made["json"], "--png", picture, "--size", "300x200")
    assert ended == (0, "", f"picture written to {picture}\n")
    front = imread(picture)
    assert front.shape[:2] == (200, 300)
    assert (np.ptp(front[:, :, :3], axis=2) > 0.25).mean() > 0.01
    ended = mobius("view", made["json"], "--png", picture, "--size", "300x200", "--view", "120,-30", "-o", page)
    assert ended == (0, "", f"picture written to {picture}\npage written to {page}\n")
    assert (np.abs(imread(picture) - front).max(axis=2) > 0.1).mean() > 0.02
    assert not opened


def test_without_a_browser_the_page_is_named(mobius, made, monkeypatch):
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    ended = mobius("view", made["json"], "--quiet")
    assert ended.code == 0
    assert "no browser was found; open " in ended.err
    Path(ended.err.split()[-3]).unlink()


def test_input_that_cannot_be_shown_is_reported(mobius, made, opened, tmp_path):
    page, png = tmp_path / "page.html", tmp_path / "page.png"
    content = json.loads(made["json"].read_text())
    moved, damaged = tmp_path / "moved.json", tmp_path / "damaged.json"
    content["source"]["path"] = str(tmp_path / "gone.off")
    moved.write_text(json.dumps(content))
    content["alternatives"] = [{"margin": 1}]
    damaged.write_text(json.dumps(content))
    for code, words, arguments in (
        (2, "change its ending", (made["json"], "-o", tmp_path / "page.txt")),
        (2, "does not exist", (made["json"], "-o", tmp_path / "nowhere" / "page.html")),
        (2, "change its ending", (made["json"], "--png", tmp_path / "page.jpg")),
        (2, "'30' is not two numbers, as in 1600x800", (made["json"], "--png", png, "--size", "30")),
        (2, "'up' is not two numbers, as in 30,15", (made["json"], "--png", png, "--view", "up")),
        (2, "two numbers in degrees", (made["json"], "--png", png, "--view", "nan,0")),
        (2, "64 to 4096", (made["json"], "--png", png, "--size", "30x5000")),
        (3, "made.json: cannot be read as text", (made["json"], "--truth", tmp_path / "made.json", "-o", page)),
        (3, "gone.off", (moved, "-o", page)),
        (3, "gone.off", (moved, "--png", png)),
        (3, "gone.off", (moved, "--explain", "-o", page)),
        (3, "damaged", (damaged, "-o", page)),
        (3, "not a readable result file", (tmp_path / "none.json", "-o", page)),
        (3, "not a readable map", (made["json"], "--with-map", made["json"], "-o", page)),
    ):
        ended = mobius("view", *arguments)
        assert words in ended.err
        assert ended.err.count("\n") == 1
        assert (ended.code, ended.out, page.exists(), opened) == (code, "", False, [])


def test_match_refuses_another_ending_at_once(mobius, pair, tmp_path):
    ended = mobius("match", *pair[:2], "--html", tmp_path / "page.pdf")
    assert ended.code == 2
    assert "change its ending" in ended.err
