"""Landmarks of 3D Slicer: Markups (``.mrk.json``, schema 1.0.3) and the older lists of fiducials (``.fcsv``).

Both say whether their coordinates are LPS (left, posterior, superior) or RAS (right, anterior, superior).
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
from .text import MISSING, coordinates, plain, read_text, wrong

SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
SYSTEMS = ("LPS", "RAS")
COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"


def check_system(system: str) -> None:
    """Raise SettingsError for a coordinate system that is none of the two."""
    if system not in SYSTEMS:
        raise SettingsError(f"the coordinate system is {system!r}; choose one of {', '.join(SYSTEMS)}")


def turned(points: np.ndarray, system: str, wanted: str) -> np.ndarray:
    """Coordinates (q, 3) of one system in the other."""
    return points if system == wanted else points * [-1.0, -1.0, 1.0]


def write_markups(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """The specimens as Markups, a point list each."""
    markups = [
        {
            "type": "Fiducial",
            "name": plain(marks.specimen),
            "coordinateSystem": system,
            "controlPoints": [
                {
                    "id": str(number),
                    "label": plain(name),
                    "description": _vertex(marks, number - 1),
                    "position": point,
                    "selected": True,
                    "locked": False,
                    "visibility": True,
                    "positionStatus": "defined",
                }
                for number, (name, point) in enumerate(zip(marks.names, marks.points.tolist(), strict=True), 1)
            ],
        }
        for marks in specimens
    ]
    content = {"@schema": SCHEMA, "description": plain(comment), "markups": markups}
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


def write_fcsv(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """One specimen as a list of fiducials; its readers count on three lines of header and no more."""
    (marks,) = specimens
    out = io.StringIO()
    out.write(f"# Markups fiducial file version = 4.13\n# CoordinateSystem = {system}\n# columns = {COLUMNS}\n")
    rows = csv.writer(out, lineterminator="\n")
    for number, (name, point) in enumerate(zip(marks.names, marks.points.tolist(), strict=True), 1):
        about = "; ".join(filter(None, (_vertex(marks, number - 1), plain(comment))))
        rows.writerow([number, *map(repr, point), 0, 0, 0, 1, 1, 1, 0, plain(name), about, ""])
    return out.getvalue().encode()


def _vertex(marks: Landmarks, row: int) -> str:
    return "" if marks.vertices is None else f"vertex {marks.vertices[row]}, counting from 0"


class _Object(dict[str, Any]):
    """A JSON object that knows where it began."""

    start = 0


class _Decoder(json.JSONDecoder):
    """Python's own, which tells where objects begin."""

    def __init__(self) -> None:
        super().__init__()
        self.parse_object = self._object
        self.scan_once = scanner.py_make_scanner(self)  # type: ignore[attr-defined]

    @staticmethod
    def _object(begun: tuple[str, int], *rest: Any) -> tuple[_Object, int]:
        values, end = decoder.JSONObject(begun, *rest)  # type: ignore[attr-defined]
        found = _Object(values)
        found.start = begun[1]
        return found, end


def read_markups(path: Path, wanted: str) -> list[Landmarks]:
    """The point lists of a Markups file, each a specimen; curves, lines and the like are their control points.

    A control point without position is NaN.
    """
    text = read_text(path)
    try:
        content = _Decoder().decode(text)
    except json.JSONDecodeError as error:
        raise wrong(path, error.lineno, f"not JSON ({error.msg})") from error
    except (RecursionError, ValueError) as error:
        raise FormatError(f"{path}: not readable as JSON ({error}).") from error

    def bad(where: Any, reason: str) -> FormatError:
        return wrong(path, 1 + text.count("\n", 0, getattr(where, "start", 0)), reason)

    markups = content.get("markups") if isinstance(content, _Object) else None
    if not isinstance(markups, list) or not all(isinstance(one, _Object) for one in markups):
        raise bad(content, "not a Markups file of 3D Slicer: it has no list 'markups' of objects")
    found = []
    for markup in markups:
        system, points = markup.get("coordinateSystem", "LPS"), markup.get("controlPoints", [])
        if system not in SYSTEMS:
            raise bad(markup, f"the coordinateSystem is {str(system)[:40]!r}; LPS and RAS are known")
        if not isinstance(points, list) or not all(isinstance(one, _Object) for one in points):
            raise bad(markup, "'controlPoints' is not a list of objects")
        names, places = [], []
        for number, point in enumerate(points, 1):
            place = point.get("position")
            if place is None or point.get("positionStatus", "defined") != "defined":
                place = MISSING
            elif not (isinstance(place, list) and len(place) == 3 and all(map(_finite, place))):
                raise bad(point, f"the position of control point {number} is not three finite numbers")
            names.append(str(point.get("label") or number))
            places.append(place)
        where = turned(np.array(places, np.float64).reshape(-1, 3), system, wanted)
        found.append(Landmarks(names, None, where, str(markup.get("name") or "")))
    return found


def _finite(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def read_fcsv(path: Path, wanted: str) -> list[Landmarks]:
    """The one specimen of a list of fiducials."""
    columns, system = COLUMNS.split(","), "RAS"  # what Slicer takes where the file does not say
    names, places = [], []
    for line, row in enumerate(read_text(path).splitlines(), 1):
        if row.startswith("#"):
            said = re.fullmatch(r"#\s*(\w+)\s*=\s*(.*?)[\s,]*", row)
            if said and said[1] == "columns":
                columns = [name.strip() for name in said[2].split(",")]
            elif said and said[1] == "CoordinateSystem":
                system = {"0": "RAS", "1": "LPS"}.get(said[2], said[2])
                if system not in SYSTEMS:
                    raise wrong(path, line, f"the coordinate system is {system[:40]!r}; LPS and RAS are known")
            continue
        if not row.strip():
            continue
        try:
            (cells,) = csv.reader([row])
        except csv.Error as error:
            raise wrong(path, line, f"not a row of a table ({error})") from error
        values = dict(zip(columns, (cell.strip() for cell in cells), strict=False))
        if not {"x", "y", "z"} <= set(values):
            raise wrong(path, line, f"{len(cells)} columns, and x, y and z are not among them")
        places.append(coordinates(path, line, [values[axis] for axis in "xyz"]))
        names.append(values.get("label") or str(len(places)))
    return [Landmarks(names, None, turned(np.array(places, np.float64).reshape(-1, 3), system, wanted))]
