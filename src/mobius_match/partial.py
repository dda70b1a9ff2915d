"""A surface that was cut off from a larger one, found on it.

Beyond the paper, whose surfaces are whole. A part has another conformal structure, other eigenfunctions and another
area than the whole that it belongs to; what it keeps are lengths, curvature and, away from the cut, distances. So both
are measured in common units, which their files must share. Triplets of samples are judged by geodesic distances
instead of Möbius maps, the places that the best of them send the part to are compared, and the part is bent onto the
whole at the best. Each way of matching reads its matches off the bent part.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from .geometry.points import SurfacePoints
from .hints import Hints
from .locating import Pair
from .mesh.topology import boundary_edges
from .registration import Registration
from .surface import Surface

LARGEST = 0.97
"""Part of the other surface's area above which a surface is taken for a whole, though it has a boundary."""

SCALES = (1.0, 1 / 1.2, 1.2)
"""Sizes of the part that are tried, the second and third where the first leads to no good place."""

GOOD, BETTER = 0.6, 0.8
"""Badness of a good place, and how much less, as a factor, that at another size has to be."""

OPEN = 0.15
"""Least length of the boundary of a part, per sqrt(area) of the whole."""


@dataclass(frozen=True, eq=False)
class PartPlaces:
    """Where one surface lies that is a part of the other.

    Parameters
    ----------
    points, chances
        (N1,) points of the target for the source's samples, and the chance that each is right, 0 for a sample that
        lies on what is missing.
    part, whole, registration, part_is_source
        The two surfaces in common units, the part bent onto the whole, and which of them is which.
    """

    points: SurfacePoints
    chances: np.ndarray
    part: Surface
    whole: Surface
    registration: Registration
    part_is_source: bool


def part_places(
    source: Surface, target: Surface, seed: int, jobs: int | None = None, hints: Hints | None = None
) -> tuple[PartPlaces | None, str]:
    """Where the source's samples lie on the target, if one of the two is a part of the other.

    The part may be up to a third larger or smaller than the units of the files say, not more.

    Parameters
    ----------
    source, target
        The surfaces, in about the same units.
    seed
        Of the triplets.
    jobs
        Threads; None for as many as there are processors. The result does not depend on it.
    hints
        Pairs that are known.

    Returns
    -------
    places
        None if neither is a part of the other.
    note
        What a user should know of it, empty where neither looks like a part.
    """
    if not is_part(source, target) and not is_part(target, source):
        return None, ""
    part, whole = (source, target) if source.area < target.area else (target, source)
    if hints is not None and part is target:
        hints = hints.inverse
    places, least, size = None, np.inf, 1.0
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        for scale in SCALES:
            if part.area * scale**2 > LARGEST * whole.area:
                continue
            pair = Pair(replace(part, area=whole.area / scale**2), whole, hints)
            found = pair.located(np.random.default_rng(seed), pool)
            if found is not None and pair.badness(found) < BETTER * least:
                least, size = pair.badness(found), scale
                points, chances = pair.places_on_whole(found) if part is source else pair.places_on_part(found)
                places = PartPlaces(points, chances, pair.part, whole, found, part is source)
            if least <= GOOD:
                break
    share = f"{part.mesh.name} has a long boundary, and {part.area / whole.area:.0%} of the area of {whole.mesh.name}"
    if places is None:
        return None, f"{share}, but was not found on it in the units of the files; it was matched as a whole"
    units = "in the units of the files" if size == 1 else f"at {size:.2f} times its size"
    return places, f"{share}; it was matched as a part of it, {units}"


def is_part(surface: Surface, other: Surface) -> bool:
    """Whether a surface may be a part of another: it has a long boundary, and in the units of the files less area."""
    if surface.area > LARGEST * other.area:
        return False
    ends = surface.mesh.vertices[boundary_edges(surface.mesh.faces)]
    return bool(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() > OPEN * np.sqrt(other.area))
