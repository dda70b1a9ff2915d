"""How records are printed: one line each at a prompt, a small table in a notebook."""

import dataclasses
import importlib
import pkgutil
import re
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import mobius_match as mm
from mobius_match._core.display import html_table, one_line, shortened
from mobius_match.alignments.alignment import Alignment
from mobius_match.evaluation import examples
from mobius_match.landmarks.constraints import landmark_constraints

LONGEST = 330
"""Characters of a record in one line."""

LARGE = re.compile(r"(tuple\[)?(np\.ndarray|Surface|Mesh|Correspondence|Registration|Landmarks|Truth|dict|list)")
"""Types of fields that are not printed in full."""

OTHER_ROOMS = ("mobius_match.mesh", "mobius_match.geometry", "mobius_match.cli")
"""Rooms that test their own records, and the commands, whose records no user sees."""


@pytest.fixture(scope="module")
def result():
    """A match of two shapes with known pairs and meshes large enough to be simplified."""
    return mm.match(*examples.paths("person"), seed=0, resolution=1500, landmarks=[[0, 0]])


@pytest.fixture(scope="module")
def dense(result):
    return result.dense()


def records(result, dense):
    """Records that a user can come across."""
    source, target, alignment = result.source, result.target, result._make_dense.args[2].alignments[0]
    constraints, _ = landmark_constraints([[0, 0], [5, 7]], source, target)
    return [
        *(result, *result.alternatives[:1], source, source.detail, result.votes, constraints),
        *(alignment, alignment.registration, dense, dense.inverse, mm.quality(dense), *dense.eigenbases(5)),
        mm.View("x" * 1_000_000),
        mm.Landmarks(["a"] * 500, np.arange(500), np.zeros((500, 3)), "of one"),
        mm.Landmarks([], np.arange(500), None),
        mm.Transfer(dense),
        mm.symmetry(examples.paths("person")[0]),
        mm.MatchSettings(),
    ]


def test_records_are_one_short_line(result, dense):
    for record in records(result, dense):
        text = repr(record)
        assert len(text) <= LONGEST, type(record)
        assert "\n" not in text
        assert type(record).__name__ in text


def test_no_public_record_is_printed_field_by_field_if_it_holds_more_than_numbers():
    """The line that dataclasses make by themselves prints whole arrays."""
    checked = []
    made_by_dataclass = []
    for module in pkgutil.walk_packages(mm.__path__, "mobius_match."):
        if module.name.endswith(("__main__", ".parameters")) or module.name.startswith(OTHER_ROOMS):
            continue
        for name, cls in vars(importlib.import_module(module.name)).items():
            if not dataclasses.is_dataclass(cls) or cls.__module__ != module.name or name.startswith("_"):
                continue
            if any(LARGE.match(str(field.type)) for field in dataclasses.fields(cls)):
                checked.append(name)
                if hasattr(cls.__repr__, "__wrapped__"):
                    made_by_dataclass.append(f"{module.name}.{name}")
    assert made_by_dataclass == []
    assert {"Surface", "Votes", "Alternative", "Correspondence", "SurfaceMap", "Quality", "Alignment"} <= set(checked)


def test_lines_say_what_it_is(result, dense):
    names = [path.name for path in examples.paths("person")]
    assert repr(result) == f"<Correspondence {names[0]} -> {names[1]}: {len(result)} pairs>"
    vertices, whole = len(result.source.mesh.vertices), len(result.source.whole_mesh.vertices)
    assert repr(result.source) == (
        f"<Surface {names[0]}: {vertices} vertices (simplified from {whole}), 100 samples, "
        f"area {result.source.area:.4g}>"
    )
    assert repr(mm.View("x" * 1234)) == "<View: a page of 1,234 characters; save(path) writes it>"
    assert f"matrix (100, 100), n_triplets {result.votes.n_triplets}" in repr(result.votes)
    assert repr(dense).endswith(f": {whole} of {whole} vertices>")
    assert repr(mm.Landmarks(["a", "b"], None, np.zeros((2, 3)), "Fox")) == "<Landmarks of Fox: 2>"


