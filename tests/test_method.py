"""The method's page and the code agree: every parameter stands on both sides, with the same value."""

import importlib
import importlib.util
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import fields, is_dataclass
from operator import attrgetter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs/method.md").read_text(encoding="utf-8")


TOOL = importlib.util.spec_from_file_location("list_of_parameters", ROOT / "tools/parameters.py")
tool = importlib.util.module_from_spec(TOOL)
TOOL.loader.exec_module(tool)

RECORDS = {type(record).__name__: record for _, record in tool.records()}


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
        assert values == [float(number) for number in numbers(attrgetter(path)(RECORDS[record]))], name


def test_the_page_has_every_parameter():
    names = [f"{record}.{one.name}" for record in RECORDS for one in tool.own_parameters(RECORDS[record])]
    assert len(names) > 100
    assert [name for name in names if not any(name == row or name.startswith(f"{row}.") for row in described())] == []


def test_the_list_of_parameters_is_up_to_date():
    assert (ROOT / "docs/parameters.md").read_text(encoding="utf-8") == tool.page(), "run python tools/parameters.py"


def test_formulas_become_mathml(monkeypatch):
    pytest.importorskip("latex2mathml")
    monkeypatch.syspath_prepend(str(ROOT / "docs/extensions"))
    mathml = importlib.import_module("mathml")
    root = ElementTree.fromstring(mathml.markup(r"\frac{a}{2}", "block"))
    assert "".join(root.itertext()) == "a2"
    with pytest.raises(Exception, match="unknowncommand"):
        mathml.markup(r"\unknowncommand a", "inline")
