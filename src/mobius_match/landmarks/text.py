"""Text files of landmarks: words, numbers, and errors that name the line."""

from __future__ import annotations

import math
import re
from pathlib import Path

from ..errors import FormatError

MISSING = (math.nan,) * 3
"""Coordinates of a landmark that a file lists as missing."""

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,5})?")
_COUNT = re.compile(r"\d{1,9}")


def read_text(path: Path) -> str:
    """The text of a file, in UTF-8 or else Latin-1.

    Raises
    ------
    FormatError
        If the file cannot be read or is empty.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise FormatError(f"{path}: cannot be read ({error}). Check path and permissions.") from error
    if not data.strip():
        raise FormatError(f"{path}: the file is empty. Export it again.")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def error_at(path: Path, line: int, reason: str) -> FormatError:
    """The error for a line of a file."""
    return FormatError(f"{path}, line {line}: {reason}")


def coordinates(path: Path, line: int, words: list[str]) -> tuple[float, ...]:
    """Three numbers; all three ``NA`` for a missing landmark."""
    if len(words) != 3:
        raise error_at(path, line, f"{len(words)} numbers where x, y and z are needed")
    if all(word.upper() in ("NA", "NAN") for word in words):
        return MISSING
    return tuple(number(path, line, word) for word in words)


def number(path: Path, line: int, word: str) -> float:
    """A finite number."""
    value = float(word) if _NUMBER.fullmatch(word) else math.nan
    if not math.isfinite(value):
        raise error_at(path, line, f"{word[:40]!r} is not a number, or too large for one")
    return value


def count(path: Path, line: int, word: str, what: str) -> int:
    """An integer from 0 to 999,999,999. Nothing is allocated for it, as the file may be wrong."""
    if not _COUNT.fullmatch(word):
        raise error_at(path, line, f"{word[:40]!r} is not a number of {what}")
    return int(word)


def plain(text: str) -> str:
    """A name or comment on one line, without control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def one_word(text: str) -> str:
    """A name with underscores for blanks."""
    return plain(text).replace(" ", "_") or "_"
