"""Constants of the method in frozen records: each number with its meaning, its unit and its origin.

A stage of the method has one record, in the ``parameters.py`` of its room. Records are passed to the functions that use
them, so that two runs in one process may differ in them. ``tools/parameters.py`` writes ``docs/parameters.md`` from
them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, field, fields, is_dataclass
from typing import Any

AREA = "sqrt(area)"
"""Unit of lengths: the square root of the surface's area."""

HAND = "chosen by hand on the evaluation sets"
"""Origin of a number that no script fits and no argument gives. Its worth is a row of the ablation."""


def parameter(value: Any, meaning: str, *, unit: str = "", origin: str) -> Any:
    """A field of a record: its default, what it means in the formula, its unit ("" for none), and where it comes from.

    Parameters
    ----------
    value
        A number, or a tuple of numbers.
    meaning
        One sentence.
    unit
        ``"sqrt(area)"`` for lengths; empty for numbers without unit.
    origin
        A publication, an argument, the script that fits it, or :data:`HAND` with the row of the ablation.
    """
    return field(default=value, metadata={"meaning": meaning, "unit": unit, "origin": origin})


def parameters_of(record: Any, prefix: str = "") -> Iterator[tuple[str, Field[Any], Any]]:
    """Name (with dots for records in records), field and value of each parameter of a record."""
    for one in fields(record):
        value = getattr(record, one.name)
        if is_dataclass(value):
            yield from parameters_of(value, f"{prefix}{one.name}.")
        else:
            yield f"{prefix}{one.name}", one, value


def count_numbers(record: Any) -> int:
    """How many numbers a record holds; a tuple of three counts as three."""
    return sum(len(value) if isinstance(value, tuple) else 1 for _, _, value in parameters_of(record))
