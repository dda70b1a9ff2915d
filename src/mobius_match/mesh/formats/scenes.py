"""Scenes of trimesh: parts placed by the transforms of the nodes that show them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...errors import FormatError
from ..mesh import Floats, Ints
from .raw import RawMesh, from_triangles, named, promised

MAX_TRIANGLES = 50_000_000  # nodes may show one part many times: a small scene can expand to any size


Part = tuple[Floats, Ints, tuple[str, ...]]
"""Vertices (n, 3), faces (m, 3) and names of a part."""


def placed_parts(scene: Any) -> Iterator[Part]:
    """Each part with faces, node by node, in the coordinates of the scene; its names are the node's and its own.

    Raises
    ------
    FormatError
        If faces name vertices that the part does not have, or there are more than 50 million triangles.
    """
    total = 0
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        part = scene.geometry[name]
        if not hasattr(part, "faces"):
            continue
        total += len(part.faces) + len(part.vertices)
        promised(total, "triangles and vertices in all nodes", MAX_TRIANGLES, "can be read; they do not")
        wrong = int((part.faces >= len(part.vertices)).sum())
        if wrong:
            raise FormatError(f"{wrong} indices exceed the {len(part.vertices)} vertices of a part.")
        # A mirroring transform turns triangles inside out, so their corners are exchanged (as renderers do).
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        yield (
            np.asarray(part.vertices @ matrix[:3, :3].T + matrix[:3, 3]),
            np.asarray(part.faces[:, [0, 2, 1]] if mirrored else part.faces),
            (str(node), str(name)),
        )


def concatenated(parts: list[Part], notes: list[str]) -> RawMesh:
    """One mesh of several parts; where there is more than one, a note says how its vertices are numbered."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _, _ in parts])
    firsts = np.cumsum([0] + [len(faces) for _, faces, _ in parts]).tolist()
    if len(parts) > 1:
        notes.append(
            f"{len(parts)} parts combined in the order of the scene's nodes; vertices are numbered in that order."
        )
    raw = from_triangles(
        np.concatenate([np.zeros((0, 3)), *(vertices for vertices, _, _ in parts)]),
        np.concatenate(
            [np.zeros((0, 3), np.int64), *(faces + start for (_, faces, _), start in zip(parts, starts, strict=False))]
        ),
        None,
        notes,
    )
    ranges = zip(parts, firsts, firsts[1:], strict=False)
    raw.names = named([(name, start, end) for (_, _, names), start, end in ranges for name in names])
    return raw
