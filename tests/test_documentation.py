"""The pages keep their word: examples run, links hold, and lists of options and names are whole."""

import doctest
import importlib
import inspect
import pkgutil
import re
from pathlib import Path

import pytest

import mobius_match
from mobius_match.cli.match import match

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "README.md", *ROOT.glob("docs/**/*.md")))


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


def test_the_settings_page_has_every_option_of_match():
    parameters = inspect.signature(match, eval_str=True).parameters
    options = {f"--{name.replace('_', '-')}" for name in parameters} - {"--source", "--target"}
    text = (ROOT / "docs/settings.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| `(--[a-z-]+)` \|", text, re.MULTILINE)) == sorted(options)


def test_the_reference_has_every_public_name():
    text = (ROOT / "docs/api.md").read_text(encoding="utf-8")
    documented = re.findall(r"^\.\. (?:auto\w+|data):: (\w+)$", text, re.MULTILINE)
    assert sorted(documented) == sorted(mobius_match.__all__)


NUMPYDOC = {
    "GL07",  # sections in the usual order
    "GL08",  # a docstring at all
    "PR01",  # each parameter is documented,
    "PR02",  # and no other,
    "PR03",  # in the order of the signature,
    "PR07",  # with a description
    "RT01",  # what is returned,
    "RT03",  # with a description
    "SA04",  # references have a description
    "SS03",  # a summary that ends
    "YD01",  # what is yielded
}


def public():
    """The public functions and classes, and the methods and properties of these."""
    for name in mobius_match.__all__:
        thing = getattr(mobius_match, name)
        if not callable(thing):
            continue
        yield f"{thing.__module__}.{thing.__qualname__}"
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or hasattr(value, "__get__")):
                    yield f"{thing.__module__}.{thing.__qualname__}.{member}"


def test_docstrings_of_public_names_are_whole():
    validate = pytest.importorskip("numpydoc.validate").validate
    names = list(public())
    assert "mobius_match.matching.match.match" in names
    assert "mobius_match.results.surface_map.SurfaceMap.functional_map" in names
    found = {name: [text for code, text in validate(name)["errors"] if code in NUMPYDOC] for name in names}
    # Fields that only the library fills in are private.
    private = re.compile(r"Parameters \{('_\w+'(, )?)+\} not documented")
    found = {name: [text for text in texts if not private.fullmatch(text)] for name, texts in found.items()}
    assert {name: texts for name, texts in found.items() if texts} == {}


def test_the_site_is_checked_for_dead_links_and_for_what_it_would_load(tmp_path, monkeypatch):
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(ROOT / "docs/extensions"))
    (tmp_path / "a.html").write_text(
        '<a href="b.html#here">fine</a><a href="b.html#there">x</a><a href="c.html">x</a><a href="https://x.org">fine</a>'
        '<script src="https://x.org/y.js"></script><img src="b.html"><img src="none.png">'
    )
    (tmp_path / "b.html").write_text('<p id="here"><a href="a.html">fine</a><a href="#">fine</a>')
    (tmp_path / "c.css").write_text('@import "https://x.org/z.css"; p { background: url(local.png) }')
    assert importlib.import_module("whole").faults(tmp_path) == [
        "a.html: b.html#there: no such place on that page",
        "a.html: c.html leads nowhere",
        "a.html: loads https://x.org/y.js",
        "a.html: none.png leads nowhere",
        "c.css: loads https://x.org/z.css",
    ]
