"""The method's page and the code agree: every parameter stands on both sides, with the same value."""

import importlib
import inspect
import pkgutil
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import fields, is_dataclass
from operator import attrgetter
from pathlib import Path

import pytest

import mobius_match

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs/method.md").read_text(encoding="utf-8")


def records():
    """Every record of parameters by its name."""
    found = {}
    for module in pkgutil.walk_packages(mobius_match.__path__, "mobius_match."):
        if module.name.endswith(".parameters") and "._core." not in module.name:
            for name, record in inspect.getmembers(importlib.import_module(module.name), is_dataclass):
                if inspect.isclass(record) and name.endswith("Parameters"):
                    found[name] = record()
    return found


def numbers(value):
    """The numbers of a parameter in their order: of a tuple, or of a record that belongs to it."""
    if is_dataclass(value):
        return [number for one in fields(value) for number in numbers(getattr(value, one.name))]
    return [number for one in value for number in numbers(one)] if isinstance(value, tuple) else [value]


def described():
    """The numbers of each parameter in the tables of the page, by ``Record.parameter``."""
    rows = re.findall(r"^\|[^|]*\| `(\w+Parameters\.[\w.]+)` \|(.+)\|$", TEXT, re.MULTILINE)
    return {name: [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", cells)] for name, cells in rows}


def test_the_page_has_the_values_of_the_code():
    for name, values in described().items():
        record, _, path = name.partition(".")
        assert values == [float(number) for number in numbers(attrgetter(path)(records()[record]))], name


def test_the_page_has_every_parameter():
    missing = []
    for name, record in records().items():
        for one in fields(record):
            value = getattr(record, one.name)
            if type(value).__name__ not in records():  # a stage of its own
                wanted = {f"{name}.{one.name}"} if not is_dataclass(value) else set()
                parts = {f"{name}.{one.name}.{part.name}" for part in fields(value)} if is_dataclass(value) else set()
                covered = f"{name}.{one.name}" in described() or (parts and parts <= described().keys())
                missing += [] if covered else sorted(wanted or parts)
    assert missing == []


def test_formulas_become_mathml(monkeypatch):
    pytest.importorskip("latex2mathml")
    monkeypatch.syspath_prepend(str(ROOT / "docs/extensions"))
    mathml = importlib.import_module("mathml")
    root = ElementTree.fromstring(mathml.markup(r"\frac{a}{2}", "block"))
    assert "".join(root.itertext()) == "a2"
    with pytest.raises(Exception, match="unknowncommand"):
        mathml.markup(r"\unknowncommand a", "inline")
