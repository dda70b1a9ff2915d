"""show() in a notebook gives the page, and elsewhere opens it in the browser."""

import logging
import sys
import types
import webbrowser
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

import pytest

from mobius_match.viewer import View, page


@pytest.fixture
def opened(monkeypatch, tmp_path):
    """The addresses that a browser is given."""
    addresses = []
    monkeypatch.setattr(webbrowser, "open", lambda address: addresses.append(address) or True)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return addresses


def shell(monkeypatch, **attributes):
    module = types.ModuleType("IPython")
    module.get_ipython = lambda: types.SimpleNamespace(**attributes)
    monkeypatch.setitem(sys.modules, "IPython", module)


def test_a_notebook_gets_the_page_and_no_browser(result, dense, opened, monkeypatch):
    shell(monkeypatch, kernel=object())
    assert result.show() == View(page(result))
    assert result.show(dense) == View(page(result, dense=dense))
    assert opened == []


@pytest.mark.parametrize("where", ["script", "ipython terminal", "ipython imported"])
def test_elsewhere_the_page_is_opened_in_the_browser(result, opened, monkeypatch, tmp_path, where):
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    if where == "ipython terminal":
        shell(monkeypatch)
    elif where == "ipython imported":
        shell(monkeypatch)
        sys.modules["IPython"].get_ipython = lambda: None
    assert result.show() == View(page(result))
    (address,) = opened
    path = Path(url2pathname(urlparse(address).path))
    assert path.parent == tmp_path
    assert path.suffix == ".html"
    assert path.read_text(encoding="utf-8") == page(result)


def test_without_a_browser_the_file_is_named(result, opened, monkeypatch, tmp_path, caplog):
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    with caplog.at_level(logging.WARNING):
        result.show()
    (path,) = tmp_path.iterdir()
    assert caplog.messages == [f"no browser was found; open {path} in one"]


def test_a_view_is_saved_as_the_page(result, tmp_path):
    View(page(result)).save(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text(encoding="utf-8") == page(result)
