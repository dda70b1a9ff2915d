"""Voting for the mirror symmetry of one surface: triplets that swap two of its samples.

The triplet (i, j, k) goes to (j, i, l). An anti-Möbius map that does so is an involution if the third pair fits, which
leaves far fewer triplets to draw than there are between two surfaces. The target is the surface itself with its
positions conjugated, so that Algorithm 2 finds maps that reverse orientation.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..._core.threads import Progress
from ...settings import MatchSettings
from ...surface.surface import Surface
from ...voting.kernel import vote_weighted
from ...voting.mobius import homogeneous
from ...voting.parameters import VotingParameters
from ...voting.votes import Votes
from .parameters import SymmetryParameters

BATCHES = 32
"""Batches of triplets, each with its own random stream."""


ATTEMPTS = 50
"""Mean number of draws for a triplet before the search for more ends."""


def cast_swap_votes(
    surface: Surface,
    settings: MatchSettings,
    parameters: SymmetryParameters,
    voting: VotingParameters,
    progress: Progress | None = None,
) -> Votes:
    """Algorithm 2 with weighted pairs on a surface and its mirror image, by triplets that swap two samples.

    Parameters
    ----------
    surface
        The surface.
    settings
        Number of triplets, seed, and number of threads; the result does not depend on the last.
    parameters, voting
        Constants of the method.
    progress
        Called as ``progress("voting", batches done, batches)``.

    Returns
    -------
    Votes
        ``best_target`` and the columns of the matrix are samples of the same surface.
    """
    geodesics, central = surface.normalized_distances, surface.average_distances
    points, mirrored = homogeneous(surface.positions), homogeneous(surface.positions.conj())
    allowed = np.abs(central[:, None] - central) <= voting.centrality_tolerance * np.minimum(central[:, None], central)
    # A point that stays near its place supports the identity as well.
    moved = 1 - np.exp(-((geodesics / parameters.radius) ** 2))
    similarity = self_similarity(surface.signatures, parameters.similarity_width) * moved

    def batch(stream: np.random.SeedSequence, size: int) -> Votes:
        here, there = swap_triplets(np.random.default_rng(stream), size, geodesics, allowed, voting)
        matrix, triplet_weights = np.zeros(similarity.shape), np.empty(len(here))
        n_voting = vote_weighted(
            points,
            mirrored,
            here,
            there,
            geodesics1=geodesics,
            geodesics2=geodesics,
            similarity=similarity,
            scale=voting.pair_scale,
            power=voting.weight_power,
            least_pairs=0,
            spherical=False,
            votes=matrix,
            triplet_weights=triplet_weights,
        )
        best = np.argsort(-triplet_weights, kind="stable")[: min(voting.kept, np.count_nonzero(triplet_weights))]
        return Votes(matrix, len(here), n_voting, here[best], there[best], triplet_weights[best])

    total = settings.number_of_votes()
    sizes = [total * (k + 1) // BATCHES - total * k // BATCHES for k in range(BATCHES)]
    none = np.empty((0, 3), np.int64)
    votes = Votes(np.zeros(similarity.shape), 0, 0, none, none, np.empty(0))
    with ThreadPoolExecutor(settings.jobs or os.cpu_count() or 1) as pool:
        try:
            streams = np.random.SeedSequence(settings.seed).spawn(BATCHES)
            # Summed in the order of the batches, whichever thread is done first.
            for done, more in enumerate(pool.map(batch, streams, sizes)):
                votes = votes.plus(more, voting.kept)
                if progress is not None:
                    progress("voting", done + 1, BATCHES)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return votes


def swap_triplets(
    generator: np.random.Generator,
    count: int,
    geodesics: np.ndarray,
    allowed: np.ndarray,
    voting: VotingParameters,
) -> tuple[np.ndarray, np.ndarray]:
    """Triplets (i, j, k) and their images (j, i, l) that agree in their distances, (found, 3) int64 each.

    Parameters
    ----------
    generator
        Random stream of this batch.
    count
        Number of triplets; fewer are found where hardly any fits.
    geodesics
        (N, N) float64 distances between the samples per sqrt(area).
    allowed
        (N, N) bool: which samples may be matched.
    voting
        Least spread and tolerance of triplets.
    """
    n = len(geodesics)
    apart = geodesics >= voting.least_spread
    found = np.empty((0, 4), np.int64)
    for _ in range(ATTEMPTS):
        if len(found) >= count:
            break
        i, j, k = generator.integers(0, n, (3, count))
        possible = allowed[i, j] & apart[i, j] & apart[i, k] & apart[j, k]
        i, j, k = i[possible], j[possible], k[possible]
        fits = allowed[k] & (geodesics[i] > 0) & (geodesics[j] > 0)
        for far, near in ((i, j), (j, i)):  # d(j, l) = d(i, k), and d(i, l) = d(j, k)
            fits &= (
                np.abs(geodesics[far, k][:, None] - geodesics[near])
                <= voting.length_tolerance * geodesics[far, k][:, None]
            )
        some = fits.any(axis=1)
        image = np.argmax(np.where(fits, generator.random(fits.shape), -1.0), axis=1)
        found = np.concatenate([found, np.stack([i, j, k, image], axis=1)[some]])
    i, j, k, image = found[:count].T
    return np.stack([i, j, k], axis=1), np.stack([j, i, image], axis=1)


def self_similarity(signatures: np.ndarray, relative_width: float) -> np.ndarray:
    """Similarity (N, N) in [0, 1] of the wave kernel signatures (N, e) of the samples of one surface.

    A Gaussian of the relative L1 distance. Its width is a multiple of the median difference to the most similar other
    sample, since the difference of a sample from itself, 0, says nothing about that of mirror images.
    """
    differences = np.array([(np.abs(one - signatures) / (one + signatures)).mean(axis=1) for one in signatures])
    others = differences + np.diag(np.full(len(differences), np.inf))
    width = max(relative_width * float(np.median(others.min(axis=1))), 1e-9)
    return np.exp(-((differences / width) ** 2))
