"""The constants of candidate alignments and of the choice between them; docs/method.md has the formulas."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Generic, TypeVar

import numpy as np

from .._core.parameters import AREA, HAND, parameter
from ..landmarks.parameters import LandmarkParameters
from ..registration.parameters import RegistrationParameters
from ..voting.parameters import VotingParameters

Value = TypeVar("Value")


@dataclass(frozen=True)
class TransportParameters:
    """Unbalanced optimal transport between points in a space of features."""

    sharpness: float = parameter(
        0.45, "temperature, per median squared distance to the neighbor of that number", origin=HAND
    )
    neighbor: int = parameter(10, "number of the neighbor that scales the temperature", origin=HAND)
    iterations: int = parameter(10, "Sinkhorn iterations", origin=HAND)
    balance: float = parameter(
        0.8, "exponent of the target's marginal: 1 leaves no point over, 0 gives the nearest point alone", origin=HAND
    )


@dataclass(frozen=True)
class CoarseMapParameters:
    """A map of the whole proxy from a few matches."""

    match_radius: float = parameter(
        0.3, "the influence of a match falls to 1/e at this distance in the first map", unit=AREA, origin=HAND
    )
    upsampling_step: int = parameter(
        10, "each refinement has so many eigenfunctions more, from twice as many up to all", origin=HAND
    )
    thinning: int = parameter(2, "all maps but the last use every so many-th point of the proxies", origin="time")
    descriptor_weight: float = parameter(
        0.4, "weight of descriptors against eigenfunctions, by root mean square", origin=HAND
    )
    transport: TransportParameters = TransportParameters()

    @property
    def quick_thinning(self) -> int:
        """The same where many candidates are compared: thinned twice."""
        return self.thinning**2


@dataclass(frozen=True)
class ClusterParameters:
    """Clusters of the best triplets, by where they send the samples."""

    radius: float = parameter(0.2, "largest mean distance of the samples' images in a cluster", unit=AREA, origin=HAND)
    least_weight: float = parameter(
        0.6, "clusters whose best triplet weighs less than this share of the best of all are dropped", origin=HAND
    )
    most: int = parameter(8, "clusters at most", origin=HAND)
    most_matches: int = parameter(60, "matches that a cluster agrees on, at most", origin=HAND)


@dataclass(frozen=True)
class ExtremityParameters:
    """Extremities of two surfaces, matched in every likely way."""

    radius: float = parameter(
        0.25, "an extremity is farther from the rest than all samples within this distance", unit=AREA, origin=HAND
    )
    most: int = parameter(6, "extremities of a surface at most", origin=HAND)
    likely: int = parameter(120, "ways to match them that are looked at", origin=HAND)
    tried: int = parameter(5, "ways to match them that become candidates", origin=HAND)
    omission_cost: float = parameter(0.05, "cost of leaving an extremity out", origin=HAND)


@dataclass(frozen=True)
class PoseParameters:
    """Rigid motions of one shape onto the other."""

    normal: float = parameter(0.15, "weight of normals against positions per sqrt(area)", origin="as in registration")
    thinning: int = parameter(4, "every so many-th point of the proxy is moved", origin="time")
    steps: int = parameter(8, "searches for closest points from each rotation", origin=HAND)
    distinct: float = parameter(0.5, "angle from which two rotations are different ones", unit="radians", origin=HAND)
    tried: int = parameter(4, "motions that become candidates", origin=HAND)


@dataclass(frozen=True)
class DiscParameters:
    """The search through all maps between two discs, the paper's footnote."""

    least_rim: float = parameter(
        0.5,
        "length of the longest boundary loop from which a surface is searched as a disc as well; a round hole of that "
        "length is 2 % of the area",
        unit=AREA,
        origin=HAND,
    )
    samples: int = parameter(100, "samples that are paired, at most", origin="time: their square enters each map")
    centres: int = parameter(30, "most central samples that are sent to each other", origin=HAND)
    angles: int = parameter(24, "angles of each two of them: steps of 15 degrees", origin=HAND)
    floor: float = parameter(
        0.01,
        "added to both errors of a map: far less than the distance between samples tells nothing",
        unit=AREA,
        origin="a tenth of the distance between 100 samples",
    )
    kept: int = parameter(2000, "maps that are clustered, the best ones", origin=HAND)
    tried: int = parameter(6, "clusters that become candidates", origin=HAND)


