"""The dense map along an explanation of two whole surfaces."""

from __future__ import annotations

from dataclasses import replace

from ..registration.dense import dense_map
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .coarse_map import plan_along
from .explanation import Explanation, settled

SLIMMER = 1.05
"""How many times longer, per sqrt(area), distances on the target are on the whole where it is the one that is bent."""


def map_along(source: Surface, target: Surface, explanation: Explanation) -> SurfaceMap:
    """The map of all the user's vertices, both ways, along an explanation of two whole surfaces.

    The slimmer surface is bent onto the other. What has to be pressed together (a long leg onto a short one) spreads by
    its own rigidity; what has to be stretched hangs on at its ends alone, and a foot is drawn over half a shin.
    """
    slimness, other = (surface.normalized_distances.mean() for surface in (source, target))
    if other <= SLIMMER * slimness:
        return dense_map(source, target, settled(source, target, explanation))
    image = source.proxy[plan_along(source, target, explanation.registered(source, target).image).argmax(axis=0)]
    hints = explanation.hints and explanation.hints.inverse
    turned_round = replace(explanation, image=image, registration=None, hints=hints)
    return dense_map(target, source, settled(target, source, turned_round)).inverse
