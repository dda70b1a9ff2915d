"""The dense map along an alignment of two whole surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from ..registration.dense import dense_map
from ..registration.sparse import Registration
from ..results.surface_map import SurfaceMap
from ..surface.surface import Surface
from .alignment import Alignment, register_iteratively
from .coarse_map import transport_plan
from .evidence import evidence, log_odds
from .parameters import AlignmentParameters


def dense_map_of_alignment(
    source: Surface, target: Surface, alignment: Alignment, parameters: AlignmentParameters
) -> SurfaceMap:
    """The map of all the user's vertices, both ways, along an alignment.

    The slimmer surface, that of longer distances per sqrt(area), is deformed to the other. A long leg that has to be
    compressed to a short one spreads over it by its own rigidity; a short one that has to be stretched would hang on at
    its ends alone, with a foot drawn over half a shin. Open surfaces have no limbs that tell: each of two is registered
    to the other, and the registration of higher score is used. So it is where the target, registered to the source,
    ends in another alignment than the one that the matches are from.
    """
    slimness, other = (surface.normalized_distances.mean() for surface in (source, target))
    both_open = min(source.rim_length, target.rim_length) >= parameters.discs.least_rim
    if other <= slimness and not both_open:
        there = register_iteratively(source, target, alignment, parameters)
        return dense_map(source, target, there, parameters.registration)
    back = _registered_backward(source, target, alignment, parameters)
    if both_open or not _same_alignment(
        source, target, alignment.registered(source, target, parameters), back, parameters
    ):
        there = register_iteratively(source, target, alignment, parameters)
        scores = log_odds([evidence(source, target, there), evidence(target, source, back)], parameters.choice)
        if scores[0] >= scores[1]:
            return dense_map(source, target, there, parameters.registration)
    return dense_map(target, source, back, parameters.registration).inverse


def _same_alignment(
    source: Surface, target: Surface, there: Registration, back: Registration, parameters: AlignmentParameters
) -> bool:
    """Whether registrations of the source to the target and back are of one alignment, as in `distinct_alignments`."""
    nearest = scipy.spatial.cKDTree(back.positions).query(source.mesh.vertices[source.proxy])[1]
    apart = np.linalg.norm(target.mesh.vertices[target.proxy[nearest]] - there.positions, axis=1).mean()
    return bool(apart < parameters.clusters.radius / 2 * target.scale)


def _registered_backward(
    source: Surface, target: Surface, alignment: Alignment, parameters: AlignmentParameters
) -> Registration:
    """The target registered to the source, along an alignment of the source, iteratively."""
    registered = alignment.registered(source, target, parameters)
    plan = transport_plan(source, target, registered.image, parameters.coarse_map)
    reversed_alignment = replace(
        alignment,
        image=source.proxy[plan.argmax(axis=0)],
        registration=None,
        constraints=alignment.constraints and alignment.constraints.inverse,
    )
    return register_iteratively(target, source, reversed_alignment, parameters)
