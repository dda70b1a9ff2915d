"""The script that is shipped is built from the sources beside it."""

import hashlib
import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "viewer"
BUILT = ROOT / "src/mobius_match/viewer/viewer.js"


def digests():
    head, _, body = BUILT.read_bytes().partition(b"\n")
    return re.findall(rb"[0-9a-f]{64}", head), body


def test_the_script_is_built_from_these_sources():
    """Remade by ``make viewer``."""
    digest = hashlib.sha256()
    names = [path.name for path in SOURCES.iterdir() if path.suffix in (".mjs", ".js", ".json", ".css", ".html")]
    assert {"main.js", "scene.js", "page.html", "package-lock.json"} <= set(names)
    for name in sorted(names):
        digest.update(name.encode() + b"\0" + (SOURCES / name).read_bytes() + b"\0")
    assert digests()[0][0].decode() == digest.hexdigest(), "run make viewer"


def test_the_script_is_as_it_was_built():
    (_, built), body = digests()
    assert hashlib.sha256(body).hexdigest() == built.decode()


def test_the_script_can_stand_in_a_page_and_is_small():
    text = BUILT.read_text(encoding="ascii")
    assert "</script" not in text.lower()
    assert "<!--" not in text
    assert len(text) < 1_000_000


def test_licences_are_with_the_script():
    line = "Permission is hereby granted, free of charge, to any person obtaining a copy"
    assert line in BUILT.read_text(encoding="ascii")
    assert line in (BUILT.parent / "LICENSE.md").read_text(encoding="utf-8")


def test_the_checker_of_accessibility_is_the_locked_one_with_its_licence():
    folder = ROOT / "tests/viewer/axe"
    version = json.loads((SOURCES / "package.json").read_text(encoding="utf-8"))["devDependencies"]["axe-core"]
    assert (folder / "axe.min.js").read_text(encoding="utf-8").startswith(f"/*! axe v{version}\n")
    assert "Mozilla Public License, version 2.0" in (folder / "LICENSE").read_text(encoding="utf-8")


def test_the_lock_pins_versions_and_names_no_host():
    lock = (SOURCES / "package-lock.json").read_text(encoding="utf-8")
    assert '"resolved"' not in lock
    assert '"integrity"' in lock
    needed = json.loads((SOURCES / "package.json").read_text(encoding="utf-8"))["devDependencies"]
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in needed.values())
