"""OFF, read by trimesh once the rows have been counted and the polygons cut.

trimesh stacks triangles before quadrilaterals, fails on larger polygons and does not miss absent rows.
"""

from __future__ import annotations

import io
import re

import numpy as np

from ...errors import FormatError
from .raw import RawMesh, from_triangles, promised


def read_off(data: bytes) -> RawMesh:
    """Read the text form of OFF, with or without colours, normals or texture coordinates after x y z."""
    rows = [row for row in re.sub(rb"#[^\r\n]*", b"", data).splitlines() if row.strip()]
    header = re.match(rb"\s*(?:ST)?C?N?OFF\b\s*(.*)", rows[0]) if rows else None
    if header is None:
        raise FormatError(
            "the first line must begin with OFF; binary and four-dimensional OFF cannot be read. "
            "Export it as plain OFF."
        )
    counts = (header[1] or b"".join(rows[1:2])).split()
    if len(counts) < 2 or not all(word.isdigit() and len(word) < 16 for word in counts):
        raise FormatError(
            "the numbers of vertices, faces and edges expected after OFF, found "
            f"{b' '.join(counts)[:40].decode('latin-1')!r}. Export it as plain text OFF."
        )
    n, m = int(counts[0]), int(counts[1])
    body = rows[1 if header[1] else 2 :]
    promised(n + m, f"rows ({n} vertices and {m} faces)", len(body), "rows")
    cells = [row.split() for row in body[n : n + m]]
    sizes = [int(cell[0]) for cell in cells]
    for face, (cell, size) in enumerate(zip(cells, sizes, strict=True)):
        if not 0 <= size < len(cell):
            raise FormatError(
                f"face {face} (counting from 0) should have {size} corners, but {len(cell) - 1} "
                "numbers follow. The file is damaged or was cut short: export it again."
            )
    triangles = [
        b"3 %b %b %b" % (cell[1], cell[k], cell[k + 1])
        for cell, size in zip(cells, sizes, strict=True)
        for k in range(2, size)
    ]
    from trimesh.exchange.off import load_off

    plain = b"\n".join([b"OFF", b"%d %d 0" % (n, len(triangles)), *body[:n], *triangles])
    try:
        loaded = load_off(io.BytesIO(plain))
    except ValueError:
        for face, (cell, size) in enumerate(zip(cells, sizes, strict=True)):
            for word in cell[1 : size + 1]:
                if not word.isdigit() or int(word) >= n:
                    raise FormatError(
                        f"face {face} (counting from 0) names vertex {word[:40].decode('latin-1')}, but there "
                        f"are {n} vertices, numbered 0 to {n - 1}. The file is damaged: export it again."
                    ) from None
        raise
    extra = len(body) - n - m
    notes = [f"{extra} line(s) after the last face ignored."] if extra else []
    return from_triangles(loaded["vertices"], loaded["faces"], np.array(sizes, dtype=np.int64), notes)
