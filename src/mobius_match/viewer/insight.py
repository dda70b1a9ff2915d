"""How the matches were found: the flattened samples under the best triplet, and the fuzzy correspondence matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from ..exporting.figures import numbered
from ..voting.assignment import max_row_column, normalized
from ..voting.kernel import mutual_pairs
from ..voting.mobius import CANONICAL_TRIANGLE, apply, from_three_points, homogeneous
from . import packing

if TYPE_CHECKING:
    from ..surface.surface import Surface
    from ..voting.votes import Votes

STEPS = 65535
"""Steps of a share of the votes."""
NEAR = 0.15
"""Distance per root of the area up to which a triplet agrees with a match."""


def insight(source: Surface, target: Surface, votes: Votes, pairs: np.ndarray) -> dict[str, Any] | None:
    """What the page shows of the voting, as JSON-able values.

    Parameters
    ----------
    source, target
        The prepared surfaces, of N1 and N2 samples.
    votes
        What was cast on them.
    pairs
        (Q, 2) matches in the user's numbers; the triplet that agrees with most of them is shown.

    Returns
    -------
    dict or None
        None where no triplet can be shown: too few votes, or samples that coincide in the plane. Else
        ``samples``: the user's numbers of both sides' samples. ``planes``: where they lie in the plane, moved so that
        the ``triplet`` comes to lie on an equilateral triangle, and 1 / (1 + r) times as far out, which shows the
        whole plane in a disc of radius 1. ``paired``: (N1,) target sample of each source sample that is mutually
        nearest there, -1 for none. ``matrix``: C by its largest value; ``rows`` and ``columns``: its samples in the
        order shown, in which what belongs together lies near the diagonal.
    """
    numbers = [surface.mesh.vertex_ids[surface.samples] for surface in (source, target)]
    positions = [surface.positions for surface in (source, target)]
    share = normalized(votes.matrix)
    if len(votes.best_source):
        explained = mutual_pairs(*map(homogeneous, positions), votes.best_source, votes.best_target)
        best = _agreeing(explained, target, numbers[0], pairs)
        triplets = [votes.best_source[best], votes.best_target[best]]
    else:  # uniform triplets are not kept: the three strongest entries of C
        triplets = [side.copy() for side in max_row_column(votes.matrix)[0][:3].T]
        if len(triplets[0]) < 3:
            return None
        one, other = (side[None] for side in triplets)
        explained, best = mutual_pairs(*map(homogeneous, positions), one, other), 0
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
        "paired": explained[best].tolist(),
        "triplets": votes.n_triplets,
        "rows": rows.tolist(),
        "columns": columns.tolist(),
        "matrix": packing.packed(np.round(STEPS * share), "<u2"),
    }


def _agreeing(explained: np.ndarray, target: Surface, numbers: np.ndarray, pairs: np.ndarray) -> int:
    """Which triplet pairs most samples (B, N1) with a target sample near the match that was found."""
    whole = target.whole_mesh
    places = whole.vertices[numbered(whole, pairs[:, 1])]
    nearest = cKDTree(target.mesh.vertices[target.samples]).query(places)[1]
    goal = np.full(explained.shape[1], -1)
    sample, match = np.nonzero(numbers[:, None] == pairs[:, 0])
    goal[sample] = nearest[match]
    agree = (explained >= 0) & (goal >= 0) & (target.normalized_distances[explained, goal] < NEAR)
    return int(agree.sum(axis=1).argmax())


def _in_disc(plane: np.ndarray) -> np.ndarray:
    """Points of the extended plane in the disc: directions stay, infinity is the rim."""
    finite = np.isfinite(plane)
    inside = np.where(finite, plane, 0)
    return np.where(finite, inside / (1 + np.abs(inside)), 1)
