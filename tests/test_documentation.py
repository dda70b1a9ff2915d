"""The examples in docstrings run and give what they say."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import mobius_match

PAGES = sorted(
    page for page in (Path(__file__).parents[1] / "README.md", *Path(__file__).parents[1].glob("docs/**/*.md"))
)


def test_docstring_examples(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    modules = (m.name for m in pkgutil.walk_packages(mobius_match.__path__, "mobius_match."))
    names = ["mobius_match", *(name for name in modules if not name.endswith("__main__"))]
    results = {name: doctest.testmod(importlib.import_module(name)) for name in names}
    assert sum(result.attempted for result in results.values()) > 0
    assert [name for name, result in results.items() if result.failed] == []


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def test_the_readme_has_an_example():
    assert blocks(PAGES[0])


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.name)
def test_examples_of_the_pages(page, tmp_path, monkeypatch):
    """The Python blocks of a page run one after the other, as a reader would run them."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks(page):
        exec(compile(block, str(page), "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_to_files_hold(page):
    for link in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        assert link.startswith("https://") or (page.parent / link).exists(), f"{page.name} links to {link}"
