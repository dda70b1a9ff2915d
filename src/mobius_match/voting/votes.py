"""Sections 6 and 7: many triplets on several threads, their votes summed into the fuzzy correspondence matrix C.

The triplets are cut into batches whose number depends on nothing but how many triplets there are; each batch has a
random stream and a matrix of its own, and the matrices are summed in the order of the batches. So the result does not
depend on the number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from .._core.display import one_line
from .._core.threads import Progress
from ..settings import MatchSettings
from ..surface.surface import Surface
from .kernel import vote, vote_weighted
from .mobius import homogeneous
from .parameters import VotingParameters
from .proposals import guided_triplets, uniform_triplets

BATCH = 625
"""Guided triplets in a batch."""

LEAST_BATCHES, LARGEST_BATCH = 32, 50_000
"""Uniform triplets come in at least so many batches, of at most so many."""

ROUND = 8
"""Batches between two checks of whether the votes have settled, where the number of votes is not given."""

TRIALS = 200
"""Draws by which it is estimated whether most succeed."""

DEFAULT_MIN_FRACTION = 0.4
"""Section 6: the paper's K is 40 % of the samples."""


@dataclass(frozen=True, eq=False)
class Votes:
    """The fuzzy correspondence matrix, and the best triplets that voted.

    Parameters
    ----------
    matrix
        (N1, N2) float64, the matrix C, not normalised.
    n_triplets
        Number of triplets that were evaluated.
    n_voting
        Number of triplets that voted.
    best_source, best_target
        (B, 3) int64, the best triplets, as numbers of samples; none where triplets are uniform.
    triplet_weights
        (B,) float64, the weights of these triplets, not increasing.
    warnings
        Notes on the votes, one line each.
    """

    matrix: np.ndarray
    n_triplets: int
    n_voting: int
    best_source: np.ndarray
    best_target: np.ndarray
    triplet_weights: np.ndarray
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return one_line(self)

    def plus(self, other: Votes, kept: int) -> Votes:
        """The sum of both, with the best triplets of both.

        Parameters
        ----------
        other
            Votes between the same samples.
        kept
            Number of triplets that are kept at most; of equal ones those of the first come first.

        Returns
        -------
        Votes
            The sum of the matrices and numbers, and the warnings of both.
        """
        best_source, best_target, triplet_weights = (
            np.concatenate([getattr(self, name), getattr(other, name)])
            for name in ("best_source", "best_target", "triplet_weights")
        )
        order = np.argsort(-triplet_weights, kind="stable")[:kept]
        return Votes(
            self.matrix + other.matrix,
            self.n_triplets + other.n_triplets,
            self.n_voting + other.n_voting,
            best_source[order],
            best_target[order],
            triplet_weights[order],
            self.warnings + other.warnings,
        )


Batch = Callable[[np.random.SeedSequence, int], Votes]
"""A function of a random stream and a number of triplets."""


