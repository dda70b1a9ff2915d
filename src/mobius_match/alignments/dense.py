"""The dense map along an alignment of two whole surfaces."""

from __future__ import annotations

from dataclasses import replace

from ..registration.dense import dense_map
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .alignment import Alignment, register_iteratively
from .coarse_map import transport_plan
from .parameters import AlignmentParameters


def dense_map_of_alignment(
    source: Surface, target: Surface, alignment: Alignment, parameters: AlignmentParameters
) -> SurfaceMap:
    """The map of all the user's vertices, both ways, along an alignment.

    The slimmer surface, that of longer distances per sqrt(area), is deformed to the other. A long leg that has to be
    compressed to a short one spreads over it by its own rigidity; a short one that has to be stretched would hang on at
    its ends alone, with a foot drawn over half a shin.
    """
    slimness, other = (surface.normalized_distances.mean() for surface in (source, target))
    if other <= slimness:
        registration = register_iteratively(source, target, alignment, parameters)
        return dense_map(source, target, registration, parameters.registration)
    registered = alignment.registered(source, target, parameters)
    plan = transport_plan(source, target, registered.image, parameters.coarse_map)
    reversed_alignment = replace(
        alignment,
        image=source.proxy[plan.argmax(axis=0)],
        registration=None,
        constraints=alignment.constraints and alignment.constraints.inverse,
    )
    registration = register_iteratively(target, source, reversed_alignment, parameters)
    return dense_map(target, source, registration, parameters.registration).inverse
