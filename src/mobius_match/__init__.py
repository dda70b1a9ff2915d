"""Matching points between two surfaces: Möbius Voting for Surface Correspondence.

>>> import mobius_match as mm
>>> result = mm.match("cat0.off", "cat1.off", seed=0)  # doctest: +SKIP
>>> result.pairs, result.confidence  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .errors import (
    FormatError,
    MeshError,
    MissingPackageError,
    MobiusError,
    NothingFoundError,
    SettingsError,
    TopologyError,
)
from .results.actions import provide

if TYPE_CHECKING:
    from .evaluation import examples
    from .evaluation.quality import Quality, isometric_distance, quality
    from .exporting.figures import draw_matches, draw_shapes
    from .exporting.formats import export
    from .geometry.points import SurfacePoints
    from .landmarks.formats import read_landmarks, write_landmarks
    from .landmarks.tables import Landmarks
    from .matching.match import match
    from .matching.rematch import rematch
    from .matching.symmetry.symmetry import symmetry
    from .mesh import Mesh, read_mesh
    from .results.correspondence import Correspondence
    from .results.functional import Eigenbasis
    from .results.matches import Alternative
    from .results.surface_map import SurfaceMap
    from .results.symmetry import Symmetry
    from .settings import MatchSettings, PrepareSettings
    from .surface.prepare import prepare
    from .surface.surface import Surface
    from .transfer.animation import animated_glb
    from .transfer.morph import morph
    from .transfer.transfer import Transfer
    from .viewer import page
    from .viewer.opening import View
    from .voting.votes import Votes

__version__ = "0.1.0"

# Names that need numerical libraries are imported when they are first used, so that the command answers at once.
_HOMES = {
    "Alternative": "results.matches",
    "animated_glb": "transfer.animation",
    "Correspondence": "results.correspondence",
    "draw_matches": "exporting.figures",
    "draw_shapes": "exporting.figures",
    "Eigenbasis": "results.functional",
    "export": "exporting.formats",
    "isometric_distance": "evaluation.quality",
    "Landmarks": "landmarks.tables",
    "match": "matching.match",
    "MatchSettings": "settings",
    "Mesh": "mesh",
    "morph": "transfer.morph",
    "page": "viewer",
    "prepare": "surface.prepare",
    "PrepareSettings": "settings",
    "Quality": "evaluation.quality",
    "quality": "evaluation.quality",
    "read_landmarks": "landmarks.formats",
    "read_mesh": "mesh",
    "rematch": "matching.rematch",
    "Surface": "surface.surface",
    "SurfaceMap": "results.surface_map",
    "SurfacePoints": "geometry.points",
    "Symmetry": "results.symmetry",
    "symmetry": "matching.symmetry.symmetry",
    "Transfer": "transfer.transfer",
    "View": "viewer.opening",
    "Votes": "voting.votes",
    "write_landmarks": "landmarks.formats",
}

# What a result does by name, of rooms that it does not import itself.
provide(
    show=f"{__name__}.viewer:show",
    export=f"{__name__}.exporting.formats:export",
    endings=f"{__name__}.exporting.formats:endings",
)

__all__ = [
    "Alternative",
    "Correspondence",
    "Eigenbasis",
    "FormatError",
    "Landmarks",
    "MatchSettings",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "MobiusError",
    "NothingFoundError",
    "PrepareSettings",
    "Quality",
    "SettingsError",
    "Surface",
    "SurfaceMap",
    "SurfacePoints",
    "Symmetry",
    "TopologyError",
    "Transfer",
    "View",
    "Votes",
    "__version__",
    "animated_glb",
    "draw_matches",
    "draw_shapes",
    "examples",
    "export",
    "isometric_distance",
    "match",
    "morph",
    "page",
    "prepare",
    "quality",
    "read_landmarks",
    "read_mesh",
    "rematch",
    "symmetry",
    "write_landmarks",
]


def __getattr__(name: str) -> Any:
    if name == "examples":
        return import_module(".evaluation.examples", __name__)
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
