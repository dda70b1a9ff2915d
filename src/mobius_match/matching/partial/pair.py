"""A part and the whole that it is located on, with what is measured on both in the same units."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np

from ...geometry.curvature import Curvatures, rank_correlation
from ...geometry.directions import directions
from ...geometry.normals import vertex_normals
from ...landmarks.constraints import LandmarkConstraints
from ...registration.parameters import RegistrationParameters
from ...registration.sparse import Registration
from ...registration.strain import mean_stretch
from ...surface.surface import PartialSurface, Surface
from ...voting.parameters import VotingParameters
from .agreement import Paths, mean_differences
from .parameters import PartialParameters


class PartPair:
    """A part and the whole, and how well maps between them agree.

    All lengths are per sqrt(area) of the whole. In all that follows a landmark is a sample of the part together with
    the sample of the whole nearest to its image.

    Parameters
    ----------
    part, whole
        The surfaces.
    parameters, registration
        Constants of the method, and of registration.
    constraints
        Given pairs of points, if any.
    """

    def __init__(
        self,
        part: Surface,
        whole: Surface,
        parameters: PartialParameters,
        registration: RegistrationParameters,
        constraints: LandmarkConstraints | None = None,
        voting: VotingParameters = VotingParameters(),
    ) -> None:
        self.part, self.whole = PartialSurface.of(part, whole.area), whole
        self.parameters, self.registration, self.constraints = parameters, registration, constraints
        self.voting = voting
        self.paths1, self.paths2 = _paths(self.part), _paths(whole)
        self.samples1, self.samples2 = (np.searchsorted(surface.proxy, surface.samples) for surface in (part, whole))
        curvatures2 = self._smoothed(_curvatures(whole), whole)
        self._deviation = np.maximum(curvatures2[whole.proxy].std(axis=0), 1e-9)
        self.curvatures2 = curvatures2 / self._deviation
        self._of_part = _curvatures(self.part)
        self.curvatures1 = self._smoothed(self._of_part, self.part)[part.proxy] / self._deviation

    def scaled(self, size: float) -> PartPair:
        """The same with the part at a multiple of the size in its file."""
        pair = copy(self)
        pair.__dict__.pop("curvature_costs", None)
        pair.part = PartialSurface.of(self.part, self.whole.area / size**2)
        lengths = (pair.part.proxy_distances / pair.part.scale).astype(np.float32)
        pair.paths1 = self.paths1._replace(lengths=lengths)
        pair.curvatures1 = self._smoothed(self._of_part, pair.part)[pair.part.proxy] / self._deviation
        return pair

    def _smoothed(self, curvatures: Curvatures, surface: Surface) -> np.ndarray:
        """Curvatures (n, 4) of a surface at its size."""
        constants = surface.parameters
        radii = constants.curvature_radius, constants.wide_curvature_radius
        return curvatures.smoothed(radii, float(np.sqrt(surface.area) / surface.scale))

    def at_samples(self) -> PartPair:
        """The same with the samples of the part as all of its points, to compare many maps."""
        pair = copy(self)
        pair.paths1, pair.curvatures1 = self.paths1.to(self.samples1), self.curvatures1[self.samples1]
        pair.curvature_costs = self.curvature_costs[self.samples1]
        pair.samples1 = np.arange(len(self.samples1))
        return pair

    def curvature_cost(self, points1: np.ndarray, points2: np.ndarray) -> np.ndarray:
        """Cost (q1, q2) float32 of the difference in curvature between points of the proxies.

        With given pairs of points, also of the difference of the distances from these.
        """
        constants = self.parameters
        curvatures = self.curvatures1[points1], self.curvatures2[self.whole.proxy[points2]]
        costs = np.asarray(mean_differences(*curvatures, constants.curvature_weight, constants.error_cap))
        if self.constraints is not None:
            vertices = self.part.proxy[points1], self.whole.proxy[points2]
            disagreement = self.constraints.disagreement(self.part, self.whole, *vertices)
            costs += np.minimum(disagreement, constants.error_cap).astype(np.float32)
        return costs

    @cached_property
    def curvature_costs(self) -> np.ndarray:
        """:meth:`curvature_cost` between all points of the proxies, (P1, P2)."""
        return self.curvature_cost(*(np.arange(len(surface.proxy)) for surface in (self.part, self.whole)))

    def compared(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compare distances from landmarks under a map of the part's proxy to the whole's, (P1,).

        Returns
        -------
        landmarks2
            (N1,) samples of the whole.
        errors
            (N1, P1) absolute differences of the distances from landmarks to points and to their images.
        snapped
            (N1,) distances of the samples of the whole from the images of those of the part.
        """
        lengths = self.paths2.lengths[:, image]
        landmarks2 = lengths[:, self.samples1].argmin(axis=0)
        errors = np.abs(self.paths1.lengths - lengths[landmarks2])
        return landmarks2, errors, lengths[landmarks2, self.samples1]

    def weighted_errors(self, image: np.ndarray, axis: int) -> np.ndarray:
        """Mean capped errors of distances, near ones first: (P1,) over landmarks (axis 0), (N1,) over points (1)."""
        weight = 1 / (self.paths1.lengths + self.parameters.landmark_distance)
        errors = np.minimum(self.compared(image)[1], self.parameters.error_cap)
        return np.asarray((weight * errors).sum(axis=axis) / weight.sum(axis=axis))

    def angle_agreement(self, image: np.ndarray) -> np.ndarray:
        """How well the angles between paths from landmarks agree at points and at their images, (P1,) in [0, 1]."""
        landmarks2 = self.compared(image)[0]
        here = self.paths1.x + 1j * self.paths1.y
        here_to_there = np.ix_(landmarks2, image)
        there = self.paths2.x[here_to_there] + 1j * self.paths2.y[here_to_there]
        most = np.maximum((np.abs(here) * np.abs(there)).sum(axis=0), 1e-9)
        return np.asarray(np.abs((here * there.conj()).sum(axis=0)) / most)

    def map_cost(self, image: np.ndarray) -> float:
        """Mean error of a map of the part's proxy to the whole's (P1,): distances, angles, curvatures."""
        angles = 1 - self.angle_agreement(image).mean()
        of_curvature = self.curvature_costs[np.arange(len(image)), image].mean()
        return float(self.compared(image)[1].mean() + self.parameters.direction_weight * angles + of_curvature)

    def cost_terms(self, registration: Registration) -> dict[str, float]:
        """What the cost of a registration is the sum of; 0 is perfect in each term."""
        image, constants = self.whole.nearest_proxy[registration.image], self.parameters
        angles = float(1 - self.angle_agreement(image).mean()) + float(registration.normal_deviation.mean())
        # A cut changes the curvatures that are smoothed more widely far into the part.
        gauss_and_mean = zip(self.curvatures1.T[:2], self.curvatures2[registration.image].T[:2], strict=True)
        return {
            "distances": float(self.compared(image)[1].mean()),
            "curvature": sum(1 - rank_correlation(*both) for both in gauss_and_mean),
            "angles": constants.angle_cost * angles,
            "stretch": constants.stretch_cost * mean_stretch(self.part, self.whole, registration),
            "residual": constants.residual_cost * float(registration.residual.mean()),
        }

    def cost(self, registration: Registration) -> float:
        """The sum of :meth:`cost_terms`."""
        return sum(self.cost_terms(registration).values())


def _paths(surface: Surface) -> Paths:
    """From the samples to the points of the proxy."""
    points, faces = surface.mesh.vertices, surface.mesh.faces
    normals = vertex_normals(points, faces)[surface.proxy]
    xy = directions(points[surface.proxy], normals, surface.proxy_edges, surface.proxy_distances)
    return Paths((surface.proxy_distances / surface.scale).astype(np.float32), *xy)


def _curvatures(surface: Surface) -> Curvatures:
    """Of the surface scaled to area 1."""
    vertices = surface.mesh.vertices - surface.mesh.vertices.mean(axis=0)
    return Curvatures(vertices / np.sqrt(surface.area), surface.mesh.faces)
