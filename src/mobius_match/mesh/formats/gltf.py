"""glTF 2: .glb and .gltf. Geometry and node transforms only; no material and no picture is ever opened."""

from __future__ import annotations

import base64
import json
import math
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..mesh import Floats, Ints
from .raw import RawMesh, equal_polygons
from .text import promised

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3}
TRIANGLES, STRIP, FAN = 4, 5, 6
MAX_TRIANGLES = 50_000_000  # nodes may show one mesh many times: a small file can unfold to any size


def read_gltf(data: bytes, path: Path) -> RawMesh:
    """Read all triangles of the scene, nodes in the order of the file, placed by their transforms."""
    tree, chunk = _chunks(data) if data[:4] == b"glTF" else (_json(data), None)
    if not str(tree.get("asset", {}).get("version", "")).startswith("2"):
        raise FormatError("only version 2 of glTF can be read: export it again.")
    unreadable = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"} & set(
        tree.get("extensionsRequired", [])
    )
    if unreadable:
        raise FormatError(
            f"the geometry is compressed ({', '.join(sorted(unreadable))}); export without compression."
        )
    buffers = [_buffer(entry, chunk, path) for entry in tree.get("buffers", [])]
    places = _places(tree)
    planned, parts, skipped, primitives, n = 0, [], 0, 0, 0
    for mesh, matrix in places:
        for primitive in tree["meshes"][mesh]["primitives"]:
            mode = primitive.get("mode", TRIANGLES)
            if mode not in (TRIANGLES, STRIP, FAN):
                skipped += 1
                continue
            points = _accessor(tree, buffers, primitive["attributes"]["POSITION"]).astype(np.float64)
            if points.ndim != 2:
                raise FormatError("POSITION must hold three numbers for each vertex. The file is damaged.")
            faces = _triangles(tree, buffers, primitive, mode, len(points))
            planned += len(faces) + len(points)
            promised(
                planned,
                "triangles and vertices in all nodes",
                MAX_TRIANGLES,
                "at most can be read; they do not",
            )
            wrong = int(np.count_nonzero(faces >= len(points)))
            if wrong:
                raise FormatError(
                    f"{wrong} indices of a primitive exceed its {len(points)} vertices. It is damaged."
                )
            parts.append(
                (points @ matrix[:3, :3].T + matrix[:3, 3], faces + n, np.linalg.det(matrix[:3, :3]) < 0)
            )
            n += len(points)
            primitives += 1
    notes = []
    if skipped:
        notes.append(f"{skipped} primitive(s) of points or lines left out.")
    if primitives > 1:
        notes.append(
            f"{primitives} parts put together in the order of the scene's nodes; vertices count on "
            "through them."
        )
    if not parts:
        return equal_polygons(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    # A mirroring transform turns triangles inside out, so their corners are exchanged (as renderers do).
    faces = np.concatenate([f[:, [0, 2, 1]] if mirrored else f for _, f, mirrored in parts])
    return equal_polygons(np.concatenate([points for points, _, _ in parts]), faces, notes)


def _json(data: bytes) -> dict[str, Any]:
    tree = json.loads(data.decode("utf-8-sig"))
    if not isinstance(tree, dict):
        raise FormatError("the JSON of a glTF file must be an object.")
    return tree


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes | None]:
    version, length = np.frombuffer(data, "<u4", 2, 4).tolist()
    if version != 2:
        raise FormatError(f"GLB version {version} cannot be read, only 2: export it again.")
    promised(length, "bytes", len(data), "bytes")
    at, tree, binary = 12, None, None
    while at + 8 <= length:
        size, kind = np.frombuffer(data, "<u4", 2, at).tolist()
        promised(size, "bytes in a chunk", len(data) - at - 8, "bytes")
        chunk = data[at + 8 : at + 8 + size]
        if kind == 0x4E4F534A and tree is None:
            tree = _json(chunk)
        elif kind == 0x004E4942 and binary is None:
            binary = chunk
        at += 8 + size
    if tree is None:
        raise FormatError("no JSON chunk. The file is damaged: export it again.")
    return tree, binary