def test_the_parts_of_a_line():
    @dataclass(frozen=True, eq=False)
    class Record:
        array: np.ndarray
        number: float
        count: int
        text: str
        path: Path
        nothing: None
        empty: tuple
        arrays: tuple
        notes: tuple
        points: mm.SurfacePoints
        other: Exception

        def __repr__(self):
            return one_line(self)

    points = mm.SurfacePoints(np.zeros(4, int), np.zeros((4, 3), int), np.zeros((4, 3)))
    two = (np.zeros(2), np.zeros((3, 1)))
    record = Record(np.zeros((2, 3)), 1 / 3, 7, "a\nb", Path("a/b"), None, (), two, ("x", "y"), points, ValueError())
    assert repr(record) == (
        r"<Record: array (2, 3), number 0.3333, count 7, text 'a\nb', path 'a/b', arrays (2,) and (3, 1), notes (2), "
        "points SurfacePoints, other ValueError>"
    )


def test_long_names_are_cut():
    assert shortened("a" * 60) == "a" * 60
    assert shortened("a" * 61) == "a" * 57 + "..."
    assert shortened("two\nlines") == "two lines"


def parsed(text):
    """The elements of HTML that is well-formed as XML too."""
    return ElementTree.fromstring(f"<div>{text}</div>")


def test_tables_escape_all_texts():
    nasty = '<script>alert("x")</script>&'
    root = parsed(html_table(nasty, [nasty], [[nasty, 1, 0.5]], more=3, notes=[nasty]))
    assert {element.tag for element in root.iter()} == {
        *("div", "table", "caption", "thead", "tbody", "tr", "th", "td", "p", "ul", "li")
    }
    assert [element.text for element in root.iter() if element.tag in ("caption", "th", "li")] == [nasty] * 3
    assert [cell.text for cell in root.iter("td")] == [nasty, "1", "0.500"]
    assert root.find("p").text == "and 3 more"
    assert parsed(html_table("", (), [])).find("p") is None


def test_a_notebook_shows_the_first_matches(result):
    named = replace(
        result, source_info={**result.source_info, "path": "a/<b>.off"}, warnings=("a <i>warning</i>", "another")
    )
    root = parsed(named._repr_html_())
    assert root.find("table/caption").text.startswith("<b>.off -> ")
    rows = [[cell.text for cell in row] for row in root.findall("table/tbody/tr")]
    assert rows == [
        [str(n + 1), *map(str, result.pairs[n]), f"{result.confidence[n]:.3f}", result.kind[n]] for n in range(10)
    ]
    assert root.find("p").text == f"and {len(result) - 10} more"
    assert [note.text for note in root.iter("li")] == ["a <i>warning</i>", "another"]


def test_a_notebook_shows_few_matches_as_they_are(result):
    few = replace(result, pairs=result.pairs[:2], confidence=result.confidence[:2], kind=result.kind[:2])
    root = parsed(few._repr_html_())
    assert len(root.findall("table/tbody/tr")) == 2
    assert root.find("p") is None


def test_a_notebook_shows_maps_surfaces_qualities_and_symmetries(result, dense):
    rows = [[cell.text for cell in row] for row in parsed(dense._repr_html_()).iter("tr")]
    assert [row[2] for row in rows[1:]] == [str(dense.source.n_file_vertices), str(dense.target.n_file_vertices)]
    quality = mm.quality(dense)
    cells = [cell.text for cell in parsed(quality._repr_html_()).iter("td")]
    assert f"{quality.coverage:.1%}" in cells
    cells = [cell.text for cell in parsed(result.source._repr_html_()).iter("td")]
    assert cells[cells.index("samples") + 1] == "100"
    found = mm.symmetry(examples.paths("person")[0])
    root = parsed(found._repr_html_())
    assert [cell.text for cell in root.find("table/tbody/tr")][1:3] == [str(vertex) for vertex in found.pairs[0]]


def test_alignments_without_registration_are_short():
    assert repr(Alignment(np.zeros(7, int), {"strain": 1.0}, 0.25, 0.5)) == (
        "<Alignment: image (7,), cost_terms (1), cost 0.25, share 0.5, shapes_differ False, probability 0, order 1>"
    )
