"""Meshes: read from files or arrays, checked and repaired. Vertex and face numbers of the user are always kept."""

from __future__ import annotations

from .files import as_mesh, read_mesh, unchanged
from .mesh import Mesh
from .repair import repair
from .report import describe, require_matchable

__all__ = ["Mesh", "as_mesh", "describe", "read_mesh", "repair", "require_matchable", "unchanged"]
