"""Picked points of MeshLab (``.pp``)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import FormatError
from .tables import Landmarks
from .text import MISSING, coordinates, error_at, plain, read_text


def write_pp(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """One specimen as picked points."""
    (landmarks,) = specimens
    lines = ["<!DOCTYPE PickedPoints>", "<PickedPoints>", f" <!-- {plain(comment).replace('--', '- -')} -->"]
    lines += [" <DocumentData>", f"  <DataFileName name={quoteattr(plain(landmarks.specimen))}/>", " </DocumentData>"]
    for name, (x, y, z) in zip(landmarks.names, landmarks.points.tolist(), strict=True):
        lines.append(f' <point x="{x!r}" y="{y!r}" z="{z!r}" active="1" name={quoteattr(plain(name))}/>')
    return ("\n".join([*lines, "</PickedPoints>"]) + "\n").encode()


def read_pp(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The specimen of a file of picked points; inactive points are NaN."""
    names: list[str] = []
    positions: list[tuple[float, ...]] = []
    specimen, depth = "", 0
    parser = expat.ParserCreate("utf-8")  # whatever the file declares, as it is decoded already

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal specimen, depth
        depth += 1
        line = parser.CurrentLineNumber
        if depth == 1 and tag != "PickedPoints":
            raise error_at(path, line, f"<{tag[:40]}> where <PickedPoints> should begin")
        if tag == "DataFileName":
            specimen = attributes.get("name", "")
        elif tag == "point":
            missing = [name for name in "xyz" if name not in attributes]
            if missing:
                raise error_at(path, line, f"a point without {missing[0]}")
            active = attributes.get("active", "1") != "0"
            position = coordinates(path, line, [attributes[name].strip() for name in "xyz"])
            positions.append(position if active else MISSING)
            names.append(attributes.get("name") or str(len(positions)))

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1

    def entity(*_: object) -> None:
        raise error_at(path, parser.CurrentLineNumber, "it declares an entity, which is not allowed here")

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    try:
        parser.Parse(read_text(path).encode(), True)
    except expat.ExpatError as error:
        raise error_at(path, error.lineno, f"not XML ({expat.errors.messages[error.code]})") from error
    except FormatError:
        raise
    except ValueError as error:  # an encoding that expat does not know
        raise FormatError(f"{path}: not readable as XML ({error}).") from error
    return [Landmarks(names, None, np.array(positions, np.float64).reshape(-1, 3), specimen)]
