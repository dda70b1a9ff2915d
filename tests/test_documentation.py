"""The examples in docstrings run and give what they say."""

import doctest
import importlib
import pkgutil

import mobius_match


def test_docstring_examples(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = ["mobius_match", *(m.name for m in pkgutil.walk_packages(mobius_match.__path__, "mobius_match."))]
    results = {name: doctest.testmod(importlib.import_module(name)) for name in names}
    assert sum(result.attempted for result in results.values()) > 0
    assert [name for name, result in results.items() if result.failed] == []
