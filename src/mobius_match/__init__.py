"""Which point of one surface is which point of another: Möbius Voting for Surface Correspondence.

>>> import mobius_match as mm
>>> result = mm.match("cat0.off", "cat1.off", seed=0)  # doctest: +SKIP
>>> result.pairs, result.confidence  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .errors import FormatError, MeshError, MobiusError, NothingFoundError, SettingsError, TopologyError

if TYPE_CHECKING:
    from .correspondence import Correspondence
    from .dense import SurfaceMap
    from .dense.quality import Quality, isometric_distance, quality
    from .export import read_landmarks
    from .matching import match
    from .mesh import Mesh, read_mesh
    from .mirror import Symmetry, symmetry
    from .preparing import prepare
    from .rematching import rematch
    from .settings import MatchSettings, PrepareSettings
    from .surface import Surface

__version__ = "0.1.0"

# Names that need numerical libraries are imported when they are first used, so that the command answers at once.
_HOMES = {
    "Correspondence": "correspondence",
    "MatchSettings": "settings",
    "Mesh": "mesh",
    "PrepareSettings": "settings",
    "Quality": "dense",
    "Surface": "surface",
    "SurfaceMap": "dense",
    "Symmetry": "mirror",
    "isometric_distance": "dense",
    "match": "matching",
    "quality": "dense",
    "prepare": "preparing",
    "read_landmarks": "export",
    "read_mesh": "mesh",
    "rematch": "rematching",
    "symmetry": "mirror",
}

__all__ = [
    "Correspondence",
    "FormatError",
    "MatchSettings",
    "Mesh",
    "MeshError",
    "MobiusError",
    "NothingFoundError",
    "PrepareSettings",
    "Quality",
    "SettingsError",
    "Surface",
    "SurfaceMap",
    "Symmetry",
    "TopologyError",
    "__version__",
    "isometric_distance",
    "match",
    "prepare",
    "quality",
    "read_landmarks",
    "read_mesh",
    "rematch",
    "symmetry",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
