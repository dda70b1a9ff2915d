"""Tables of numbers in text and numpy files: a row for each vertex or face, or landmarks."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._core.display import shortened
from ..errors import FormatError

TEXTS, ARRAYS = (".csv", ".txt"), (".npy", ".npz")
COLUMNS = ("name", "vertex", "x", "y", "z")

FAR = 0.02
"""Distance from a surface, per diagonal of the bounding box, above which a landmark is reported as off it."""


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points on a surface, of one specimen.

    Parameters
    ----------
    names
        A name for each, or an empty list.
    vertices
        (q,) int64 vertex numbers, or None if only coordinates are known.
    points
        (q, 3) float64 coordinates, NaN for a missing landmark, or None if only vertex numbers are known.
    specimen
        Name of the specimen, if known.
    """

    names: list[str]
    vertices: Any
    points: Any
    specimen: str = ""

    def __len__(self) -> int:
        return len(self.points if self.vertices is None else self.vertices)

    def __repr__(self) -> str:
        of = f" of {shortened(self.specimen)}" if self.specimen else ""
        return f"<Landmarks{of}: {len(self)}{'' if self.names else ' without names'}>"

    def __getitem__(self, rows: np.ndarray) -> Landmarks:
        names = [self.names[i] for i in np.arange(len(self))[rows]] if self.names else []
        vertices, points = (None if values is None else values[rows] for values in (self.vertices, self.points))
        return Landmarks(names, vertices, points, self.specimen)

    def text(self) -> bytes:
        """The landmarks as CSV, with the columns name, vertex, x, y, z as far as they are known.

        Returns
        -------
        bytes
            The content of a file, in UTF-8.
        """
        columns: dict[str, list[str]] = {"name": self.names} if self.names else {}
        if self.vertices is not None:
            columns["vertex"] = [str(number) for number in self.vertices.tolist()]
        if self.points is not None:
            columns |= {
                name: [repr(x) for x in column.tolist()] for name, column in zip("xyz", self.points.T, strict=True)
            }
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        return out.getvalue().encode()


def read_table(path: Path) -> dict[str, np.ndarray] | Landmarks:
    """Read a table of numbers.

    A text file has rows of numbers, separated by commas, semicolons or blanks, and may begin with a line of headings.
    If these name columns ``vertex`` or ``x, y, z``, the rows are landmarks, which may have a column ``name``.

    Returns
    -------
    dict or Landmarks
        Arrays by name (that of the file for text files), each with a row for each vertex or face; or landmarks.

    Raises
    ------
    FormatError
        If the file is malformed; the message names the line.
    """
    try:
        if path.suffix.lower() in ARRAYS:
            loaded = np.load(path, allow_pickle=False)
            if isinstance(loaded, np.ndarray):
                return {path.stem: loaded}
            with loaded:
                return dict(loaded)
        data = path.read_bytes()
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise FormatError(f"{path}: cannot be read ({error}). Check the path, or write the file again.") from error
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:  # concerns names only
        text = data.decode("latin-1")
    heads, rows = split_rows(path, text)
    if "vertex" in heads or {"x", "y", "z"} <= set(heads):
        return _landmarks(path, heads, rows)
    table = numbers(path, rows, range(len(rows[0][1]) if rows else len(heads)))
    return {path.stem: table[:, 0] if table.shape[1] == 1 else table}


def split_rows(path: Path, text: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The headings of a table in lower case, none if its first row has numbers only, and its rows with line numbers.

    Raises
    ------
    FormatError
        If there is no row, or one has another number of columns than the first; the message names the line.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    delimiter = next((mark for mark in ",;\t" if lines and mark in lines[0][1]), None)
    try:
        rows = [
            (n, line.split() if delimiter is None else next(csv.reader([line], delimiter=delimiter)))
            for n, line in lines
        ]
    except csv.Error as error:
        raise FormatError(f"{path}: not a table ({error}).") from error
    rows = [(number, [cell.strip() for cell in row]) for number, row in rows]
    if not rows:
        raise FormatError(f"{path}: the file is empty; it needs a row of numbers for each vertex, face or landmark.")
    width = len(rows[0][1])
    for number, row in rows:
        if len(row) != width:
            raise FormatError(f"{path}: line {number} has {len(row)} columns, and the first has {width}.")
    heads = [cell.lower() for cell in rows[0][1]] if any(_parsed(cell) is None for cell in rows[0][1]) else []
    return heads, rows[1:] if heads else rows


def as_landmarks(path: Path, arrays: dict[str, np.ndarray]) -> Landmarks | None:
    """Rows without headings as landmarks: one column of vertex numbers, or three of coordinates; None if neither."""
    (table,) = arrays.values() if len(arrays) == 1 else (np.empty((0, 0)),)
    if table.ndim == 1 and len(table) and table.dtype.kind in "iu":
        return Landmarks([], table.astype(np.int64), None)
    return Landmarks([], None, table.astype(np.float64)) if table.ndim == 2 and table.shape[1] == 3 else None


def text_of(values: np.ndarray) -> bytes:
    """An array as CSV, a line for each row, with numbers that read back exactly."""
    rows = values.reshape(len(values), -1).tolist()
    return "".join(",".join(map(repr, row)) + "\n" for row in rows).encode()


def _landmarks(path: Path, heads: list[str], rows: list[tuple[int, list[str]]]) -> Landmarks:
    names = [row[heads.index("name")] for _, row in rows] if "name" in heads else []
    points = vertices = None
    if {"x", "y", "z"} <= set(heads):
        points = numbers(path, rows, [heads.index(name) for name in "xyz"]).astype(np.float64)
        for (line, _), point in zip(rows, points, strict=True):
            if np.isinf(point).any():
                raise FormatError(f"{path}: line {line} has a coordinate that is not a finite number.")
    if "vertex" in heads:
        column = numbers(path, rows, [heads.index("vertex")])[:, 0]
        if column.dtype.kind != "i":
            cells = [(line, row[heads.index("vertex")]) for line, row in rows]
            line, cell = next((line, cell) for line, cell in cells if not _is_integer(cell))
            raise FormatError(f"{path}: line {line}: {cell[:40]!r} is not a vertex number, which is an integer.")
        vertices = column
    return Landmarks(names, vertices, points)


def numbers(path: Path, rows: list[tuple[int, list[str]]], columns: list[int] | range) -> np.ndarray:
    """The numbers in given columns, (rows, columns): int64 if all are written as integers, else float64.

    Raises
    ------
    FormatError
        If a cell is not a number; the message names the line.
    """
    for number, row in rows:
        for column in columns:
            if _parsed(row[column]) is None:
                raise FormatError(f"{path}: line {number}: {row[column][:40]!r} is not a number.")
    cells = [[row[column] for column in columns] for _, row in rows]
    if all(_is_integer(cell) for row in cells for cell in row):
        return np.array(cells, dtype=object).astype(np.int64).reshape(len(rows), len(columns))
    return np.array(cells, dtype=object).astype(np.float64).reshape(len(rows), len(columns))


def _is_integer(cell: str) -> bool:
    return re.fullmatch(r"[-+]?\d{1,18}", cell) is not None


def _parsed(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None
