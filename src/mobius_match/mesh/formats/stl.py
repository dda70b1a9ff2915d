"""STL, text and binary, read by trimesh. It has no vertex numbers: equal corners are merged."""

from __future__ import annotations

import io
import re

import numpy as np

from ...errors import FormatError
from ..measure import twins
from .raw import RawMesh, from_triangles, promised

HEADER, TRIANGLE = 84, 50  # bytes


def read_stl(data: bytes) -> RawMesh:
    """Read either kind; a file is binary if its length fits, whatever its first word is."""
    count = int.from_bytes(data[80:84], "little")
    notes: list[str] = []
    if data.lstrip()[:5].lower() == b"solid" and len(data) != HEADER + TRIANGLE * count:
        # trimesh accepts text that was cut short, and fails on names that contain "vertex".
        data = re.sub(rb"(?i)^([ \t]*(?:end)?solid)\b.*", rb"\1", data, flags=re.M)
        words = [w.lower() for w in re.findall(rb"(?im)^[ \t]*(facet|vertex|endfacet|endsolid)\b", data)]
        facets, named, ends = (words.count(word) for word in (b"facet", b"vertex", b"endfacet"))
        if not facets == ends == named / 3 or b"endsolid" not in words:
            raise FormatError(
                f"{facets} facets begin, {ends} end and there are {named} corners, "
                f"{'with' if b'endsolid' in words else 'without'} an endsolid line. "
                "The file is damaged or was cut short: export it again."
            )
    else:
        if len(data) < HEADER:
            raise FormatError(f"{len(data)} bytes are too few for STL. It was cut short: export it again.")
        promised(count, "triangles", (len(data) - HEADER) // TRIANGLE, "whole triangles")
        extra = len(data) - HEADER - TRIANGLE * count
        if extra:
            notes = [f"{extra} byte(s) after the last triangle ignored."]
            data = data[:-extra]
    from trimesh.exchange.stl import load_stl

    loaded = load_stl(io.BytesIO(data))
    solids = loaded["geometry"].values() if "geometry" in loaded else [loaded]
    corners = np.concatenate([np.zeros((0, 3)), *(solid["vertices"] for solid in solids)])
    first, face = np.unique(twins(corners), return_inverse=True)
    notes.append(
        f"STL has no vertex numbers: {len(corners)} corners merged into {len(first)} vertices by their coordinates, "
        "numbered in order of appearance."
    )
    return from_triangles(corners[first], face, None, notes)
