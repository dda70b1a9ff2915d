"""A sequence of shapes as a glTF 2.0 file: a mesh with a morph target for each shape, and an animation."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from ..geometry.normals import vertex_normals
from .colours import SURFACE_GREY

# Constants of the glTF 2.0 specification.
FLOAT, UNSIGNED_INT = 5126, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


def animated_glb(shapes: np.ndarray, faces: np.ndarray, seconds: float = 2.0) -> bytes:
    """A binary glTF file (.glb) that plays shapes one after the other.

    Parameters
    ----------
    shapes
        (T, n, 3) positions; the first is the mesh, the others are its morph targets. At least two.
    faces
        (m, 3) vertex numbers.
    seconds
        Length of the animation; the shapes are at equal intervals.

    Returns
    -------
    bytes
        The content of the file, with positions and normals in single precision.
    """
    normals = np.stack([vertex_normals(shape, faces) for shape in shapes])
    normals[np.linalg.norm(normals, axis=2) < 0.5] = [0.0, 0.0, 1.0]  # the format requires unit normals
    shapes, normals = shapes.astype(np.float32), normals.astype(np.float32)
    binary = _BinaryChunk()
    n_targets = len(shapes) - 1
    base = {
        "POSITION": binary.add(shapes[0], "VEC3", ARRAY_BUFFER, limits=True),
        "NORMAL": binary.add(normals[0], "VEC3", ARRAY_BUFFER),
    }
    indices = binary.add(faces.astype(np.uint32).reshape(-1), "SCALAR", ELEMENT_ARRAY_BUFFER)
    targets = [
        {
            "POSITION": binary.add(shape - shapes[0], "VEC3", ARRAY_BUFFER, limits=True),
            "NORMAL": binary.add(normal - normals[0], "VEC3", ARRAY_BUFFER),
        }
        for shape, normal in zip(shapes[1:], normals[1:], strict=True)
    ]
    times = binary.add(np.linspace(0, seconds, len(shapes), dtype=np.float32), "SCALAR", limits=True)
    weights = binary.add(np.eye(n_targets + 1, dtype=np.float32)[:, 1:].reshape(-1), "SCALAR")
    tree = {
        "asset": {"version": "2.0", "generator": "mobius-match"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "morph"}],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*SURFACE_GREY, 1.0],
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
                "weights": [0.0] * n_targets,
            }
        ],
        "animations": [
            {
                "name": "morph",
                "samplers": [{"input": times, "output": weights, "interpolation": "LINEAR"}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            }
        ],
        "accessors": binary.accessors,
        "bufferViews": binary.views,
        "buffers": [{"byteLength": len(binary.data)}],
    }
    text = json.dumps(tree, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary.data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary.data), b"BIN\0"),
            bytes(binary.data),
        ]
    )


class _BinaryChunk:
    """The binary chunk, each array in a buffer view of its own; all items have 4 bytes, so all are aligned."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: np.ndarray, kind: str, target: int | None = None, *, limits: bool = False) -> int:
        """Append an array of float32 or uint32 and return the number of its accessor."""
        content = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)}
        self.views.append(view if target is None else view | {"target": target})
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
