"""glTF 2, .glb and .gltf, read by trimesh from a tree that contains only geometry and node transforms.

Materials and images are never opened. trimesh visits the nodes from last to first, so their order is reversed before;
it fills sparse and compressed geometry with zeros, so such files are refused.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ...errors import FormatError
from .raw import RawMesh, promised
from .scenes import concatenated, placed_parts

FLOAT, TRIANGLES, STRIP, FAN = 5126, 4, 5, 6


def read_gltf(data: bytes, path: Path) -> RawMesh:
    """Read all triangles of the scene, nodes in the order of the file, placed by their transforms."""
    tree, chunk = _chunks(data) if data[:4] == b"glTF" else (_json(data), b"")
    if not str(tree.get("asset", {}).get("version", "")).startswith("2"):
        raise FormatError("only version 2 of glTF can be read: export it again.")
    if any(word in str(tree.get("extensionsRequired", [])) for word in ("draco", "meshopt", "quantization")):
        raise FormatError("the geometry is compressed; export without compression.")
    files = {}
    for k, buffer in enumerate(tree.get("buffers", [])):
        content = _buffer(buffer, chunk, path)
        if content is not None:
            buffer["uri"], files[f"buffer{k}"] = f"buffer{k}", content
    names = _node_names(tree)
    tree, skipped = _geometry_alone(tree)
    import trimesh

    scene = trimesh.load_scene(io.BytesIO(json.dumps(tree).encode()), file_type="gltf", resolver=files, process=False)
    notes = [f"{skipped} primitive(s) of points or lines left out."] if skipped else []
    # Nodes without names are called by their numbers, with an ending where a mesh has several primitives.
    parts = [(vertices, faces, names[int(node.split("_")[0])]) for vertices, faces, (node, _) in placed_parts(scene)]
    return concatenated(parts, notes)


def _node_names(tree: dict[str, Any]) -> list[tuple[str, ...]]:
    """The names of each node: its own, that of its mesh, and those of the nodes above it."""
    meshes = tree.get("meshes", [])
    nodes = tree.get("nodes", [{"mesh": k} for k in range(len(meshes))])
    parent = {child: k for k, node in enumerate(nodes) for child in node.get("children", [])}
    found = []
    for k, node in enumerate(nodes):
        names = [str(node.get("name", "")), str(meshes[node["mesh"]].get("name", "")) if "mesh" in node else ""]
        seen = {k}
        while k in parent and parent[k] not in seen:  # a damaged file may go round in circles
            k = parent[k]
            seen.add(k)
            names.append(str(nodes[k].get("name", "")))
        found.append(tuple(names))
    return found


def _json(data: bytes) -> dict[str, Any]:
    tree = json.loads(data.decode("utf-8-sig"))
    if not isinstance(tree, dict):
        raise FormatError("the JSON of a glTF file must be an object.")
    return tree


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    version, length = np.frombuffer(data, "<u4", 2, 4).tolist()
    if version != 2:
        raise FormatError(f"GLB version {version} cannot be read, only 2: export it again.")
    promised(length, "bytes", len(data), "bytes")
    at, found = 12, {0x4E4F534A: b"{}", 0x004E4942: b""}  # JSON, BIN
    while at + 8 <= length:
        size, kind = np.frombuffer(data, "<u4", 2, at).tolist()
        promised(size, "bytes in a chunk", len(data) - at - 8, "bytes")
        found[kind] = data[at + 8 : at + 8 + size]
        at += 8 + size
    return _json(found[0x4E4F534A]), found[0x004E4942]


def _buffer(entry: dict[str, Any], chunk: bytes, path: Path) -> bytes | None:
    """The bytes of a buffer: the GLB's own chunk or a file in the same folder; None for a data URI."""
    uri = entry.get("uri")
    if uri is not None and uri.startswith("data:"):
        return None
    if uri is not None:
        # Only files in the mesh's own folder: a mesh must not read any other.
        name = unquote(uri)
        if Path(name).name != name or "\\" in name:
            raise FormatError(f"buffer {uri[:80]!r} lies outside the file's folder; put it into that folder.")
        try:
            chunk = (path.parent / name).read_bytes()
        except OSError as error:
            raise FormatError(
                f"its buffer {uri[:80]!r} cannot be read ({error.strerror}); put it beside the file."
            ) from error
    promised(entry["byteLength"], "bytes in a buffer", len(chunk), "bytes")
    return chunk