def _buffer(entry: dict[str, Any], chunk: bytes | None, path: Path) -> bytes:
    """The bytes of a buffer: the GLB's own chunk, a data URI, or a file in the same folder."""
    uri = entry.get("uri")
    if uri is None:
        out = chunk or b""
    elif uri.startswith("data:"):
        out = base64.b64decode(uri.partition("base64,")[2])
    else:
        # Only plain names in the mesh's own folder: a mesh has no business reading elsewhere.
        name = unquote(uri)
        if Path(name).name != name or "\\" in name:
            raise FormatError(f"buffer {uri[:80]!r} lies outside the file's folder; put it beside the file.")
        try:
            out = (path.parent / name).read_bytes()
        except OSError as error:
            raise FormatError(
                f"its buffer {uri[:80]!r} cannot be read ({error.strerror}); put it beside the file."
            ) from error
    promised(entry["byteLength"], "bytes in a buffer", len(out), "bytes")
    return out


def _accessor(tree: dict[str, Any], buffers: list[bytes], index: int) -> NDArray:
    """The numbers of one accessor: (count,) or (count, 3)."""
    entry = tree["accessors"][_natural(index)]
    if "sparse" in entry or "bufferView" not in entry:
        raise FormatError("sparse or compressed geometry cannot be read; export plain triangles.")
    view = tree["bufferViews"][_natural(entry["bufferView"])]
    dtype, width = np.dtype(COMPONENTS[entry["componentType"]]), WIDTHS[entry["type"]]
    count, item = _natural(entry["count"]), dtype.itemsize * width
    stride = _natural(view.get("byteStride", item))
    start = _natural(view.get("byteOffset", 0)) + _natural(entry.get("byteOffset", 0))
    buffer = buffers[_natural(view["buffer"])]
    if stride < item:
        raise FormatError("byteStride is smaller than one item. The file is damaged: export it again.")
    promised(
        start + max(count - 1, 0) * stride + item * (count > 0), "bytes in a buffer", len(buffer), "bytes"
    )
    raw = (
        np.ndarray((count, width), dtype, buffer, start, (stride, dtype.itemsize))
        if count
        else np.zeros((0, width))
    )
    values = np.array(raw)
    if entry.get("normalized") and dtype.kind in "iu":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values if width > 1 else values[:, 0]


def _triangles(
    tree: dict[str, Any], buffers: list[bytes], primitive: dict[str, Any], mode: int, n: int
) -> Ints:
    flat = np.arange(n)
    if "indices" in primitive:
        flat = _accessor(tree, buffers, primitive["indices"]).astype(np.int64)
    if flat.ndim != 1 or (mode == TRIANGLES and len(flat) % 3):
        raise FormatError(f"{flat.size} indices do not form triangles. The file is damaged: export it again.")
    if mode == TRIANGLES:
        return flat.reshape(-1, 3)
    step = np.arange(max(len(flat) - 2, 0))
    if mode == FAN:
        return flat[np.stack([0 * step, step + 1, step + 2], axis=1)]
    odd = step % 2  # every second triangle of a strip runs the other way
    return flat[np.stack([step, step + 1 + odd, step + 2 - odd], axis=1)]


def _places(tree: dict[str, Any]) -> list[tuple[int, Floats]]:
    """Mesh number and transform of every node of the scene that has a mesh, depth first."""
    nodes = tree.get("nodes", [])
    if "scenes" not in tree:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [k for k in range(len(nodes)) if k not in children]
    else:
        roots = tree["scenes"][_natural(tree.get("scene", 0))].get("nodes", [])
    if not nodes:
        return [(k, np.eye(4)) for k in range(len(tree.get("meshes", [])))]
    stack = [(root, np.eye(4)) for root in reversed(roots)]
    seen: set[int] = set()
    places = []
    while stack:
        index, above = stack.pop()
        if index in seen:
            raise FormatError(f"node {index} stands in the tree twice. The file is damaged: export it again.")
        seen.add(index)
        node = nodes[_natural(index)]
        matrix = above @ _local(node)
        if "mesh" in node:
            places.append((_natural(node["mesh"]), matrix))
        stack += [(child, matrix) for child in reversed(node.get("children", []))]
    return places


def _local(node: dict[str, Any]) -> Floats:
    """The transform of a node against its parent: a matrix, or translation after rotation after scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = (float(value) for value in node.get("rotation", (0, 0, 0, 1)))
    norm = math.hypot(x, y, z, w) or 1.0
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    out[:3, 3] = node.get("translation", (0, 0, 0))
    return out


def _natural(value: Any) -> int:
    if not isinstance(value, int) or value < 0:
        raise FormatError(f"expected a number from 0, found {value!r}. The file is damaged: export it again.")
    return value
