"""A dense map told of a mesh, and of its mirror image."""

from __future__ import annotations

from dataclasses import replace

from ..mesh.mesh import MIRROR
from .surface_map import SurfaceMap


def with_mirrored_source(surface_map: SurfaceMap) -> SurfaceMap:
    """The same map of the source's mirror image (:meth:`.Mesh.reflected`): each vertex keeps its image.

    A map that is reflected becomes one that is not, and the reverse.
    """
    carried = surface_map.target_carried
    return replace(
        surface_map,
        source=surface_map.source.reflected(),
        source_points=surface_map.source_points.in_flipped_faces,
        target_carried=None if carried is None else carried * MIRROR,
        reflected=not surface_map.reflected,
    )
