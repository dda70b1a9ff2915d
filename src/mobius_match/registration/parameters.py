"""The constants of registration and of the confidence in it; docs/method.md has the formulas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from .._core.parameters import AREA, HAND, parameter

Value = TypeVar("Value")


@dataclass(frozen=True)
class Schedule:
    """How the weight of the data rises, and how much work is done at each weight.

    Parameters
    ----------
    data_weights
        Weights w of the data term against rigidity, one after the other.
    rounds
        Searches for the closest points at each weight.
    steps
        Alternations of the local and the global step after each search.
    """

    data_weights: tuple[float, ...]
    rounds: int
    steps: int


@dataclass(frozen=True)
class FeatureWeights:
    """Weights of what points are compared by, against positions per sqrt(area).

    Parameters
    ----------
    normal
        Of unit normals.
    spectral
        Of eigenfunctions, those of the source brought to the target by a functional map.
    descriptor
        Of wave kernel signatures.
    curvature
        Of curvatures.
    """

    normal: float = 0.0
    spectral: float = 0.0
    descriptor: float = 0.0
    curvature: float = 0.0


@dataclass(frozen=True)
class ConfidenceTerms(Generic[Value]):
    """One value for each feature that the confidence in a match is a function of.

    Parameters
    ----------
    distances
        Disagreement of geodesic distances per sqrt(area).
    residual
        Distance of the deformed source from its image per sqrt(area).
    strain
        Mean absolute logarithm of the stretches of edges.
    stability
        Least eigenvalue of the mean of n n^T over the normals n around the place.
    """

    distances: Value
    residual: Value
    strain: Value
    stability: Value


@dataclass(frozen=True)
class ConfidenceParameters:
    """A logistic model of the probability that a match is right."""

    sample_radius: float = parameter(
        0.15, "a sample's weight falls to 1/e at this distance from the place that is judged", unit=AREA, origin=HAND
    )
    smoothing_radius: float = parameter(
        0.06, "width of the Gaussian that residual and edge strain are averaged with", unit=AREA, origin=HAND
    )
    stability_radius: float = parameter(
        0.12, "radius of the patch whose normals tell how stable a place is", unit=AREA, origin=HAND
    )
    floors: ConfidenceTerms[float] = parameter(
        ConfidenceTerms(0.01, 0.01, 0.02, 0.02), "added to each feature before its logarithm", origin=HAND
    )
    slopes: ConfidenceTerms[float] = parameter(
        ConfidenceTerms(-0.60, -2.54, -1.19, 1.14),
        "slope of the logarithm of each feature",
        origin="chosen from a plateau over 170 matches of TOSCA, FAUST and gorillas with people, both ways",
    )
    offset: float = parameter(-8.5, "intercept of the logistic model", origin="as the slopes")


@dataclass(frozen=True)
class RegistrationParameters:
    """Non-rigid registration, of the proxy (sparse) and of all vertices (dense)."""

    initial_weight: float = parameter(0.02, "data weight while the source moves to its initial targets", origin=HAND)
    initial_steps: int = parameter(12, "local and global steps for that", origin=HAND)
    full: Schedule = parameter(Schedule((0.1, 0.3, 1.0), 3, 2), "schedule of a full registration", origin=HAND)
    coarse: Schedule = parameter(
        Schedule((0.1, 0.3, 1.0, 3.0), 1, 2),
        "schedule where several candidates are compared: one search a weight, and a last weight that turns what does "
        "not fit into strain",
        origin=HAND,
    )
    part: Schedule = parameter(
        Schedule((0.1, 0.3, 1.0, 3.0), 3, 2), "schedule of a part on its whole", origin="full and coarse"
    )
    dense: Schedule = parameter(Schedule((0.1, 0.3, 0.6, 1.2), 4, 4), "schedule of all vertices", origin=HAND)
    similar: FeatureWeights = parameter(
        FeatureWeights(0.15, 0.02, 0.07, 0.05), "weights of features where the shapes are similar", origin=HAND
    )
    different: FeatureWeights = parameter(
        FeatureWeights(0.15, 0.02, 0.03, 0.1), "where they differ, and descriptors tell less", origin=HAND
    )
    compared: FeatureWeights = parameter(
        FeatureWeights(0.15, 0.02, 0.07, 0.0),
        "where candidates are compared: curvatures would pull a wrong one into shape",
        origin=HAND,
    )
    partial: FeatureWeights = parameter(
        FeatureWeights(0.15), "for a part, which shares no eigenfunctions with its whole", origin=HAND
    )
    of_vertices: FeatureWeights = parameter(
        FeatureWeights(0.04, 0.003, 0.0, 0.015), "for the registration of all vertices", origin=HAND
    )
    discontinuity: float = parameter(
        0.07, "the map is discontinuous where an edge's image is longer than the edge by this", unit=AREA, origin=HAND
    )
    release_weight: float = parameter(
        0.1, "data weight up to which discontinuous pieces are ignored", origin="the first weight of the schedules"
    )
    most_candidates: int = parameter(10_000, "target vertices among which closest points are searched", origin=HAND)
    strain_weights: tuple[float, float] = parameter(
        (16.0, 2.0), "weights of the logarithms of edge strain and of normal deviation", origin=HAND
    )
    strain_floors: tuple[float, float] = parameter(
        (0.01, 0.001), "added to the two before the logarithm", origin="a hundredth of what good matches have"
    )
    part_distance: float = parameter(
        0.03, "a point of the whole within this distance of the deformed part belongs to it", unit=AREA, origin=HAND
    )
    carriers: int = parameter(6, "vertices of the proxy that carry a vertex of the mesh", origin=HAND)
    confidence: ConfidenceParameters = ConfidenceParameters()
