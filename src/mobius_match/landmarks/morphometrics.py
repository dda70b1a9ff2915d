"""Landmarks of geometric morphometrics: TPS with three coordinates, Morphologika, and IDAV Landmark's ``.pts``.

None of them records a coordinate system. TPS and Morphologika have no names of landmarks; in TPS we write them as a
comment.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from .tables import Landmarks
from .text import MISSING, coordinates, count, error_at, number, one_word, plain, read_text

ABSENT = "9999"
"""All three coordinates of a missing landmark in a .pts file."""

NAMES = "names "
"""Prefix of the comment with the names of landmarks."""


def _rows(landmarks: Landmarks) -> Iterator[str]:
    return (" ".join(map(repr, point)) for point in landmarks.points.tolist())


def write_tps(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """The specimens as TPS."""
    lines = []
    for landmarks in specimens:
        lines += [f"LM3={len(landmarks)}", *_rows(landmarks), f"ID={one_word(landmarks.specimen).replace('=', '_')}"]
        if landmarks.names != _numbered(len(landmarks)):
            lines.append(f"COMMENT={NAMES}{json.dumps(landmarks.names)}")
        lines.append(f"COMMENT={plain(comment)}")
    return ("\n".join(lines) + "\n").encode()


def read_tps(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The specimens of a TPS file, with its scale applied; points of curves are ignored."""
    specimens: list[Landmarks] = []
    lines = [(n, row.strip()) for n, row in enumerate(read_text(path).splitlines(), 1) if row.strip()]
    rows = iter(lines)
    for line, row in rows:
        key, is_field, value = (part.strip() for part in row.partition("="))
        key = key.upper()
        if not is_field:
            raise error_at(path, line, f"a field such as LM3= or ID= is needed here, not {row[:40]!r}")
        if key == "LM" and value != "0":
            raise error_at(path, line, "landmarks with two coordinates (LM=); three are needed (LM3=)")
        if key == "LM3":
            points = [coordinates(path, n, words) for n, words in _data(path, rows, line, row, value)]
            specimens.append(Landmarks(_numbered(len(points)), None, np.array(points, np.float64).reshape(-1, 3)))
        elif key in ("POINTS", "POINTS3"):
            list(_data(path, rows, line, row, value))
        elif key in ("ID", "IMAGE", "SCALE", "COMMENT") and not specimens:
            raise error_at(path, line, f"{key}= before the landmarks (LM3=) that it belongs to")
        elif key == "SCALE":
            with np.errstate(over="ignore"):  # infinite values are refused when all is read
                scaled = specimens[-1].points * number(path, line, value)
            specimens[-1] = Landmarks(specimens[-1].names, None, scaled, specimens[-1].specimen)
        elif key == "ID" or (key == "IMAGE" and not specimens[-1].specimen):
            specimens[-1] = Landmarks(specimens[-1].names, None, specimens[-1].points, value)
        elif key == "COMMENT" and value.startswith(NAMES):
            names = _names(value.removeprefix(NAMES), len(specimens[-1]))
            specimens[-1] = Landmarks(names, None, specimens[-1].points, specimens[-1].specimen)
    return specimens


def _data(
    path: Path, rows: Iterator[tuple[int, str]], line: int, row: str, value: str
) -> Iterator[tuple[int, list[str]]]:
    """The rows that belong to a field, as many as its value says, split into words."""
    for done in range(count(path, line, value, "points")):
        n, data = next(rows, (line, ""))
        if not data or "=" in data:
            raise error_at(path, n, f"{row[:40]} of line {line} is followed by only {done} rows")
        yield n, data.split()


def _names(text: str, size: int) -> list[str]:
    """Names from a comment; numbers if it holds no list of names."""
    try:
        names = json.loads(text)
    except (ValueError, RecursionError):
        names = None
    valid = isinstance(names, list) and len(names) == size and all(isinstance(name, str) for name in names)
    return names if valid else _numbered(size)


def _numbered(size: int) -> list[str]:
    return [str(i) for i in range(1, size + 1)]


def write_morphologika(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """The specimens as Morphologika; all have the same number of landmarks."""
    size = len(specimens[0])
    names = [one_word(landmarks.specimen) for landmarks in specimens]
    # Readers search the whole file for the words of the headings, so the comment stands behind the last heading.
    lines = ["[individuals]", str(len(specimens)), "[landmarks]", str(size), "[dimensions]", "3", "[names]", *names]
    lines += ["", "[rawpoints]"]
    for k, landmarks in enumerate(specimens, 1):
        lines += [f"'{k} {names[k - 1]}", *_rows(landmarks)]
    return ("\n".join([*lines, f"'{plain(comment)}"]) + "\n").encode()


def read_morphologika(path: Path, coordinate_system: str) -> list[Landmarks]:
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
            raise error_at(path, line, f"a heading such as [individuals] is needed here, not {row[:40]!r}")
        else:
            part.append((line, row))
    for name in ("individuals", "landmarks", "dimensions", "rawpoints"):
        if not parts.get(name):
            raise error_at(path, line, f"the file ends without [{name}], or it is empty")
    n, size, dimensions = (count(path, *parts[name][0], name) for name in ("individuals", "landmarks", "dimensions"))
    if dimensions != 3:
        raise error_at(path, parts["dimensions"][0][0], f"landmarks have {dimensions} coordinates; 3 are needed")
    rows = parts["rawpoints"]
    if len(rows) != n * size:
        raise error_at(path, rows[-1][0], f"{len(rows)} rows of points; {n} individuals with {size} need {n * size}")
    points = np.array([coordinates(path, line, row.split()) for line, row in rows], np.float64).reshape(n, size, 3)
    names = [row for _, row in parts.get("names", [])]
    if names and len(names) != n:
        raise error_at(path, parts["names"][-1][0], f"{len(names)} names for {n} individuals")
    return [Landmarks(_numbered(size), None, points[k], names[k] if names else "") for k in range(n)]


def write_pts(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """One specimen in the format of IDAV Landmark, which has no comments."""
    (landmarks,) = specimens
    rows = [f"{one_word(name)} {row}" for name, row in zip(landmarks.names, _rows(landmarks), strict=True)]
    return ("\n".join(["Version 1.0", str(len(landmarks)), *rows]) + "\n").encode()


def read_pts(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The specimen of a file of IDAV Landmark."""
    lines = [(n, row.split()) for n, row in enumerate(read_text(path).splitlines(), 1) if row.strip()]
    line, words = lines[0]
    if words[0].lower() != "version" or len(words) != 2:
        raise error_at(path, line, "the first line should be 'Version 1.0', as IDAV Landmark writes it")
    if len(lines) < 2 or len(lines[1][1]) != 1:
        raise error_at(path, lines[-1][0], "the number of landmarks should follow 'Version 1.0', alone on its line")
    size = count(path, lines[1][0], lines[1][1][0], "landmarks")
    rows = lines[2:]
    if len(rows) != size:
        raise error_at(path, lines[-1][0], f"{len(rows)} landmarks, and line {lines[1][0]} says {size}")
    points = [
        MISSING if [word.split(".")[0] for word in words[1:]] == [ABSENT] * 3 else coordinates(path, n, words[1:])
        for n, words in rows
    ]
    return [Landmarks([words[0] for _, words in rows], None, np.array(points, np.float64).reshape(-1, 3))]
