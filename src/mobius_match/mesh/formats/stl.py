"""STL, text and binary. It has no vertex numbers, so equal corners are joined as they first appear."""

from __future__ import annotations

import numpy as np

from ...errors import FormatError
from ..measure import twins
from ..mesh import Floats
from .raw import RawMesh, equal_polygons
from .text import content_lines, promised, table

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes) -> RawMesh:
    """Read either kind; a file is binary where its length fits, whatever its first word says."""
    count = int.from_bytes(data[80:84], "little")
    if data.lstrip()[:5].lower() == b"solid" and len(data) != 84 + TRIANGLE.itemsize * count:
        return _weld(_text(data), [])
    if len(data) < 84:
        raise FormatError(
            f"{len(data)} bytes are too few for an STL file. It was cut short: export it again."
        )
    promised(count, "triangles", (len(data) - 84) // TRIANGLE.itemsize, "whole triangles")
    extra = len(data) - 84 - TRIANGLE.itemsize * count
    notes = [f"{extra} byte(s) after the last triangle ignored."] if extra else []
    return _weld(np.frombuffer(data, TRIANGLE, count, 84)["corners"].reshape(-1, 3), notes)


def _text(data: bytes) -> Floats:
    lines = content_lines(data)
    words = [line.split(maxsplit=1)[0].lower() for line in lines.text]
    corners = lines.pick(np.flatnonzero([word == "vertex" for word in words]))
    facets = words.count("endfacet")
    if len(corners) != 3 * facets or words.count("facet") != facets or "endsolid" not in words:
        raise FormatError(
            f"{words.count('facet')} facets begin, {facets} end and there are {len(corners)} corners, "
            f"{'with' if 'endsolid' in words else 'without'} an endsolid line. "
            "The file is damaged or was cut short: export it again."
        )
    return table(corners, range(1, 4), np.float64, "vertex")


def _weld(corners: Floats, notes: list[str]) -> RawMesh:
    first, face = np.unique(twins(corners), return_inverse=True)
    notes.append(
        f"STL has no vertex numbers: {len(corners)} corners joined to {len(first)} vertices with different "
        "coordinates, numbered in order of appearance."
    )
    return equal_polygons(corners[first], face.reshape(-1, 3), notes)
