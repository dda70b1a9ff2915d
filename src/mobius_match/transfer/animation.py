"""Shapes in a row as one glTF 2.0 file: a mesh with a morph target for each shape, and an animation through them."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from ..geometry.normals import vertex_normals

FLOAT, UNSIGNED_INT = 5126, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


def animated_glb(shapes: np.ndarray, faces: np.ndarray, seconds: float = 2.0) -> bytes:
    """A .glb file that plays shapes one after the other.

    Parameters
    ----------
    shapes
        (T, n, 3) positions; the first is the mesh, the others are its morph targets. At least two.
    faces
        (m, 3) vertex numbers.
    seconds
        Length of the animation; shapes follow each other at equal steps.
    """
    normals = np.stack([vertex_normals(shape, faces) for shape in shapes])
    normals[np.linalg.norm(normals, axis=2) < 0.5] = [0.0, 0.0, 1.0]  # the format wants them of length 1
    shapes, normals = shapes.astype(np.float32), normals.astype(np.float32)
    file = _Binary()
    count = len(shapes) - 1
    base = {
        "POSITION": file.add(shapes[0], "VEC3", ARRAY_BUFFER, limits=True),
        "NORMAL": file.add(normals[0], "VEC3", ARRAY_BUFFER),
    }
    indices = file.add(faces.astype(np.uint32).reshape(-1), "SCALAR", ELEMENT_ARRAY_BUFFER)
    targets = [
        {
            "POSITION": file.add(shape - shapes[0], "VEC3", ARRAY_BUFFER, limits=True),
            "NORMAL": file.add(normal - normals[0], "VEC3", ARRAY_BUFFER),
        }
        for shape, normal in zip(shapes[1:], normals[1:], strict=True)
    ]
    times = file.add(np.linspace(0, seconds, len(shapes), dtype=np.float32), "SCALAR", limits=True)
    weights = file.add(np.eye(count + 1, dtype=np.float32)[:, 1:].reshape(-1), "SCALAR")
    tree = {
        "asset": {"version": "2.0", "generator": "mobius-match"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "morph"}],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.8, 0.81, 0.83, 1.0],
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.8,
                },
                "doubleSided": True,
            }
        ],
        "meshes": [
            {
                "name": "morph",
                "primitives": [{"attributes": base, "indices": indices, "material": 0, "mode": 4, "targets": targets}],
                "weights": [0.0] * count,
            }
        ],
        "animations": [
            {
                "name": "morph",
                "samplers": [{"input": times, "output": weights, "interpolation": "LINEAR"}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            }
        ],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": len(file.data)}],
    }
    text = json.dumps(tree, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(file.data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(file.data), b"BIN\0"),
            bytes(file.data),
        ]
    )


class _Binary:
    """The binary chunk, each array in a view of its own; all items are of 4 bytes, so all are aligned."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: np.ndarray, kind: str, use: int | None = None, *, limits: bool = False) -> int:
        """Append an array of float32 or uint32 and give the number of its accessor."""
        content = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)}
        self.views.append(view if use is None else view | {"target": use})
        self.data += content
        accessor: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": FLOAT if array.dtype == np.float32 else UNSIGNED_INT,
            "count": len(array),
            "type": kind,
        }
        if limits:
            rows = array.reshape(len(array), -1).astype(np.float64)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1
