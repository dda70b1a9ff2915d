"""``mobius info MESH...``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import MobiusError
from .common import SOME_FAILED, UNUSABLE, say
from .options import Verbose
from .output import STDOUT, print_table, to_json, write

if TYPE_CHECKING:
    from rich.table import Table

LONGEST_LIST = 6
"""Entries of a list that the table shows at most."""
MOST_PIECES = 12
"""Pieces that the table shows at most."""


def info(
    meshes: Annotated[list[Path], typer.Argument(metavar="MESH...", help="Mesh files.")],
    json: Annotated[bool, typer.Option("--json", help="Print a JSON list with one entry per file.")] = False,
    verbose: Verbose = False,
) -> None:
    """Show the properties of meshes, and how matching would repair them.

    Prints topology, size and quality of each mesh, the repairs that matching would make, and whether it can be
    matched. The exit code is 3 if no mesh can be matched, 5 if some of several cannot.
    """
    from ..mesh import describe, read_mesh

    entries: list[dict[str, Any]] = []
    for path in meshes:
        try:
            entry = describe(read_mesh(path))
            if not json:
                print_table(_table(entry))
        except MobiusError as error:
            entry = {"name": path.name, "path": str(path), "usable": False, "reason": str(error)}
        if not entry["usable"]:
            say(f"error: {entry['reason']}")
        entries.append(entry)
    if json:
        write(STDOUT, to_json(entries))
    failed = sum(not entry["usable"] for entry in entries)
    if failed:
        raise typer.Exit(UNUSABLE if failed == len(meshes) else SOME_FAILED)


def _table(entry: dict[str, Any]) -> Table:
    from rich.table import Table

    table = Table(title=entry["name"], title_justify="left", show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    for label, value in _rows(entry):
        if label not in ("name", "notes", "reason", "pieces") and not (label.endswith(" places") and not value):
            table.add_row(label, _shown(value))
    table.add_row("pieces", "\n".join(_pieces(entry["pieces"])) or "none")
    table.add_row("repairs", "\n".join(entry["notes"]) or "none")
    if entry["reason"]:
        table.add_row("not usable because", entry["reason"])
    return table


def _pieces(pieces: list[dict[str, Any]]) -> Iterator[str]:
    """A line for each piece, the main one first."""
    for number, piece in enumerate(pieces[:MOST_PIECES]):
        kind = "cavity" if piece["cavity"] else "closed" if piece["closed"] else "open"
        yield (
            f"{'main' if number == 0 else 'other'}: {piece['vertices']} vertices from {piece['first_vertex']}, "
            f"{piece['faces']} faces, area {_shown(piece['area'])}, {kind}"
            + (f", {', '.join(map(repr, piece['names']))}" if piece["names"] else "")
        )
    if len(pieces) > MOST_PIECES:
        yield f"and {len(pieces) - MOST_PIECES} more (--json lists them)"


def _rows(entry: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in entry.items():
        label = f"{prefix}{key.replace('_', ' ')}"
        if isinstance(value, dict):
            yield from _rows(value, f"{label}: ")
        else:
            yield label, value


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, dict):  # a vertex, an edge by its two ends, or a loop by its first vertex, and where it lies
        numbers, length = value.get("vertices", [value.get("vertex")]), value.get("length")
        place = ", ".join(map(_shown, value["place"]))
        if length is not None:
            return f"{numbers[0]} ({place}; length {_shown(length)})"
        return f"{'-'.join(map(str, numbers))} ({place})"
    if isinstance(value, list):
        rest = ["..."] if len(value) > LONGEST_LIST else []
        return ", ".join([*map(_shown, value[:LONGEST_LIST]), *rest]) or "-"
    return str(value)