@dataclass(frozen=True)
class CostWeights:
    """Weights of the terms of an alignment's cost.

    Parameters
    ----------
    distances
        Mean absolute difference of the logarithms of geodesic distances.
    laplacian
        Relative Frobenius norm of the functional map's commutator with the Laplacian.
    mean_curvature, gauss_curvature
        1 - rank correlation of the curvatures.
    landmarks
        Mean displacement of landmarks beyond the tolerance, per sqrt(area).
    """

    distances: float = 5.0
    laplacian: float = 3.0
    mean_curvature: float = 1.0
    gauss_curvature: float = 3.0
    landmarks: float = 20.0


@dataclass(frozen=True)
class CostParameters:
    """The cost of an alignment."""

    weights: CostWeights = parameter(CostWeights(), "weight of each term", origin=HAND)
    eigenfunctions: int = parameter(20, "eigenfunctions of the Laplacian term", origin=HAND)
    softening: float = parameter(0.1, "added to distances before their logarithm", unit=AREA, origin=HAND)


@dataclass(frozen=True)
class Evidence(Generic[Value]):
    """One value for each term.

    Parameters
    ----------
    mean_curvature, gauss_curvature
        1 - rank correlation of the curvatures of points and of their images, as means over both directions.
    stretch
        Mean hyperbolic tangent of the absolute logarithms of the stretches of edges.
    turning
        Mean of 1 - cosine of the angle between the normals of the deformed source and of the target.
    bending
        Mean angle between the rotations of neighbours, as a share of pi.
    rigidity
        Square root of the share of the variance of the deformed source that no rotation with one scale explains.
    residual, gap
        Mean distances of the deformed source from the target, and of the target from the deformed source, per
        sqrt(area).
    """

    mean_curvature: Value
    gauss_curvature: Value
    stretch: Value
    turning: Value
    bending: Value
    rigidity: Value
    residual: Value
    gap: Value

    def values(self) -> np.ndarray:
        """The values in the order of the fields."""
        return np.array([getattr(self, one.name) for one in fields(self)], np.float64)


@dataclass(frozen=True)
class ChoiceParameters:
    """A model of the probability of each alignment: a conditional logistic one, in which none may be right."""

    weights: Evidence[float] = parameter(
        Evidence(-4.58, -8.86, -21.0, -8.21, -19.1, -5.04, -140.0, -78.5),
        "weight of each term of the evidence",
        origin="fitted by `benchmarks/fit_choice.py`",
    )
    offset: float = parameter(17.0, "score of an alignment that nothing speaks against", origin="as the weights")


@dataclass(frozen=True)
class SelectionParameters:
    """What is done, and how much of it, until an alignment is chosen; costs have no unit."""

    different_above: float = parameter(
        1.5,
        "cost of the best candidate above which the two shapes differ in more than their pose: extremities are matched "
        "as well, maps are begun in other ways, and registration is repeated",
        origin=HAND,
    )
    sure_above: float = parameter(
        0.95, "probability of the best alignment from which no further candidates are looked for", origin=HAND
    )
    contest_margin: float = parameter(
        2.0, "margin in cost up to which candidates are registered and compared", origin=HAND
    )
    most_contenders: int = parameter(4, "candidates compared at most", origin="time")
    doubted_below: float = parameter(
        0.7,
        "probability of the chosen alignment below which users are warned",
        origin="by the table of `benchmarks/fit_choice.py`, kinds left out: no wrong one of 253 pairs is above",
    )
    close_cost: float = parameter(
        0.3, "difference in cost below which two readings of handles fit equally well", origin=HAND
    )
    repeats: int = parameter(4, "repeated registrations of the chosen alignment where shapes differ", origin=HAND)


@dataclass(frozen=True)
class AlignmentParameters:
    """The constants of all that leads from two prepared surfaces to an alignment."""

    voting: VotingParameters = VotingParameters()
    landmarks: LandmarkParameters = LandmarkParameters()
    registration: RegistrationParameters = RegistrationParameters()
    coarse_map: CoarseMapParameters = CoarseMapParameters()
    clusters: ClusterParameters = ClusterParameters()
    extremities: ExtremityParameters = ExtremityParameters()
    poses: PoseParameters = PoseParameters()
    discs: DiscParameters = DiscParameters()
    cost: CostParameters = CostParameters()
    selection: SelectionParameters = SelectionParameters()
    choice: ChoiceParameters = ChoiceParameters()
