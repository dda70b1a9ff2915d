"""The mirror image of a prepared surface, without a new preparation.

Lengths, areas, curvatures and eigenfunctions of a mirror image are those of the surface, and samples stay where they
are. The plane of the flattening is mirrored, that is conjugated, and so is the unit disc. Faces are flipped, so that
they point outward.
"""

from __future__ import annotations

from dataclasses import replace

from .surface import Surface


def reflected(surface: Surface) -> Surface:
    """The mirror image of a surface at the plane x = 0; that of the mirror image is the surface itself."""
    detail = surface.detail
    if detail is not None:
        detail = replace(detail, mesh=detail.mesh.reflected(), barycentric=detail.barycentric[:, [0, 2, 1]])
    return replace(
        surface,
        mesh=surface.mesh.reflected(),
        detail=detail,
        positions=surface.positions.conj(),
        disc=surface.disc.conj(),
        other=None if surface.other is None else reflected(surface.other),
    )
