"""Errors of matches and of dense maps against the known correspondence of a pair of shapes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .._core.display import one_line
from ..errors import FormatError
from ..geometry.geodesics import geodesic_solver, nearest_centres
from ..mesh import Mesh
from ..mesh.measure import areas, box_scale, unit_box
from . import metrics
from .datasets import Case, Truth

CHECKED = 100
"""Number of points of a dense map at which exact and heat distances are compared."""


@dataclass(frozen=True, eq=False)
class Scorer:
    """Errors on one pair of repaired meshes against its known correspondence, per diameter of the target.

    Parameters
    ----------
    case
        The pair; its known correspondence is in numbers of the user's files.
    source, target
        The meshes, as :func:`mobius_match.mesh.repair` gives them.
    method
        ``"exact"`` or ``"heat"`` geodesics on the target.
    diameter
        Of the target, in its units.

    Raises
    ------
    FormatError
        If the known correspondence refers to a vertex that a file does not have.
    """

    case: Case
    source: Mesh
    target: Mesh
    method: str
    diameter: float

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def truth(self) -> Truth:
        """The known correspondence in numbers of the repaired meshes, without points that repair has removed."""
        given = self.case.truth
        source, target = repaired_vertices(self.source, given.source), repaired_vertices(self.target, given.target)
        on_both = (source >= 0) & (target >= 0)
        mirrored = None if given.mirrored is None else repaired_vertices(self.target, given.mirrored)
        if mirrored is not None:
            on_both &= mirrored >= 0
            mirrored = mirrored[on_both]
        if not on_both.any():
            raise FormatError(f"{self.case.name}: no point of known correspondence lies on a face of both meshes")
        return Truth(source[on_both], target[on_both], mirrored, given.landmarks)

    def score(self, pairs: np.ndarray, confidence: np.ndarray) -> dict[str, Any]:
        """Errors of matches.

        A match is compared with the ground-truth point nearest to its source along edges; the nearest in space may be
        on the other side of an ear, or on a leg that a hand touches. If the ground truth is a few landmarks, each
        landmark is compared with the match whose source is geodesically (by heat) nearest to it. Then the error of a
        match is the mean over its landmarks, NaN if it has none. In both cases the distance between the ground-truth
        point and the match's source is part of the error.

        Parameters
        ----------
        pairs
            (Q, 2) vertex numbers of the user's files, in order of confidence.
        confidence
            (Q,) of the matches.

        Returns
        -------
        dict
            ``direct`` and ``mirrored`` (Q,) errors per diameter, ``heat_difference``, ``ranking``, ``coverage``.
        """
        truth = self.truth
        sources, targets = repaired_vertices(self.source, pairs[:, 0]), repaired_vertices(self.target, pairs[:, 1])
        if truth.landmarks:
            solver = geodesic_solver(unit_box(self.source.vertices), self.source.faces, "heat")
            points = np.arange(len(truth.source))
            matches = np.array([int(np.argmin(solver(int(vertex))[sources])) for vertex in truth.source])
        else:
            matches = np.arange(len(pairs))
            known, point = np.unique(truth.source, return_index=True)
            points = point[nearest_centres(self.source.vertices, self.source.faces, known)[sources]]
        errors = self._errors(targets[matches], points, truth, check=np.arange(len(matches)))
        if truth.landmarks:
            for name in ("direct", "mirrored"):
                if errors[name] is not None:
                    errors[name] = _group_means(errors[name], matches, len(pairs))
        return {
            **errors,
            "ranking": metrics.ranking(confidence, errors["direct"]),
            "coverage": {
                f"{side}_{name}": value
                for side, mesh, vertices in (("source", self.source, sources), ("target", self.target, targets))
                for name, value in metrics.coverage(mesh, vertices).items()
            },
        }

    def score_map(self, dense: np.ndarray) -> dict[str, Any]:
        """Errors of a dense map, one for each ground-truth point that is mapped.

        Parameters
        ----------
        dense
            (n1,) vertex of the target's file for each vertex of the source's file; -1 for none.

        Returns
        -------
        dict
            ``direct`` and ``mirrored`` (P,) errors per diameter, ``heat_difference``, and ``unmapped``, the number of
            ground-truth points without a counterpart.

        Raises
        ------
        FormatError
            If the map has another length, or refers to vertices that the target does not have.
        """
        name = self.case.name
        if len(dense) != self.source.n_file_vertices:
            raise FormatError(
                f"{name}: the map has {len(dense)} entries and {self.source.name} has {self.source.n_file_vertices} "
                "vertices; it must have one line for each vertex of the source"
            )
        truth = self.truth
        predicted = dense[self.source.vertex_ids[truth.source]]
        mapped = predicted >= 0
        predicted[mapped] = repaired_vertices(self.target, predicted[mapped])
        points = np.flatnonzero(predicted >= 0)
        if not len(points):
            raise FormatError(f"{name}: the map has a vertex on a face for no point of known correspondence")
        check = np.unique(np.linspace(0, len(points) - 1, CHECKED).astype(int))
        return self._errors(predicted[points], points, truth, check) | {"unmapped": len(predicted) - len(points)}

    def _errors(self, predicted: np.ndarray, points: np.ndarray, truth: Truth, check: np.ndarray) -> dict[str, Any]:
        """Distances between predicted vertices (Q,) and those of the ground-truth points (Q,), direct and mirrored."""
        lists = [truth.target[points]] + ([] if truth.mirrored is None else [truth.mirrored[points]])
        ends = np.concatenate(lists)
        errors = (
            metrics.geodesic_distances(self.target, np.tile(predicted, len(lists)), ends, self.method) / self.diameter
        )
        direct, *mirrored = np.split(errors, len(lists))
        difference = None
        if self.method == "exact":
            heat = metrics.geodesic_distances(self.target, predicted[check], lists[0][check], "heat") / self.diameter
            difference = float(np.abs(direct[check] - heat).mean())
        return {"direct": direct, "mirrored": mirrored[0] if mirrored else None, "heat_difference": difference}


def mesh_area(mesh: Mesh) -> float:
    """Area of a mesh, in its squared units."""
    return float(areas(mesh.vertices, mesh.faces).sum()) * box_scale(mesh.vertices) ** 2


@lru_cache(maxsize=64)
def cached_diameter(mesh: Mesh, method: str) -> float:
    """The diameter of a mesh, computed once for each mesh object."""
    return metrics.diameter(mesh, method)


def _group_means(values: np.ndarray, groups: np.ndarray, n_groups: int) -> np.ndarray:
    """Means (n_groups,) of the values in each group; NaN for empty groups."""
    counts = np.bincount(groups, minlength=n_groups)
    totals = np.bincount(groups, values, n_groups)
    return np.divide(totals, counts, out=np.full(n_groups, np.nan), where=counts > 0)


def repaired_vertices(mesh: Mesh, numbers: np.ndarray) -> np.ndarray:
    """Vertices of a repaired mesh by their numbers in the user's file; -1 for those that repair has removed."""
    outside = (numbers < 0) | (numbers >= mesh.n_file_vertices)
    if outside.any():
        raise FormatError(
            f"{mesh.name}: the list of corresponding points has vertex {numbers[outside][0]} (counting from 0), but "
            f"the file has {mesh.n_file_vertices} vertices; the list is of another mesh, or counts from another number"
        )
    vertex = np.full(mesh.n_file_vertices, -1, np.int64)
    vertex[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertex_ids))[::-1]  # the first of two with the same number
    return vertex[numbers]
