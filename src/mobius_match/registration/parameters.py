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

    radius: float = parameter(
        0.12,
        "surroundings of a place: a sample's weight falls to 1/e at this distance, normals count up to it, residual "
        "and strain are averaged by a Gaussian of half the width",
        unit=AREA,
        origin=HAND,
    )
    floor: float = parameter(0.01, "added to each feature before its logarithm", origin=HAND)
    slopes: ConfidenceTerms[float] = parameter(
        ConfidenceTerms(-0.60, -2.54, -1.19, 1.14),
        "slope of the logarithm of each feature",
        origin="chosen for the ranking of the first matches, from a plateau over 170 matches of TOSCA, FAUST and "
        "gorillas with people; benchmarks/fit_confidence.py prints -0.74, -1.73, -1.43, 0.08 and the offset -8.67: "
        "better probabilities (log loss 0.196 instead of 0.214), and worse first 45 matches",
    )
    offset: float = parameter(-8.5, "intercept of the logistic model", origin="as the slopes")


@dataclass(frozen=True)
class RegistrationParameters:
    """Non-rigid registration, of the proxy (sparse) and of all vertices (dense)."""

    first_weight: float = parameter(0.1, "first data weight against rigidity", origin=HAND)
    weight_ratio: float = parameter(10**0.5, "ratio of a data weight to the one before", origin=HAND)
    n_weights: int = parameter(3, "data weights of a full registration", origin=HAND)
    rounds: int = parameter(3, "searches for closest points at each weight", origin=HAND)
    steps: int = parameter(2, "alternations of the local and the global step after each search", origin=HAND)
    normal: float = parameter(0.15, "weight of normals against positions per sqrt(area)", origin=HAND)
    spectral: float = parameter(0.02, "weight of eigenfunctions", origin=HAND)
    descriptor: tuple[float, float] = parameter(
        (0.07, 0.03), "weight of descriptors where the shapes are similar, and where they differ", origin=HAND
    )
    curvature: tuple[float, float] = parameter(
        (0.05, 0.1), "weight of curvatures where the shapes are similar, and where they differ", origin=HAND
    )
    dense_normal: float = parameter(
        0.04, "weight of normals in dense registration, which is closer to begin with", origin=HAND
    )
    dense_spectral: float = parameter(0.003, "weight of eigenfunctions in dense registration", origin=HAND)
    dense_curvature: float = parameter(0.015, "weight of curvatures in dense registration", origin=HAND)
    discontinuity: float = parameter(
        0.07, "the map is discontinuous where an edge's image is longer than the edge by this", unit=AREA, origin=HAND
    )
    part_distance: float = parameter(
        0.03, "a point of the whole within this distance of the deformed part belongs to it", unit=AREA, origin=HAND
    )
    confidence: ConfidenceParameters = ConfidenceParameters()

    def schedule(self, n_weights: int, rounds: int) -> Schedule:
        """Data weights from the first on, each a multiple of the one before."""
        weights = tuple(self.first_weight * self.weight_ratio**k for k in range(n_weights))
        return Schedule(weights, rounds, self.steps)

    @property
    def full(self) -> Schedule:
        """Of a full registration, sparse or dense."""
        return self.schedule(self.n_weights, self.rounds)

    @property
    def part(self) -> Schedule:
        """Of a part on its whole, which is judged by its strain as well."""
        return self.schedule(self.n_weights + 1, self.rounds)

    @property
    def initial_weight(self) -> float:
        """Data weight while the source moves to its initial targets: the one before the first."""
        return self.first_weight / self.weight_ratio

    @property
    def initial_steps(self) -> int:
        """Steps for that: twice as many as at each other weight, since the way is longer."""
        return 2 * self.rounds * self.steps

    def features(self, shapes_differ: bool) -> FeatureWeights:
        """Weights of features where the shapes are similar, or where they differ and descriptors tell less."""
        kind = int(shapes_differ)
        return FeatureWeights(self.normal, self.spectral, self.descriptor[kind], self.curvature[kind])

    @property
    def partial(self) -> FeatureWeights:
        """For a part, which shares neither eigenfunctions nor descriptors with its whole."""
        return FeatureWeights(self.normal)
