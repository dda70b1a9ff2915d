"""Landmarks of geometric morphometrics: TPS with three coordinates, Morphologika, and IDAV Landmark's ``.pts``.

None of them has a coordinate system, and TPS and Morphologika have no names of landmarks: TPS keeps them in a comment.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from .tables import Landmarks
from .text import MISSING, coordinates, count, number, one_word, plain, read_text, wrong

ABSENT = "9999"
"""What all three coordinates of a landmark are in a .pts file where it is missing."""

NAMES = "names "
"""Begins the comment that the names of landmarks are in."""


def _rows(marks: Landmarks) -> Iterator[str]:
    return (" ".join(map(repr, point)) for point in marks.points.tolist())


def write_tps(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """The specimens as TPS."""
    lines = []
    for marks in specimens:
        lines += [f"LM3={len(marks)}", *_rows(marks), f"ID={one_word(marks.specimen).replace('=', '_')}"]
        if marks.names != _numbered(len(marks)):
            lines.append(f"COMMENT={NAMES}{json.dumps(marks.names)}")
        lines.append(f"COMMENT={plain(comment)}")
    return ("\n".join(lines) + "\n").encode()


def read_tps(path: Path, wanted: str) -> list[Landmarks]:
    """The specimens of a TPS file, scaled as it says; points of curves are passed over."""
    found: list[Landmarks] = []
    lines = [(n, row.strip()) for n, row in enumerate(read_text(path).splitlines(), 1) if row.strip()]
    rows = iter(lines)
    for line, row in rows:
        key, is_field, value = (part.strip() for part in row.partition("="))
        key = key.upper()
        if not is_field:
            raise wrong(path, line, f"a field such as LM3= or ID= is needed here, not {row[:40]!r}")
        if key == "LM" and value != "0":
            raise wrong(path, line, "landmarks with two coordinates (LM=); three are needed (LM3=)")
        if key == "LM3":
            places = [coordinates(path, n, words) for n, words in _data(path, rows, line, row, value)]
            found.append(Landmarks(_numbered(len(places)), None, np.array(places, np.float64).reshape(-1, 3)))
        elif key in ("POINTS", "POINTS3"):
            list(_data(path, rows, line, row, value))
        elif key in ("ID", "IMAGE", "SCALE", "COMMENT") and not found:
            raise wrong(path, line, f"{key}= before the landmarks (LM3=) that it belongs to")
        elif key == "SCALE":
            with np.errstate(over="ignore"):  # told when all is read
                scaled = found[-1].points * number(path, line, value)
            found[-1] = Landmarks(found[-1].names, None, scaled, found[-1].specimen)
        elif key == "ID" or (key == "IMAGE" and not found[-1].specimen):
            found[-1] = Landmarks(found[-1].names, None, found[-1].points, value)
        elif key == "COMMENT" and value.startswith(NAMES):
            names = _names(value.removeprefix(NAMES), len(found[-1]))
            found[-1] = Landmarks(names, None, found[-1].points, found[-1].specimen)
    return found


def _data(
    path: Path, rows: Iterator[tuple[int, str]], line: int, row: str, value: str
) -> Iterator[tuple[int, list[str]]]:
    """As many of the following rows as a field says, in words."""
    for done in range(count(path, line, value, "points")):
        n, data = next(rows, (line, ""))
        if not data or "=" in data:
            raise wrong(path, n, f"{row[:40]} of line {line} is followed by {done} rows only")
        yield n, data.split()


def _names(text: str, size: int) -> list[str]:
    """Names in a comment, if that is what it holds."""
    try:
        names = json.loads(text)
    except (ValueError, RecursionError):
        names = None
    good = isinstance(names, list) and len(names) == size and all(isinstance(name, str) for name in names)
    return names if good else _numbered(size)


def _numbered(size: int) -> list[str]:
    return [str(i) for i in range(1, size + 1)]


def write_morphologika(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """The specimens as Morphologika; all have as many landmarks."""
    size = len(specimens[0])
    names = [one_word(marks.specimen) for marks in specimens]
    # Readers look for the words of the headings anywhere in the file, so the comment goes where they no longer do.
    lines = ["[individuals]", str(len(specimens)), "[landmarks]", str(size), "[dimensions]", "3", "[names]", *names]
    lines += ["", "[rawpoints]"]
    for k, marks in enumerate(specimens, 1):
        lines += [f"'{k} {names[k - 1]}", *_rows(marks)]
    return ("\n".join([*lines, f"'{plain(comment)}"]) + "\n").encode()


def read_morphologika(path: Path, wanted: str) -> list[Landmarks]:
    """The specimens of a Morphologika file."""
    parts: dict[str, list[tuple[int, str]]] = {}
    part, row, line = None, "", 0
    for line, row in enumerate(read_text(path).splitlines(), 1):
        row = row.strip()
        if not row or row[0] in "'\"":
            continue
        if row[0] == "[":
            part = parts.setdefault(row.strip("[] ").lower(), [])
        elif part is None:
            raise wrong(path, line, f"a heading such as [individuals] is needed here, not {row[:40]!r}")
        else:
            part.append((line, row))
    for name in ("individuals", "landmarks", "dimensions", "rawpoints"):
        if not parts.get(name):
            raise wrong(path, line, f"the file ends without [{name}], or it is empty")
    n, size, dimensions = (count(path, *parts[name][0], name) for name in ("individuals", "landmarks", "dimensions"))
    if dimensions != 3:
        raise wrong(path, parts["dimensions"][0][0], f"landmarks have {dimensions} coordinates; 3 are needed")
    rows = parts["rawpoints"]
    if len(rows) != n * size:
        raise wrong(path, rows[-1][0], f"{len(rows)} rows of points, where {n} individuals with {size} need {n * size}")
    places = np.array([coordinates(path, line, row.split()) for line, row in rows], np.float64).reshape(n, size, 3)
    names = [row for _, row in parts.get("names", [])]
    if names and len(names) != n:
        raise wrong(path, parts["names"][-1][0], f"{len(names)} names for {n} individuals")
    return [Landmarks(_numbered(size), None, places[k], names[k] if names else "") for k in range(n)]


def write_pts(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """One specimen as IDAV Landmark has it; the format has no comments."""
    (marks,) = specimens
    rows = [f"{one_word(name)} {row}" for name, row in zip(marks.names, _rows(marks), strict=True)]
    return ("\n".join(["Version 1.0", str(len(marks)), *rows]) + "\n").encode()


def read_pts(path: Path, wanted: str) -> list[Landmarks]:
    """The one specimen of a file of IDAV Landmark."""
    lines = [(n, row.split()) for n, row in enumerate(read_text(path).splitlines(), 1) if row.strip()]
    line, words = lines[0]
    if words[0].lower() != "version" or len(words) != 2:
        raise wrong(path, line, "the first line should be 'Version 1.0', as IDAV Landmark writes it")
    if len(lines) < 2 or len(lines[1][1]) != 1:
        raise wrong(path, lines[-1][0], "the number of landmarks should follow 'Version 1.0', alone on its line")
    size = count(path, lines[1][0], lines[1][1][0], "landmarks")
    rows = lines[2:]
    if len(rows) != size:
        raise wrong(path, lines[-1][0], f"{len(rows)} landmarks, and line {lines[1][0]} says {size}")
    places = [
        MISSING if [word.split(".")[0] for word in words[1:]] == [ABSENT] * 3 else coordinates(path, n, words[1:])
        for n, words in rows
    ]
    return [Landmarks([words[0] for _, words in rows], None, np.array(places, np.float64).reshape(-1, 3))]
