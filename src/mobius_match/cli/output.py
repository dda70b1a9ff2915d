"""Output of the commands: files that are written completely or not at all, standard output, and tables."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SettingsError

if TYPE_CHECKING:
    from rich.table import Table

STDOUT = Path("-")
ROWS = 20
"""Matches that a table lists at most."""

PLAIN_WIDTH = 120
"""Width of a table in characters where standard output is not a terminal."""


def check_output(option: str, path: Path, inputs: Sequence[Path] = ()) -> None:
    """Check, before any long work, that a path can be written.

    Raises
    ------
    SettingsError
        The path is a directory, a read-only file or one of the inputs, or its folder is missing or read-only.
    """
    if path == STDOUT:
        return
    folder = path.resolve().parent
    if path.is_dir():
        raise SettingsError(f"{option}: {path} is a directory; give a file name.")
    if not folder.is_dir():
        raise SettingsError(f"{option}: the folder {folder} does not exist; create it first.")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise SettingsError(f"{option}: {path} cannot be written; check its permissions or choose another path.")
    for given in inputs:
        if path.exists() and given.exists() and path.samefile(given):
            raise SettingsError(f"{option}: {path} is one of the inputs and would be overwritten; choose another file.")


def check_outputs(
    outputs: Mapping[str, Path | None], inputs: Sequence[Path] = (), endings: Mapping[str, str] | None = None
) -> None:
    """Check the files that options name (None where not given): their endings, that they differ, and `check_output`.

    Raises
    ------
    SettingsError
        A file has another ending than its option requires, two options name the same file, or it cannot be written.
    """
    option_of: dict[Path, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        ending = (endings or {}).get(option)
        printed = path == STDOUT and option == "--output"
        if ending and not printed and path.suffix.lower() != ending:
            raise SettingsError(f"{option}: {path} is not a {ending} file; change its ending.")
        check_output(option, path, inputs)
        other = option_of.setdefault(path.resolve(), option)
        if other != option:
            raise SettingsError(f"{option}: {path} is also the file of {other}; choose another file.")


def make_folder(path: Path) -> None:
    """Create the folder for several results, if needed.

    Raises
    ------
    SettingsError
        The folder cannot be created.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SettingsError(f"--output: the folder {path} cannot be created ({error.strerror}).") from error


def write(path: Path, content: bytes) -> None:
    """Write a file completely or not at all; ``-`` is standard output."""
    from .._core.files import write_atomically

    if path == STDOUT:
        sys.stdout.buffer.write(content)
    else:
        write_atomically(path, content)


def to_json(data: Any) -> bytes:
    """A result as JSON, for files and standard output."""
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def number_omitted(number: int) -> str | None:
    """The line below a table of the first matches of a number of them: how many it omits."""
    return f"and {number - ROWS} more" if number > ROWS else None


def print_table(table: Table) -> None:
    """Print a table on standard output, without colours where that is not a terminal."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else PLAIN_WIDTH
    Console(width=width, markup=False, highlight=False, emoji=False).print(table)
