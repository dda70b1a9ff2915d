"""How records look where they are printed: one line at a prompt, a small table in a notebook."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import fields
from pathlib import Path
from typing import Any

ROWS = 10
"""Rows of a table in a notebook."""

LONGEST = 60
"""Characters of a name or a text; longer ones are cut."""


def one_line(record: Any) -> str:
    """A dataclass in one line: its name, and the fields with the shapes of arrays and the lengths of collections."""
    found = (f"{field.name} {_short(getattr(record, field.name))}" for field in fields(record))
    return f"<{type(record).__name__}: {', '.join(part for part in found if not part.endswith(' '))}>"


def shortened(text: object) -> str:
    """A text of at most 60 characters, on one line."""
    line = " ".join(str(text).split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."


def file_name(info: Mapping[str, Any]) -> str:
    """The name of a mesh's file, or "array", from what a result says of the mesh."""
    return shortened(Path(info.get("path") or "array").name)


def _short(value: Any) -> str:
    """A value in a few characters; nothing for None and for empty collections."""
    if value is None:
        return ""
    if hasattr(value, "shape") and value.shape != ():
        return str(tuple(value.shape))
    if isinstance(value, bool | int | complex):
        return repr(value)
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, str | Path):
        return shortened(repr(str(value))) if str(value) else ""
    if isinstance(value, tuple) and value and all(hasattr(one, "shape") for one in value):
        return " and ".join(map(_short, value))
    if isinstance(value, Sequence | Mapping):
        return f"({len(value)})" if len(value) else ""
    if isinstance(value, Sized):
        return f"{type(value).__name__} ({len(value)})"
    return type(value).__name__


def html_table(
    title: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[object]],
    *,
    more: int = 0,
    notes: Sequence[str] = (),
) -> str:
    """A table for a notebook; all texts are escaped.

    Parameters
    ----------
    title
        Caption.
    headings
        Of the columns; empty for none.
    rows
        Cells; numbers are aligned to the right.
    more
        How many rows are left out.
    notes
        Lines below the table.
    """
    return "".join(_html(title, headings, rows, more, notes))


def _html(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[object]], more: int, notes: Sequence[str]
) -> Iterator[str]:
    yield f'<table><caption style="text-align: left">{html.escape(title)}</caption>'
    if headings:
        yield f"<thead><tr>{''.join(f'<th>{html.escape(one)}</th>' for one in headings)}</tr></thead>"
    yield "<tbody>"
    for row in rows:
        yield f"<tr>{''.join(map(_cell, row))}</tr>"
    yield "</tbody></table>"
    if more > 0:
        yield f"<p>and {more} more</p>"
    if notes:
        yield f"<ul>{''.join(f'<li>{html.escape(one)}</li>' for one in notes)}</ul>"


def _cell(value: object) -> str:
    if isinstance(value, str):
        return f'<td style="text-align: left">{html.escape(value)}</td>'
    return f'<td style="text-align: right">{value:.3f}</td>' if isinstance(value, float) else f"<td>{value}</td>"
