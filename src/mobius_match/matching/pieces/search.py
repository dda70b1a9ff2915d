"""What matching pieces needs: how to match two of them, pairs of pieces, and the cost of their maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..._core.display import one_line
from ...alignments.cost import cost_terms, total_cost
from ...alignments.parameters import AlignmentParameters, CostParameters
from ...errors import SettingsError
from ...mesh import Mesh
from ...results.correspondence import Correspondence
from ...results.surface_map import SurfaceMap
from ...settings import MatchSettings, PrepareSettings
from ...surface.parameters import SurfaceParameters
from ...surface.prepare import prepare_mesh
from ...surface.surface import Surface
from .parameters import PiecesParameters

Matcher = Callable[[Surface, Surface], Correspondence]
"""Matches two surfaces of one piece each."""


@dataclass(frozen=True)
class PieceSearch:
    """What is needed to match pieces, beside the shapes.

    Parameters
    ----------
    match
        Matches two surfaces of one piece.
    settings
        The settings of the match.
    surface, alignment, parameters
        The constants.
    """

    match: Matcher
    settings: MatchSettings
    surface: SurfaceParameters
    alignment: AlignmentParameters
    parameters: PiecesParameters

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def controls(self) -> int:
        """As in :func:`.riding.map_of_all_pieces`: as many as the proxy of a surface has."""
        return self.surface.proxy_size

    @property
    def normal(self) -> float:
        """Weight of normals against positions where closest points are searched, as in dense registration."""
        return self.alignment.registration.dense_normal

    def prepare(self, mesh: Mesh, settings: PrepareSettings) -> Surface:
        """The surface of one piece."""
        return prepare_mesh(mesh, settings, parameters=self.surface)


@dataclass(frozen=True, eq=False)
class PiecePair:
    """Two pieces that are matched with each other.

    Parameters
    ----------
    source, target
        Numbers of the two pieces.
    result
        Their match; None where they are too small for one, or have none.
    dense
        Their dense map.
    """

    source: int
    target: int
    result: Correspondence | None
    dense: SurfaceMap

    def __repr__(self) -> str:
        return one_line(self)


def without_preparation(settings: MatchSettings) -> dict[str, Any]:
    """The settings of a match, by name, that are not those of the preparation."""
    return {one.name: getattr(settings, one.name) for one in fields(settings) if not hasattr(PrepareSettings, one.name)}


def surfaces_of(result: Correspondence) -> tuple[Surface, Surface]:
    """The two surfaces of a result that was just computed."""
    if result.source is None or result.target is None:
        raise SettingsError("a result that was loaded from a file holds no surfaces; match again")
    return result.source, result.target


def proxy_image(source: Surface, target: Surface, dense: SurfaceMap) -> np.ndarray:
    """The target vertex (P,) of each vertex of the source's proxy, by the dense map of the two surfaces."""
    images = dense.target_points.nearest
    if source.detail is not None:
        images = images[source.detail.kept]
    if target.detail is not None:
        images = target.detail.places(target.mesh).nearest[images]
    return np.asarray(images[source.proxy])


def map_cost(source: Surface, target: Surface, dense: SurfaceMap, parameters: CostParameters) -> float:
    """The cost of the dense map of two surfaces, by the images of the source's proxy."""
    image = target.nearest_proxy[proxy_image(source, target, dense)]
    return total_cost(cost_terms(source, target, image, parameters), parameters.weights)