def _geometry_alone(tree: dict[str, Any]) -> tuple[dict[str, Any], int]:
    """The checked tree for trimesh, and the number of primitives of points or lines that were left out."""
    out: dict[str, Any] = {"asset": {"version": "2.0"}, "accessors": [], "meshes": [], "scene": 0}
    out["buffers"], out["bufferViews"] = tree.get("buffers", []), tree.get("bufferViews", [])
    for view in out["bufferViews"]:
        _natural(view["buffer"], view.get("byteOffset", 0), view["byteLength"], view.get("byteStride", 4))
    skipped = 0
    for mesh in tree.get("meshes", []):
        primitives = []
        for given in mesh["primitives"]:
            mode = given.get("mode", TRIANGLES)
            if mode == FAN:
                raise FormatError("triangle fans are not read; export plain triangles.")
            if mode not in (TRIANGLES, STRIP):
                skipped += 1
                continue
            kept = {"mode": mode}
            kept["attributes"] = {"POSITION": _accessor(tree, out, given["attributes"]["POSITION"], True)}
            if "indices" in given:
                kept["indices"] = _accessor(tree, out, given["indices"], False)
            primitives.append(kept)
        out["meshes"].append({"primitives": primitives})
    nodes = tree.get("nodes", [{"mesh": k} for k in range(len(out["meshes"]))])
    children = [child for node in nodes for child in node.get("children", [])]
    roots = sorted(set(range(len(nodes))) - set(children))
    if "scenes" in tree and "nodes" in tree:
        roots = tree["scenes"][tree.get("scene", 0)].get("nodes", [])
    _natural(*roots, *children)
    for k in {*roots, *children}:
        if [*roots, *children].count(k) > 1:
            raise FormatError(f"node {k} occurs in the tree twice. The file is damaged: export it again.")
    out["scenes"] = [{"nodes": roots[::-1]}]
    out["nodes"] = [
        {
            **{key: node[key] for key in ("matrix", "translation", "rotation", "scale") if key in node},
            "children": node.get("children", [])[::-1],
            **({"mesh": node["mesh"]} if "mesh" in node and out["meshes"][node["mesh"]]["primitives"] else {}),
        }
        for node in nodes
    ]
    return out, skipped


def _accessor(tree: dict[str, Any], out: dict[str, Any], index: int, positions: bool) -> int:
    """Check and copy one accessor; return its new number."""
    entry = tree["accessors"][index]
    if "sparse" in entry or "bufferView" not in entry:
        raise FormatError("sparse or compressed geometry cannot be read; export plain triangles.")
    _natural(index, entry["bufferView"], entry["count"], entry.get("byteOffset", 0))
    kind = (entry["type"], entry["componentType"] == FLOAT)
    if kind != (("VEC3", True) if positions else ("SCALAR", False)):
        raise FormatError("positions must be triples of floats, indices whole numbers; export it again.")
    if positions and tree["bufferViews"][entry["bufferView"]].get("byteStride", 12) < 12:
        raise FormatError("byteStride is smaller than one item. The file is damaged: export it again.")
    out["accessors"].append(entry)
    return len(out["accessors"]) - 1


def _natural(*values: Any) -> None:
    for value in values:
        if not isinstance(value, int) or value < 0:
            raise FormatError(f"expected a number from 0, found {value!r}. The file is damaged.")
