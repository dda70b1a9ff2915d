"""Constants of the method in frozen records: each number with its meaning, its unit and its origin.

A stage of the method has one record, in the ``parameters.py`` of its room. Records are passed to the functions that use
them, so that two runs in one process may differ in them. ``tools/parameters.py`` writes ``docs/parameters.md`` from
them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, TypeVar

Record = TypeVar("Record")

AREA = "sqrt(area)"
"""Unit of lengths: the square root of the surface's area."""

HAND = "chosen by hand on the evaluation sets"
"""Origin of a number that no script fits and no argument gives. Its worth is a row of the ablation."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a record.

    Parameters
    ----------
    name
        With dots for records in records.
    value
        A number, or a tuple of numbers.
    meaning, unit, origin
        As in :func:`parameter`.
    """

    name: str
    value: Any
    meaning: str = ""
    unit: str = ""
    origin: str = ""


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


def parameters_of(record: Any, prefix: str = "", inherited: Mapping[str, str] | None = None) -> Iterator[Parameter]:
    """Every parameter of a record, those of records in it too, which inherit what they do not say of themselves."""
    for one in fields(record):
        value, about = getattr(record, one.name), {**(inherited or {}), **one.metadata}
        if is_dataclass(value):
            yield from parameters_of(value, f"{prefix}{one.name}.", about)
        else:
            yield Parameter(f"{prefix}{one.name}", value, **about)


def count_numbers(record: Any) -> int:
    """How many numbers a record holds; a tuple of three counts as three."""
    return sum(len(one.value) if isinstance(one.value, tuple) else 1 for one in parameters_of(record))


def varied(record: Record, changes: Mapping[str, Any]) -> Record:
    """A record with other values of some parameters, by their names as :func:`parameters_of` gives them."""
    for name, value in changes.items():
        head, _, rest = name.partition(".")
        inner = varied(getattr(record, head), {rest: value}) if rest else value
        record = replace(record, **{head: inner})  # type: ignore[type-var]
    return record
