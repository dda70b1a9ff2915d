"""Picked points of MeshLab (``.pp``)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import FormatError
from .tables import Landmarks
from .text import MISSING, coordinates, plain, read_text, wrong


def write_pp(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """One specimen as picked points."""
    (marks,) = specimens
    lines = ["<!DOCTYPE PickedPoints>", "<PickedPoints>", f" <!-- {plain(comment).replace('--', '- -')} -->"]
    lines += [" <DocumentData>", f"  <DataFileName name={quoteattr(plain(marks.specimen))}/>", " </DocumentData>"]
    for name, (x, y, z) in zip(marks.names, marks.points.tolist(), strict=True):
        lines.append(f' <point x="{x!r}" y="{y!r}" z="{z!r}" active="1" name={quoteattr(plain(name))}/>')
    return ("\n".join([*lines, "</PickedPoints>"]) + "\n").encode()


def read_pp(path: Path, wanted: str) -> list[Landmarks]:
    """The one specimen of a file of picked points; a point that is not active is NaN."""
    names: list[str] = []
    places: list[tuple[float, ...]] = []
    specimen, inside = "", 0
    parser = expat.ParserCreate("utf-8")  # whatever the file declares: it has been decoded

    def start(tag: str, found: dict[str, str]) -> None:
        nonlocal specimen, inside
        inside += 1
        line = parser.CurrentLineNumber
        if inside == 1 and tag != "PickedPoints":
            raise wrong(path, line, f"<{tag[:40]}> where <PickedPoints> should begin")
        if tag == "DataFileName":
            specimen = found.get("name", "")
        elif tag == "point":
            both_incomplete = [name for name in "xyz" if name not in found]
            if both_incomplete:
                raise wrong(path, line, f"a point without {both_incomplete[0]}")
            active = found.get("active", "1") != "0"
            place = coordinates(path, line, [found[name].strip() for name in "xyz"])
            places.append(place if active else MISSING)
            names.append(found.get("name") or str(len(places)))

    def end(tag: str) -> None:
        nonlocal inside
        inside -= 1

    def entity(*_: object) -> None:
        raise wrong(path, parser.CurrentLineNumber, "it declares an entity, which files of picked points do not")

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    try:
        parser.Parse(read_text(path).encode(), True)
    except expat.ExpatError as error:
        raise wrong(path, error.lineno, f"not XML ({expat.errors.messages[error.code]})") from error
    except FormatError:
        raise
    except ValueError as error:  # an encoding that expat does not know
        raise FormatError(f"{path}: not readable as XML ({error}).") from error
    return [Landmarks(names, None, np.array(places, np.float64).reshape(-1, 3), specimen)]
