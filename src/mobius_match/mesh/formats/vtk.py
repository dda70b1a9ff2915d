"""VTK files, read by meshio: legacy .vtk, and .vtp and .vtu in XML.

meshio does not know PolyData, which is passed to it as an unstructured grid of polygons. Of a file with several pieces
it keeps the cells of the last alone, so such files are refused.
"""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...errors import FormatError
from .cells import from_cells
from .raw import RawMesh, promised

SECTION = re.compile(
    rb"(?im)^(POINTS|VERTICES|LINES|POLYGONS|TRIANGLE_STRIPS|CELLS|CELL_TYPES|FIELD|POINT_DATA|CELL_DATA)"
    rb"[ \t]+(\w{1,40})(?:[ \t]+(\w{1,40}))?[ \t]*$"
)


def read_vtk(data: bytes) -> RawMesh:
    """Read the polygons of a legacy file: POLYDATA or UNSTRUCTURED_GRID, text or binary."""
    head = re.match(rb"(?i)# vtk DataFile Version [^\n]*\n[^\n]*\n\s*(ASCII|BINARY)\s*\nDATASET +(\w+)\s*\n", data)
    if head is None:
        raise FormatError("not a legacy VTK file: '# vtk DataFile Version', title, kind and DATASET expected.")
    text, grid = head[1].upper() == b"ASCII", head[2].upper() == b"UNSTRUCTURED_GRID"
    if not grid and head[2].upper() != b"POLYDATA":
        raise FormatError(f"{head[2][:40].decode('latin-1')} is not a surface; save it as PolyData.")
    data = data.replace(b"\r\n", b"\n") if text else data
    found = list(SECTION.finditer(data))
    stops = [section.start() for section in found[1:]] + [len(data)]
    # The first of each name: what follows POINT_DATA is not needed.
    sections = {
        section[1].upper(): (section[2], section[3] or b"0", data[section.start() : stop])
        for section, stop in reversed(list(zip(found, stops, strict=True)))
    }
    if b"TRIANGLE_STRIPS" in sections:
        raise FormatError("triangle strips are not read: apply a triangle filter and save again.")
    name = b"CELLS" if grid else b"POLYGONS"
    wanted = [b"POINTS", name, b"CELL_TYPES"] if grid else [b"POINTS", name]
    for key in wanted:
        if key not in sections:
            raise FormatError(f"the file has no {key.decode()} or was cut short before: export it again.")
        first, second, body = sections[key]
        second = b"0" if key == b"POINTS" else second
        if not (first.isdigit() and second.isdigit()):
            raise FormatError(f"{body[:60].splitlines()[0].decode('latin-1')!r} does not give a count.")
        numbers = max(int(first) * (3 if key == b"POINTS" else 1), int(second))
        promised(numbers, f"numbers for {key.decode()}", len(body), "bytes")
    out = b"".join(sections[key][2] + b"\n" for key in wanted)
    count, size = int(sections[name][0]), int(sections[name][1])
    offsets = b"OFFSETS" in sections[name][2][:80].upper()
    count -= offsets
    if not grid:
        kind = 5 if size == (3 if offsets else 4) * count else 7  # polygons of any size take longer
        kinds = b"%d " % kind * count if text else np.full(count, kind, ">i4").tobytes()
        out = re.sub(rb"(?im)^POLYGONS", b"CELLS", out, count=1) + b"CELL_TYPES %d\n%b\n" % (count, kinds)
    return _meshio(data[: data.index(b"\n", head.start(1)) + 1] + b"DATASET UNSTRUCTURED_GRID\n" + out, "vtk", count)


def read_vtkxml(data: bytes) -> RawMesh:
    """Read the polygons of a .vtp or .vtu file with one piece: text, base64 or appended, also compressed."""
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise FormatError("document types and entities have no place in a VTK file.")
    appended = re.search(rb"(?s)<AppendedData[^>]*raw[^>]*>\s*_(.*?)\n?[ \t]*</AppendedData>\s*</VTKFile>", data)
    text = data[: appended.start(1)] + data[appended.end(1) :] if appended else data
    root = ElementTree.fromstring(text)
    kind, grid = root.get("type", ""), root.find("*")
    pieces = root.findall("*/Piece")
    if kind not in ("PolyData", "UnstructuredGrid") or grid is None or len(pieces) != 1:
        raise FormatError(
            f"{kind[:40]!r} with {len(pieces)} piece(s) is not a surface; save it as PolyData in one piece."
        )
    piece = pieces[0]
    counts = {key: int(value) for key, value in piece.attrib.items() if value.isdigit()}
    promised(max(counts.values(), default=0), "points or cells", len(data), "bytes")
    if counts.get("NumberOfStrips"):
        raise FormatError("triangle strips are not read: apply a triangle filter and save again.")
    spare = ElementTree.SubElement(grid, "FieldData")
    for group in list(piece):
        if group.tag not in ("Points", "Polys", "Cells"):
            # Kept as field data: meshio needs an owner for every appended array.
            piece.remove(group)
            spare.extend(group)
    if kind == "PolyData":
        root.set("type", "UnstructuredGrid")
        grid.tag = "UnstructuredGrid"
        count = counts.get("NumberOfPolys", 0)
        piece.set("NumberOfCells", str(count))
        for cells in piece.findall("Polys"):
            cells.tag = "Cells"
            types = ElementTree.SubElement(cells, "DataArray", type="UInt8", Name="types", format="ascii")
            types.text = "7 " * count
    out = ElementTree.tostring(root)
    if appended:
        out = re.sub(rb"_\s*</AppendedData>", lambda _: b"_" + appended[1] + b"\n</AppendedData>", out)
    return _meshio(out, "vtu", int(piece.get("NumberOfCells", "0")))


def _meshio(data: bytes, kind: str, count: int) -> RawMesh:
    """Read these bytes with meshio, through a temporary file: it reads nothing else."""
    import meshio

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stderr(io.StringIO()):
        path = Path(folder) / f"mesh.{kind}"
        path.write_bytes(data)
        mesh: Any = {"vtk": meshio.vtk, "vtu": meshio.vtu}[kind].read(path)
    found = sum(len(block.data) for block in mesh.cells)
    if found != count:
        raise FormatError(
            f"the header promises {count} cells, but {found} can be read. "
            "Save the surface as PolyData, or export it again."
        )
    return from_cells(mesh.points, ((block.type, block.data) for block in mesh.cells))
