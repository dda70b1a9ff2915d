"""Where results go: standard output, or files that appear whole or not at all."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import SettingsError

if TYPE_CHECKING:
    from rich.table import Table

STDOUT = Path("-")
ROWS = 20  # of matches in a table
PLAIN_WIDTH = 120  # characters, where standard output is no terminal


def check_output(option: str, path: Path, inputs: Sequence[Path] = ()) -> None:
    """Refuse, before any long work, a path that could not be written in the end.

    Raises
    ------
    SettingsError
        A directory, a missing or read-only folder, a read-only file, or one of the inputs.
    """
    if path == STDOUT:
        return
    folder = path.resolve().parent
    if path.is_dir():
        raise SettingsError(f"{option}: {path} is a directory; name a file in it.")
    if not folder.is_dir():
        raise SettingsError(f"{option}: the folder {folder} does not exist; make it first.")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise SettingsError(f"{option}: {path} cannot be written; check the permissions or name another place.")
    for given in inputs:
        if path.exists() and given.exists() and path.samefile(given):
            raise SettingsError(f"{option}: {path} is one of the inputs and would be overwritten; name another file.")


def make_folder(path: Path) -> None:
    """Make the folder for several results, if need be.

    Raises
    ------
    SettingsError
        It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SettingsError(f"--output: the folder {path} cannot be made ({error.strerror}).") from error


def write(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all; `-` is standard output."""
    from .._core.files import write_atomically

    if path == STDOUT:
        sys.stdout.buffer.write(content)
    else:
        write_atomically(path, content)


def to_json(data: Any) -> bytes:
    """A result as JSON, for files and standard output."""
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def others_of(number: int) -> str | None:
    """What stands below a table of the first matches, if there are more."""
    return f"and {number - ROWS} more" if number > ROWS else None


def print_table(table: Table) -> None:
    """Show a table on standard output, without colours where that is no terminal."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else PLAIN_WIDTH
    Console(width=width, markup=False, highlight=False, emoji=False).print(table)
