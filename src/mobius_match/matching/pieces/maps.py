"""The map of two pieces: the best of those that may be made of them, by its cost and its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ...alignments.alignment import Alignment
from ...alignments.dense import dense_map_of_alignment
from ...results.correspondence import Correspondence
from ...results.surface_map import SurfaceMap
from ...surface.surface import Surface
from .copies import laid_on, size_of
from .search import PieceSearch, map_cost, proxy_image

CLOSE = 0.05
"""Error of a match, as a fraction of the target's diameter, that confidence is the probability of not exceeding."""


def best_map(
    first: Surface, second: Surface, carried: np.ndarray, whole: Correspondence | None, search: PieceSearch
) -> tuple[SurfaceMap, Correspondence | None]:
    """The dense map of two pieces of least cost, and the matches that it confirms.

    Parameters
    ----------
    first, second
        The surfaces of the two pieces.
    carried
        (n1, 3) where the first one's vertices are, as far as other pieces tell.
    whole
        The match of the two by the whole method, if there is one.
    search
        The constants.

    Returns
    -------
    dense
        Of three maps: the piece laid onto the other one from where it was carried, the same after registration, and
        that of the whole method; the cost is that of the map and its mean distance from there, over the target's size.
    matches
        Those of the whole method that the map confirms; None if there are none.
    """
    meshes = first.whole_mesh, second.whole_mesh
    found = [] if whole is None else [whole.dense()]
    known = [len(mesh.vertices) for dense in found for mesh in (dense.source, dense.target)]
    if known not in ([], [len(mesh.vertices) for mesh in meshes]):  # of another reading, cut open elsewhere
        return found[0], whole
    copy = laid_on(meshes[0], meshes[1], carried, search.normal)
    # One BLAS thread: sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        alignment = Alignment(proxy_image(first, second, copy), {}, 0.0, 0.0)
        found = [copy, dense_map_of_alignment(first, second, alignment, search.alignment), *found]
        size = size_of(meshes[1].vertices)

        def total(dense: SurfaceMap) -> float:
            positions = dense.target_points.values(dense.target.vertices)
            away = np.linalg.norm(positions - carried, axis=1)[dense.source_mapped]
            place = float(away.mean()) / size if len(away) else np.inf
            return map_cost(first, second, dense, search.alignment.cost) + place

        dense = min(found, key=total)
    return dense, None if whole is None else _agreeing(whole, dense)


def _agreeing(result: Correspondence, dense: SurfaceMap) -> Correspondence | None:
    """The matches that a dense map of the same pieces confirms; None if there are none.

    It does if they end within 5 % of the target's diameter, the error that their confidence is about.
    """
    rows = [np.zeros(mesh.n_file_vertices, np.int64) for mesh in (dense.source, dense.target)]
    for row, mesh in zip(rows, (dense.source, dense.target), strict=True):
        row[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertices))[::-1]
    here, there = rows[0][result.pairs[:, 0]], rows[1][result.pairs[:, 1]]
    away = np.linalg.norm(dense.positions[here] - dense.target.vertices[there], axis=1)
    kept = np.flatnonzero(away <= CLOSE * result.target_info["diameter"])
    if not len(kept):
        return None
    points = result.target_points
    return replace(
        result,
        pairs=result.pairs[kept],
        confidence=result.confidence[kept],
        kind=result.kind[kept],
        target_points=None if points is None else points[kept],
    )