def cast_votes(
    source: Surface,
    target: Surface,
    settings: MatchSettings,
    progress: Progress | None = None,
    disagreement: np.ndarray | None = None,
    parameters: VotingParameters = VotingParameters(),
) -> Votes:
    """Run Algorithm 2 on two prepared surfaces.

    Parameters
    ----------
    source, target
        The surfaces.
    settings
        How triplets are drawn and weighed, how many, the seed, and how many threads.
    progress
        Called as ``progress("voting", batches done, batches)``.
    disagreement
        (N1, N2) float64, for guided triplets: how much each two samples differ in their distances from known pairs of
        points, per sqrt(area). Samples that differ much are not matched.
    parameters
        The constants of guided voting.
    """
    if settings.proposal == "guided":
        batch, warnings = _guided(source, target, settings, disagreement, parameters)
    else:
        batch, warnings = _uniform(source, target, settings)
    total = settings.number_of_votes()
    # Batches of one size: what was drawn until the votes settled is what the same number of triplets gives.
    size = BATCH if settings.proposal == "guided" else min(LARGEST_BATCH, -(-total // LEAST_BATCHES))
    sizes = [min(size, total - start) for start in range(0, total, size)]
    n_batches = len(sizes)
    streams = np.random.SeedSequence(settings.seed).spawn(n_batches)
    open_ended = settings.votes is None and settings.proposal == "guided"
    round_size = ROUND if open_ended else n_batches
    votes = _without_triplets(np.zeros((len(source.samples), len(target.samples))), 0, 0)
    with ThreadPoolExecutor(settings.jobs or os.cpu_count() or 1) as pool:
        try:
            for start in range(0, n_batches, round_size):
                before, part = votes, slice(start, start + round_size)
                for done, more in enumerate(pool.map(batch, streams[part], sizes[part]), start + 1):
                    votes = votes.plus(more, parameters.kept)
                    if progress is not None:
                        progress("voting", done, n_batches)
                if open_ended and _settled(before, votes, parameters.settled_share):
                    break
            if progress is not None:
                progress("voting", n_batches, n_batches)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return replace(votes, warnings=warnings)


def _settled(before: Votes, after: Votes, share: float) -> bool:
    """Whether the last round changed little: the most voted target sample of each source sample, by votes."""
    leading1, leading2 = before.matrix.argmax(axis=1), after.matrix.argmax(axis=1)
    weights = after.matrix.max(axis=1)
    return bool(weights[leading1 == leading2].sum() >= share * weights.sum() > 0)


def _without_triplets(matrix: np.ndarray, n_triplets: int, n_voting: int) -> Votes:
    none = np.empty((0, 3), np.int64)
    return Votes(matrix, n_triplets, n_voting, none, none, np.empty(0))


def _uniform(source: Surface, target: Surface, settings: MatchSettings) -> tuple[Batch, tuple[str, ...]]:
    fraction = DEFAULT_MIN_FRACTION if settings.min_fraction is None else settings.min_fraction
    least_pairs = int(np.ceil(fraction * min(len(source.samples), len(target.samples))))
    points1, points2 = homogeneous(source.positions), homogeneous(target.positions)
    spherical = settings.distance == "spherical"

    def batch(stream: np.random.SeedSequence, size: int) -> Votes:
        triplets = uniform_triplets(np.random.default_rng(stream), size, len(points1), len(points2))
        matrix = np.zeros((len(points1), len(points2)))
        n_voting = vote(points1, points2, *triplets, least_pairs, settings.epsilon, spherical, matrix)
        return _without_triplets(matrix, size, n_voting)

    return batch, ()


def _guided(
    source: Surface,
    target: Surface,
    settings: MatchSettings,
    disagreement: np.ndarray | None,
    parameters: VotingParameters,
) -> tuple[Batch, tuple[str, ...]]:
    similarity = signature_similarity(source.signatures, target.signatures, parameters.similarity_width)
    if disagreement is not None:
        similarity = similarity * np.exp(-((disagreement / parameters.pair_scale) ** 2))
    draw, warnings = _proposals(source, target, disagreement, parameters)
    weigh = _weighing(source, target, similarity, settings, parameters)

    def batch(stream: np.random.SeedSequence, size: int) -> Votes:
        triplets1, triplets2 = draw(np.random.default_rng(stream), size)
        matrix, triplet_weights = np.zeros(similarity.shape), np.empty(len(triplets1))
        n_voting = weigh(triplets1, triplets2, votes=matrix, triplet_weights=triplet_weights)
        best = np.argsort(-triplet_weights, kind="stable")[: parameters.kept]
        return Votes(matrix, len(triplets1), n_voting, triplets1[best], triplets2[best], triplet_weights[best])

    return batch, warnings


def _weighing(
    source: Surface,
    target: Surface,
    similarity: np.ndarray,
    settings: MatchSettings,
    parameters: VotingParameters,
) -> Callable[..., int]:
    """:func:`vote_weighted` on these surfaces, as a function of the triplets and the arrays to write to."""
    return partial(
        vote_weighted,
        homogeneous(source.positions),
        homogeneous(target.positions),
        geodesics1=source.normalized_distances,
        geodesics2=target.normalized_distances,
        similarity=similarity,
        scale=parameters.pair_scale,
        power=parameters.weight_power,
        least_pairs=int(np.ceil((settings.min_fraction or 0.0) * min(similarity.shape))),
        spherical=settings.distance == "spherical",
    )


def triplet_weights_of(
    source: Surface,
    target: Surface,
    triplets1: np.ndarray,
    triplets2: np.ndarray,
    parameters: VotingParameters = VotingParameters(),
) -> np.ndarray:
    """The sums of the weights (I,) of triplets (I, 3) under the default settings, as in :class:`Votes`."""
    similarity = signature_similarity(source.signatures, target.signatures, parameters.similarity_width)
    triplet_weights = np.empty(len(triplets1))
    weigh = _weighing(source, target, similarity, MatchSettings(), parameters)
    weigh(triplets1, triplets2, votes=np.zeros(similarity.shape), triplet_weights=triplet_weights)
    return triplet_weights


def _proposals(
    source: Surface, target: Surface, disagreement: np.ndarray | None, parameters: VotingParameters
) -> tuple[Callable[..., Any], tuple[str, ...]]:
    """The function that draws guided triplets, with the smallest tolerances that let most draws succeed."""
    central1, central2 = source.average_distances, target.average_distances
    widening = 1
    while True:
        tolerance = widening * parameters.centrality_tolerance
        allowed = np.abs(central1[:, None] - central2) <= tolerance * central1[:, None]
        if disagreement is not None:
            allowed &= disagreement <= widening * parameters.length_tolerance
        draw = partial(
            guided_triplets,
            geodesics1=source.normalized_distances,
            geodesics2=target.normalized_distances,
            allowed=allowed,
            least_spread=parameters.least_spread / widening,
            tolerance=widening * parameters.length_tolerance,
        )
        succeeded = len(draw(np.random.default_rng(0), TRIALS)[0]) >= TRIALS // 2
        if succeeded or widening >= parameters.most_widening:
            break
        widening *= 2
    if widening == 1:
        return draw, ()
    return draw, (
        f"{source.mesh.name} and {target.mesh.name}: their geodesic distances differ much; "
        f"triplets were drawn with tolerances {widening} times as wide",
    )


def signature_similarity(signatures1: np.ndarray, signatures2: np.ndarray, width: float) -> np.ndarray:
    """Similarity (N1, N2), in [0, 1], of the wave kernel signatures (N1, e) and (N2, e) of two sets of samples.

    A Gaussian of the relative L1 distance. Its width is a multiple of the median distance of a sample to the most
    similar one, so that descriptors have little influence between shapes that differ.
    """
    differences = np.empty((len(signatures1), len(signatures2)))
    for row, signature in zip(differences, signatures1, strict=True):
        row[:] = (np.abs(signature - signatures2) / (signature + signatures2)).mean(axis=1)
    best = np.concatenate([differences.min(axis=0), differences.min(axis=1)])
    # Not less than a rounding error: a surface and itself have a median of zero, and the width may be infinite.
    return np.exp(-((differences / (width * max(float(np.median(best)), 5e-10))) ** 2))
