"""Errors of matches, and of dense maps, against the truth of a pair of shapes."""

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
"""Points of a dense map at which exact and heat distances are compared."""


@dataclass(frozen=True, eq=False)
class Scorer:
    """Errors on one pair of repaired meshes against its truth, per diameter of the target.

    Parameters
    ----------
    case
        The pair; its truth is in numbers of the user's files.
    source, target
        The meshes, as :func:`mobius_match.mesh.repair` gives them.
    method
        ``"exact"`` or ``"heat"`` geodesics on the target.
    diameter
        Of the target, in its units.

    Raises
    ------
    FormatError
        If the truth names a vertex that a file does not have.
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
        """The truth in numbers of the repaired meshes, without points that the repair left out."""
        given = self.case.truth
        source, target = places_of(self.source, given.source), places_of(self.target, given.target)
        there = (source >= 0) & (target >= 0)
        mirrored = None if given.mirrored is None else places_of(self.target, given.mirrored)
        if mirrored is not None:
            there &= mirrored >= 0
            mirrored = mirrored[there]
        if not there.any():
            raise FormatError(f"{self.case.name}: no point of known correspondence lies on a face of both meshes")
        return Truth(source[there], target[there], mirrored, given.landmarks)

    def score(self, pairs: np.ndarray, confidence: np.ndarray) -> dict[str, Any]:
        """Errors of matches (Q, 2), in vertex numbers of the user's files, in order of confidence (Q,).

        A match is compared with the point of the truth that is nearest to the match's source along edges: in space
        that may lie on the other side of an ear, or on a leg that a hand touches. Where the truth is a few landmarks,
        each landmark is compared with the match whose source is geodesically (by heat) nearest to it, and the match
        has the mean error of its landmarks, NaN if it has none. Both count how far the known points and the matches'
        sources lie apart as error; nothing is subtracted.
        """
        truth = self.truth
        first, second = places_of(self.source, pairs[:, 0]), places_of(self.target, pairs[:, 1])
        if truth.landmarks:
            solver = geodesic_solver(unit_box(self.source.vertices), self.source.faces, "heat")
            points = np.arange(len(truth.source))
            matches = np.array([int(np.argmin(solver(int(vertex))[first])) for vertex in truth.source])
        else:
            matches = np.arange(len(pairs))
            known, point = np.unique(truth.source, return_index=True)
            points = point[nearest_centres(self.source.vertices, self.source.faces, known)[first]]
        found = self._errors(second[matches], points, truth, check=np.arange(len(matches)))
        if truth.landmarks:
            for name in ("direct", "mirrored"):
                if found[name] is not None:
                    found[name] = _mean_of_each(found[name], matches, len(pairs))
        return {
            **found,
            "ranking": metrics.ranking(confidence, found["direct"]),
            "coverage": {
                f"{side}_{name}": value
                for side, mesh, vertices in (("source", self.source, first), ("target", self.target, second))
                for name, value in metrics.coverage(mesh, vertices).items()
            },
        }

    def score_map(self, dense: np.ndarray) -> dict[str, Any]:
        """Errors of a dense map, one for each point of the truth that is mapped.

        Parameters
        ----------
        dense
            For each vertex of the source file the vertex of the target file, -1 for none.

        Returns
        -------
        dict
            ``direct`` and ``mirrored`` (P,), ``heat_difference``, and ``unmapped``, the number of points left out.

        Raises
        ------
        FormatError
            The map is of another length, or names vertices that the target does not have.
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
        predicted[mapped] = places_of(self.target, predicted[mapped])
        points = np.flatnonzero(predicted >= 0)
        if not len(points):
            raise FormatError(f"{name}: the map gives no point of known correspondence a vertex on a face")
        check = np.unique(np.linspace(0, len(points) - 1, CHECKED).astype(int))
        return self._errors(predicted[points], points, truth, check) | {"unmapped": len(predicted) - len(points)}

    def _errors(self, found: np.ndarray, points: np.ndarray, truth: Truth, check: np.ndarray) -> dict[str, Any]:
        """Distances from the found vertices (Q,) to the truth at some points (Q,), against each list there is."""
        lists = [truth.target[points]] + ([] if truth.mirrored is None else [truth.mirrored[points]])
        ends = np.concatenate(lists)
        errors = metrics.geodesic_distances(self.target, np.tile(found, len(lists)), ends, self.method) / self.diameter
        direct, *mirrored = np.split(errors, len(lists))
        difference = None
        if self.method == "exact":
            heat = metrics.geodesic_distances(self.target, found[check], lists[0][check], "heat") / self.diameter
            difference = float(np.abs(direct[check] - heat).mean())
        return {"direct": direct, "mirrored": mirrored[0] if mirrored else None, "heat_difference": difference}


def mesh_area(mesh: Mesh) -> float:
    """Area of a mesh in its squared units."""
    return float(areas(mesh.vertices, mesh.faces).sum()) * box_scale(mesh.vertices) ** 2


@lru_cache(maxsize=64)
def cached_diameter(mesh: Mesh, method: str) -> float:
    """The diameter, once for each mesh object."""
    return metrics.diameter(mesh, method)


def _mean_of_each(values: np.ndarray, places: np.ndarray, length: int) -> np.ndarray:
    number = np.bincount(places, minlength=length)
    total = np.bincount(places, values, length)
    return np.divide(total, number, out=np.full(length, np.nan), where=number > 0)


def places_of(mesh: Mesh, numbers: np.ndarray) -> np.ndarray:
    """Vertices of a repaired mesh by their numbers in the user's file; -1 where the repair left one out."""
    outside = (numbers < 0) | (numbers >= mesh.n_file_vertices)
    if outside.any():
        raise FormatError(
            f"{mesh.name}: vertex {numbers[outside][0]} (counting from 0) is named as a corresponding point, but the "
            f"file has {mesh.n_file_vertices} vertices; the list belongs to another mesh or counts otherwise"
        )
    place = np.full(mesh.n_file_vertices, -1, np.int64)
    place[mesh.vertex_ids[::-1]] = np.arange(len(mesh.vertex_ids))[::-1]  # the first of two with one number
    return place[numbers]
