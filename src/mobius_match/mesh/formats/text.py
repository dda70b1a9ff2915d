"""Tables of numbers in text files, read at the speed of C, with errors that name the line."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Ints


@dataclass
class Lines:
    """Lines of a file that are worth reading, and the number (from 1) of each."""

    text: list[str]
    numbers: list[int]

    def __len__(self) -> int:
        return len(self.text)

    def take(self, start: int, stop: int) -> Lines:
        """The lines from `start` up to `stop`."""
        return Lines(self.text[start:stop], self.numbers[start:stop])

    def pick(self, rows: NDArray[Any]) -> Lines:
        """The lines with these places in the list."""
        return Lines([self.text[i] for i in rows], [self.numbers[i] for i in rows])


def decode(data: bytes) -> list[str]:
    """Every line of a text file, whatever its line ends and encoding."""
    text = data.decode("latin-1").removeprefix("\xef\xbb\xbf")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


def content_lines(data: bytes) -> Lines:
    """The lines that are not empty once their ``#`` comments are gone."""
    lines = decode(data)
    if b"#" in data:
        lines = [line.partition("#")[0] for line in lines]
    kept = [bool(line) and not line.isspace() for line in lines]
    return Lines(list(itertools.compress(lines, kept)), list(itertools.compress(itertools.count(1), kept)))


def table(lines: Lines, columns: Sequence[int], dtype: type, what: str) -> NDArray[Any]:
    """The named columns of every line, (len(lines), len(columns)); further columns are not looked at."""
    if not len(lines) or not len(columns):
        return np.zeros((len(lines), len(columns)), dtype=dtype)
    try:
        out: NDArray[Any] = np.loadtxt(lines.text, dtype=dtype, comments=None, usecols=columns, ndmin=2)
    except (ValueError, OverflowError, IndexError) as error:
        raise _bad_line(lines, columns, dtype, what) from error
    if out.shape != (len(lines), len(columns)):
        raise _bad_line(lines, columns, dtype, what)
    return out


def _bad_line(lines: Lines, columns: Sequence[int], dtype: type, what: str) -> FormatError:
    kind = "whole numbers" if dtype is np.int64 else "numbers"
    need = max(columns) + 1
    for text, number in zip(lines.text, lines.numbers, strict=True):
        words = text.split()
        if len(words) < need:
            return FormatError(
                f"line {number}: a {what} needs {need} {kind}, found {len(words)} ({_short(text)}). "
                "The file is damaged or was cut short: export it again."
            )
        try:
            np.array([words[k] for k in columns]).astype(dtype)
        except (ValueError, OverflowError):
            return FormatError(f"line {number}: a {what} needs {kind}, found {_short(text)}.")
    return FormatError(f"lines {lines.numbers[0]} to {lines.numbers[-1]}: no table of {what} data.")


def polygon_rows(lines: Lines) -> tuple[Ints, Ints]:
    """Rows ``k i1 ... ik`` of any mixture of k: the sizes, and all corners in a row."""
    sizes: Ints = table(lines, [0], np.int64, "face")[:, 0]
    return sizes, polygon_corners(lines, sizes, 1)


def polygon_corners(lines: Lines, sizes: Ints, first: int) -> Ints:
    """The vertex numbers of rows of different lengths, those of each row beginning in column `first`."""
    longest = max(map(len, lines.text), default=0)
    wrong = np.flatnonzero((sizes < 0) | (sizes > longest))
    if len(wrong):
        row = wrong[0]
        raise FormatError(
            f"line {lines.numbers[row]}: a face with {sizes[row]} corners ({_short(lines.text[row])})."
        )
    start = np.cumsum(sizes) - sizes
    corners = np.zeros(int(sizes.sum()), dtype=np.int64)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        block = table(lines.pick(rows), range(first, first + size), np.int64, f"face with {size} corners")
        corners[start[rows, None] + np.arange(size)] = block
    return corners


def whole_numbers(text: str, number: int, what: str) -> list[int]:
    """The counts on a header line, all of them whole and not negative."""
    words = text.split()
    if not words or not all(word.isascii() and word.isdigit() and len(word) < 19 for word in words):
        raise FormatError(f"line {number}: expected {what}, found {_short(text)}.")
    return [int(word) for word in words]


def promised(count: int, what: str, found: int, unit: str) -> None:
    """Refuse a header that promises more than the file can hold, before anything is allocated."""
    if count > found:
        raise FormatError(
            f"the header promises {count} {what}, but only {found} {unit} follow. "
            "The file is damaged or was cut short: export it again."
        )


def _short(text: str) -> str:
    text = text.strip()
    return repr(text if len(text) <= 40 else text[:37] + "...")
