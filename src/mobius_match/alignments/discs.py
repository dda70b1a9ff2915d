"""The paper's footnote: the maps between two discs are a group of three dimensions, and all of it is searched.

A conformal map of the unit disc to itself is determined by the image of one point and an angle. So every central sample
of the source is sent to every central sample of the target, at every angle, and boundary goes to boundary. Mutually
nearest samples in the disc are paired as in Algorithm 2. Each map is judged by its pairs: do geodesic distances between
them agree, and does one rigid motion with a scale carry them over? Bent surfaces keep the former, rigid ones of other
proportions the latter, and the better a map fulfils one of them, the more it tells.
"""

from __future__ import annotations

import math

import numpy as np

from .._core.compiling import jit
from ..geometry.rotations import largest_trace
from ..surface.surface import Surface
from ..voting.nearest import Minima, Pairs, empty_minima, empty_pairs, mutually_nearest, padded
from .clusters import agreed_matches, cluster_triplets
from .parameters import ClusterParameters, DiscParameters


def disc_matches(
    source: Surface, target: Surface, parameters: DiscParameters, clusters: ClusterParameters
) -> list[np.ndarray]:
    """Matches of samples (q, 2) under the best maps of one disc to the other that differ, the best map's first.

    None if one of the surfaces is closed, or nearly: its boundary is too short to shape it.
    """
    if min(source.rim_length, target.rim_length) < parameters.least_rim:
        return []
    pairs, weights = disc_maps(source, target, parameters)
    distances = target.normalized_distances
    groups = cluster_triplets(pairs, distances, weights, clusters.radius, 0.0, parameters.tried)
    return [agreed_matches(pairs[group], weights[group], len(distances), clusters.most_matches) for group in groups]


def disc_maps(source: Surface, target: Surface, parameters: DiscParameters) -> tuple[np.ndarray, np.ndarray]:
    """The best maps of one disc to the other, without mirror images.

    Returns
    -------
    pairs
        (B, N1) int32: the target sample that each map pairs each source sample with, -1 for none; best map first.
    weights
        (B,) float64, not increasing.
    """
    sides = [_Side(surface, parameters) for surface in (source, target)]
    one, two = sides
    angles = 2 * np.pi * np.arange(parameters.angles) / parameters.angles
    pairs = np.full((len(one.centres) * len(two.centres) * len(angles), len(source.samples)), -1, np.int32)
    weights = np.empty(len(pairs))
    n1, n2 = len(one.places), len(two.places)
    _evaluate(
        one.places,
        two.places,
        one.centres,
        two.centres,
        np.exp(1j * angles),
        one.distances,
        two.distances,
        one.points,
        two.points,
        parameters.floor,
        np.zeros((3, padded(n1)), np.float32),
        np.zeros((3, padded(n2)), np.float32),
        empty_minima(n1, n2),
        empty_pairs(1, n2),
        pairs,
        weights,
    )
    best = np.argsort(-weights, kind="stable")[: parameters.kept]
    return pairs[best], weights[best]


class _Side:
    """What is compared on one surface, its first samples: in the disc, along the surface and in space."""

    def __init__(self, surface: Surface, parameters: DiscParameters) -> None:
        samples = surface.samples[: parameters.samples]
        self.places = surface.disc[np.searchsorted(surface.proxy, samples)]
        self.distances = surface.normalized_distances[: len(samples), : len(samples)]
        self.points = surface.mesh.vertices[samples] / surface.scale
        self.centres = np.argsort(surface.average_distances[: len(samples)], kind="stable")[: parameters.centres]


@jit
def _evaluate(
    places1: np.ndarray,
    places2: np.ndarray,
    centres1: np.ndarray,
    centres2: np.ndarray,
    turns: np.ndarray,
    distances1: np.ndarray,
    distances2: np.ndarray,
    points1: np.ndarray,
    points2: np.ndarray,
    floor: float,
    image1: np.ndarray,
    image2: np.ndarray,
    minima: Minima,
    pairs: Pairs,
    partners: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Write the partners of the source's samples under each map, and the weight of the map."""
    n1, n2 = len(places1), len(places2)
    number = 0
    for first in centres1:
        for second in centres2:
            to_centre(places2, places2[second], complex(1.0, 0.0), image2)
            for turn in turns:
                to_centre(places1, places1[first], turn, image1)
                mutually_nearest(image1, n1, image2, n2, False, 0, minima, pairs, 0)
                count = pairs.counts[0]
                rows, columns = pairs.rows[0], pairs.columns[0]
                for i in range(count):
                    partners[number, rows[i]] = columns[i]
                apart = distance_error(count, rows, columns, distances1, distances2)
                moved = rigid_error(count, rows, columns, points1, points2)
                weights[number] = count / ((apart + floor) * (moved + floor))
                number += 1


@jit
def to_centre(places: np.ndarray, centre: complex, turn: complex, image: np.ndarray) -> None:
    """The disc turned so that a point comes to its centre: turn (z - centre) / (1 - conj(centre) z)."""
    for k in range(image.shape[1]):
        z = places[min(k, len(places) - 1)]
        z = turn * (z - centre) / (1 - np.conj(centre) * z)
        image[0, k], image[1, k] = z.real, z.imag


@jit
def distance_error(
    count: int, rows: np.ndarray, columns: np.ndarray, distances1: np.ndarray, distances2: np.ndarray
) -> float:
    """Mean absolute difference of the distances between all pairs."""
    total = 0.0
    for i in range(count):
        for j in range(i):
            total += abs(distances1[rows[i], rows[j]] - distances2[columns[i], columns[j]])
    return total / max(count * (count - 1) / 2, 1.0)


@jit
def rigid_error(count: int, rows: np.ndarray, columns: np.ndarray, points1: np.ndarray, points2: np.ndarray) -> float:
    """Root mean square of what is left between all pairs after the best rotation, translation and scale (Horn 1987)."""
    mean1, mean2, covariance = np.zeros(3), np.zeros(3), np.zeros((3, 3))
    for i in range(count):
        for axis in range(3):
            mean1[axis] += points1[rows[i], axis] / count
            mean2[axis] += points2[columns[i], axis] / count
    square1, square2 = 0.0, 0.0
    for i in range(count):
        for axis in range(3):
            x = points1[rows[i], axis] - mean1[axis]
            square1 += x * x
            square2 += (points2[columns[i], axis] - mean2[axis]) ** 2
            for other in range(3):
                covariance[axis, other] += x * (points2[columns[i], other] - mean2[other])
    if not square1 > 0.0:
        return math.sqrt(square2 / max(count, 1))
    return math.sqrt(max(square2 - largest_trace(covariance) ** 2 / square1, 0.0) / count)
