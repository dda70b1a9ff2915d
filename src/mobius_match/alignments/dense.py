"""The dense map along an explanation of two whole surfaces."""

from __future__ import annotations

from dataclasses import replace

from ..registration.dense import dense_map
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .alignment import Alignment, register_iteratively
from .coarse_map import transport_plan

SLIMMER = 1.05
"""How many times longer, per sqrt(area), distances on the target are on the whole where it is the one that is bent."""


def dense_map_of_alignment(source: Surface, target: Surface, alignment: Alignment) -> SurfaceMap:
    """The map of all the user's vertices, both ways, along an explanation of two whole surfaces.

    The slimmer surface is bent onto the other. What has to be pressed together (a long leg onto a short one) spreads by
    its own rigidity; what has to be stretched hangs on at its ends alone, and a foot is drawn over half a shin.
    """
    slimness, other = (surface.normalized_distances.mean() for surface in (source, target))
    if other <= SLIMMER * slimness:
        return dense_map(source, target, register_iteratively(source, target, alignment))
    image = source.proxy[transport_plan(source, target, alignment.registered(source, target).image).argmax(axis=0)]
    constraints = alignment.constraints and alignment.constraints.inverse
    turned_round = replace(alignment, image=image, registration=None, constraints=constraints)
    return dense_map(target, source, register_iteratively(target, source, turned_round)).inverse
