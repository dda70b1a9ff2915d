"""Text files of landmarks: read as lines, with one error for whatever is wrong in them."""

from __future__ import annotations

import math
import re
from pathlib import Path

from ..errors import FormatError

MISSING = (math.nan,) * 3
"""Coordinates of a landmark that a file names and does not place."""

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


def wrong(path: Path, line: int, reason: str) -> FormatError:
    """What is wrong, and where."""
    return FormatError(f"{path}, line {line}: {reason}")


def coordinates(path: Path, line: int, words: list[str]) -> tuple[float, ...]:
    """Three numbers; ``NA`` for each stands for a missing landmark."""
    if len(words) != 3:
        raise wrong(path, line, f"{len(words)} numbers where x, y and z are needed")
    if all(word.upper() in ("NA", "NAN") for word in words):
        return MISSING
    return tuple(number(path, line, word) for word in words)


def number(path: Path, line: int, word: str) -> float:
    """A finite number."""
    value = float(word) if _NUMBER.fullmatch(word) else math.nan
    if not math.isfinite(value):
        raise wrong(path, line, f"{word[:40]!r} is not a number, or too large for one")
    return value


def count(path: Path, line: int, word: str, what: str) -> int:
    """A whole number from 0 to a thousand million: a claim, nothing is set aside for it."""
    if not _COUNT.fullmatch(word):
        raise wrong(path, line, f"{word[:40]!r} is not a number of {what}")
    return int(word)


def plain(text: str) -> str:
    """A name or comment on one line, without characters that end a line or that no text shows."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def one_word(text: str) -> str:
    """A name without blanks."""
    return plain(text).replace(" ", "_") or "_"
