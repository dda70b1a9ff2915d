"""Text files of vertex numbers."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..errors import FormatError


def read_lines(path: Path) -> list[str]:
    """The lines of a text file.

    Raises
    ------
    FormatError
        If it cannot be read as text.
    """
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: cannot be read as text ({error}). Check path and permissions.") from error


def read_vertices(path: Path, base: int | None, *, gaps: bool = False) -> np.ndarray:
    """Vertex numbers (L,) int64, from 0, of a text file.

    Parameters
    ----------
    path
        One vertex per line: its number first; the rest of the line, empty lines and comments after ``#`` are ignored.
        A file named ``.csv`` has a header, and the numbers are in its column ``vertex``.
    base
        Number of the first vertex in the file, 0 or 1. None is allowed only for files with lines ``vertex x y z``,
        which count from 0.
    gaps
        Whether -1, for no vertex, is allowed.

    Raises
    ------
    FormatError
        If the file cannot be read, has no numbers, an entry that is not a number, or a number below the base.
    """
    rows = _csv_rows(path) if path.suffix.lower() == ".csv" else _text_rows(path)
    if not rows:
        raise FormatError(f"{path}: holds no vertex numbers. Give one per line.")
    if base is None:
        if any(len(words) != 4 for _, words in rows):
            raise FormatError(
                f"{path}: it is unknown whether its vertex numbers count from 0 or from 1. Only lines 'vertex x y z' "
                "always count from 0; give the column 'base' in the manifest."
            )
        base = 0
    numbers = []
    for line, words in rows:
        try:
            number = int(words[0])
        except ValueError:
            raise FormatError(f"{path}, line {line}: {words[0]!r} is not a vertex number.") from None
        if number < base and not (gaps and number == -1):
            raise FormatError(f"{path}, line {line}: vertex {number}, in a list that counts from {base}.")
        numbers.append(-1 if number == -1 else number - base)
    return np.array(numbers, np.int64)


def _text_rows(path: Path) -> list[tuple[int, list[str]]]:
    split = ((number, line.split("#")[0].split()) for number, line in enumerate(read_lines(path), start=1))
    return [(number, words) for number, words in split if words]


def _csv_rows(path: Path) -> list[tuple[int, list[str]]]:
    return [(number, [row["vertex"]]) for number, row in read_table(path, ("vertex",))]


def read_table(path: Path, needed: tuple[str, ...]) -> list[tuple[int, dict[str, str]]]:
    """The rows of a CSV file with a header, each with its line number; values are stripped of blanks.

    Raises
    ------
    FormatError
        If the file cannot be read, lacks a needed column, or a row has no value in one.
    """
    reader = csv.DictReader(read_lines(path), skipinitialspace=True)
    try:
        columns = [name.strip() for name in reader.fieldnames or ()]
        missing = [name for name in needed if name not in columns]
        if missing:
            raise FormatError(
                f"{path}: has no column {missing[0]!r}; its first line must name the columns {', '.join(needed)}."
            )
        reader.fieldnames = columns
        rows = [
            (reader.line_num, {name: (value or "").strip() for name, value in row.items() if isinstance(name, str)})
            for row in reader
        ]
    except csv.Error as error:
        raise FormatError(f"{path}, line {reader.line_num}: not valid CSV ({error}).") from error
    for number, row in rows:
        for name in needed:
            if not row[name]:
                raise FormatError(f"{path}, line {number}: the column {name!r} is empty.")
    return rows
