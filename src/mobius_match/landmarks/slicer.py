"""Landmarks of 3D Slicer: Markups (``.mrk.json``, schema 1.0.3) and the older lists of fiducials (``.fcsv``).

Both record whether their coordinates are LPS (left, posterior, superior) or RAS (right, anterior, superior).
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from json import decoder, scanner
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FormatError, SettingsError
from .tables import Landmarks
from .text import MISSING, coordinates, error_at, plain, read_text

SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
SYSTEMS = ("LPS", "RAS")
COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"


def check_system(coordinate_system: str) -> None:
    """Raise SettingsError for an unknown coordinate system."""
    if coordinate_system not in SYSTEMS:
        raise SettingsError(f"`coordinate_system` is {coordinate_system!r}; choose one of {', '.join(SYSTEMS)}")


def converted(points: np.ndarray, from_system: str, to_system: str) -> np.ndarray:
    """Coordinates (q, 3) converted from one system to another."""
    return points if from_system == to_system else points * [-1.0, -1.0, 1.0]


def write_markups(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """The specimens as Markups, one point list each."""
    markups = [
        {
            "type": "Fiducial",
            "name": plain(landmarks.specimen),
            "coordinateSystem": coordinate_system,
            "controlPoints": [
                {
                    "id": str(number),
                    "label": plain(name),
                    "description": _vertex(landmarks, number - 1),
                    "position": point,
                    "selected": True,
                    "locked": False,
                    "visibility": True,
                    "positionStatus": "defined",
                }
                for number, (name, point) in enumerate(zip(landmarks.names, landmarks.points.tolist(), strict=True), 1)
            ],
        }
        for landmarks in specimens
    ]
    content = {"@schema": SCHEMA, "description": plain(comment), "markups": markups}
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


def write_fcsv(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """One specimen as a list of fiducials; readers of this format expect exactly three lines of header."""
    (landmarks,) = specimens
    out = io.StringIO()
    out.write(
        f"# Markups fiducial file version = 4.13\n# CoordinateSystem = {coordinate_system}\n# columns = {COLUMNS}\n"
    )
    rows = csv.writer(out, lineterminator="\n")
    for number, (name, point) in enumerate(zip(landmarks.names, landmarks.points.tolist(), strict=True), 1):
        description = "; ".join(filter(None, (_vertex(landmarks, number - 1), plain(comment))))
        rows.writerow([number, *map(repr, point), 0, 0, 0, 1, 1, 1, 0, plain(name), description, ""])
    return out.getvalue().encode()


def _vertex(landmarks: Landmarks, row: int) -> str:
    return "" if landmarks.vertices is None else f"vertex {landmarks.vertices[row]}, counting from 0"


class _Object(dict[str, Any]):
    """A JSON object with its position in the text."""

    start = 0


class _Decoder(json.JSONDecoder):
    """Python's decoder, extended by the position of each object."""

    def __init__(self) -> None:
        super().__init__()
        self.parse_object = self._object
        self.scan_once = scanner.py_make_scanner(self)  # type: ignore[attr-defined]

    @staticmethod
    def _object(text_and_start: tuple[str, int], *rest: Any) -> tuple[_Object, int]:
        values, end = decoder.JSONObject(text_and_start, *rest)  # type: ignore[attr-defined]
        parsed = _Object(values)
        parsed.start = text_and_start[1]
        return parsed, end


def read_markups(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The point lists of a Markups file, each a specimen; other markups, as curves, are read by their control points.

    A control point without position is NaN.
    """
    text = read_text(path)
    try:
        content = _Decoder().decode(text)
    except json.JSONDecodeError as error:
        raise error_at(path, error.lineno, f"not JSON ({error.msg})") from error
    except (RecursionError, ValueError) as error:
        raise FormatError(f"{path}: not readable as JSON ({error}).") from error

    def error_in(parsed: Any, reason: str) -> FormatError:
        return error_at(path, 1 + text.count("\n", 0, getattr(parsed, "start", 0)), reason)

    markups = content.get("markups") if isinstance(content, _Object) else None
    if not isinstance(markups, list) or not all(isinstance(markup, _Object) for markup in markups):
        raise error_in(content, "not a Markups file of 3D Slicer: it has no list 'markups' of objects")
    specimens = []
    for markup in markups:
        system, points = markup.get("coordinateSystem", "LPS"), markup.get("controlPoints", [])
        if system not in SYSTEMS:
            raise error_in(markup, f"the coordinateSystem is {str(system)[:40]!r}; it must be LPS or RAS")
        if not isinstance(points, list) or not all(isinstance(point, _Object) for point in points):
            raise error_in(markup, "'controlPoints' is not a list of objects")
        names, positions = [], []
        for number, point in enumerate(points, 1):
            position = point.get("position")
            if position is None or point.get("positionStatus", "defined") != "defined":
                position = MISSING
            elif not (isinstance(position, list) and len(position) == 3 and all(map(_finite, position))):
                raise error_in(point, f"the position of control point {number} is not three finite numbers")
            names.append(str(point.get("label") or number))
            positions.append(position)
        array = converted(np.array(positions, np.float64).reshape(-1, 3), system, coordinate_system)
        specimens.append(Landmarks(names, None, array, str(markup.get("name") or "")))
    return specimens


def _finite(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # an integer too large for a float
        return False


def read_fcsv(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The specimen of a list of fiducials."""
    columns, system = COLUMNS.split(","), "RAS"  # Slicer's defaults where the file records none
    names, positions = [], []
    for line, row in enumerate(read_text(path).splitlines(), 1):
        if row.startswith("#"):
            entry = re.fullmatch(r"#\s*(\w+)\s*=\s*(.*?)[\s,]*", row)
            if entry and entry[1] == "columns":
                columns = [name.strip() for name in entry[2].split(",")]
            elif entry and entry[1] == "CoordinateSystem":
                system = {"0": "RAS", "1": "LPS"}.get(entry[2], entry[2])
                if system not in SYSTEMS:
                    raise error_at(path, line, f"the coordinate system is {system[:40]!r}; it must be LPS or RAS")
            continue
        if not row.strip():
            continue
        try:
            (cells,) = csv.reader([row])
        except csv.Error as error:
            raise error_at(path, line, f"not a row of a table ({error})") from error
        values = dict(zip(columns, (cell.strip() for cell in cells), strict=False))
        if not {"x", "y", "z"} <= set(values):
            raise error_at(path, line, f"{len(cells)} columns, and x, y and z are not among them")
        positions.append(coordinates(path, line, [values[axis] for axis in "xyz"]))
        names.append(values.get("label") or str(len(positions)))
    array = converted(np.array(positions, np.float64).reshape(-1, 3), system, coordinate_system)
    return [Landmarks(names, None, array)]
