"""The votes: the flattened samples under the best triplet, and the fuzzy correspondence matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from ..exporting.result_meshes import vertices_numbered
from ..voting.assignment import max_row_column, normalized
from ..voting.kernel import mutual_pairs
from ..voting.mobius import CANONICAL_TRIANGLE, apply, from_three_points, homogeneous
from . import packing

if TYPE_CHECKING:
    from ..surface.surface import Surface
    from ..voting.votes import Votes

STEPS = 65535
"""Steps to which shares of the votes are quantised."""
NEAR = 0.15
"""Geodesic distance, per sqrt(area), up to which a triplet agrees with a match."""


def insight(source: Surface, target: Surface, votes: Votes, pairs: np.ndarray) -> dict[str, Any] | None:
    """The voting for the page, as JSON-able values.

    Parameters
    ----------
    source, target
        The prepared surfaces, of N1 and N2 samples.
    votes
        The votes that were cast.
    pairs
        (Q, 2) matches, as vertex numbers of the files. The triplet that agrees with most of them is shown.

    Returns
    -------
    dict or None
        None if no triplet can be shown: too few votes, or samples that coincide in the plane. Otherwise:
        ``samples``: vertex numbers of the samples of both sides. ``planes``: their positions in the plane, transformed
        so that the ``triplet`` lies on an equilateral triangle, with radius r mapped to r / (1 + r), which shows the
        whole plane in the unit disc. ``paired``: (N1,) the mutually nearest target sample of each source sample, -1 for
        none. ``matrix``: C divided by its largest value. ``rows`` and ``columns``: the order in which its samples are
        shown, with corresponding ones near the diagonal.
    """
    numbers = [surface.mesh.vertex_ids[surface.samples] for surface in (source, target)]
    positions = [surface.positions for surface in (source, target)]
    share = normalized(votes.matrix)
    points1, points2 = map(homogeneous, positions)
    if len(votes.best_source):
        paired = mutual_pairs(points1, points2, votes.best_source, votes.best_target)
        best = _most_agreeing(paired, target, numbers[0], pairs)
        triplets = [votes.best_source[best], votes.best_target[best]]
    else:  # uniform triplets are not stored: the three largest entries of C
        triplets = [side.copy() for side in max_row_column(votes.matrix)[0][:3].T]
        if len(triplets[0]) < 3:
            return None
        one, other = (side[None] for side in triplets)
        paired, best = mutual_pairs(points1, points2, one, other), 0
    if any(len(np.unique(plane[triplet])) < 3 for plane, triplet in zip(positions, triplets, strict=True)):
        return None
    planes = [
        _in_disc(apply(from_three_points(plane[triplet], CANONICAL_TRIANGLE), plane))
        for plane, triplet in zip(positions, triplets, strict=True)
    ]
    rows = np.argsort(source.eigenfunctions[source.samples, 1], kind="stable")
    rank = np.empty(len(rows))
    rank[rows] = np.arange(len(rows))
    weights = share**2
    columns = np.argsort(rank @ weights / np.maximum(weights.sum(axis=0), 1e-30), kind="stable")
    return {
        "samples": [side.tolist() for side in numbers],
        "planes": [packing.packed(np.stack([plane.real, plane.imag], axis=1), "<f4") for plane in planes],
        "triplet": [triplet.tolist() for triplet in triplets],
        "paired": paired[best].tolist(),
        "triplets": votes.n_triplets,
        "rows": rows.tolist(),
        "columns": columns.tolist(),
        "matrix": packing.packed(np.round(STEPS * share), "<u2"),
    }


def _most_agreeing(paired: np.ndarray, target: Surface, numbers: np.ndarray, pairs: np.ndarray) -> int:
    """The triplet of those with samples ``paired`` (B, N1) that pairs most samples with one near their match."""
    whole = target.whole_mesh
    positions = whole.vertices[vertices_numbered(whole, pairs[:, 1])]
    nearest = cKDTree(target.mesh.vertices[target.samples]).query(positions)[1]
    matched = np.full(paired.shape[1], -1)
    sample, match = np.nonzero(numbers[:, None] == pairs[:, 0])
    matched[sample] = nearest[match]
    agree = (paired >= 0) & (matched >= 0) & (target.normalized_distances[paired, matched] < NEAR)
    return int(agree.sum(axis=1).argmax())


def _in_disc(plane: np.ndarray) -> np.ndarray:
    """Map the extended plane to the unit disc, r to r / (1 + r); infinity is on the circle."""
    finite = np.isfinite(plane)
    inside = np.where(finite, plane, 0)
    return np.where(finite, inside / (1 + np.abs(inside)), 1)
