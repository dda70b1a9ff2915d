"""Voting for the mirror symmetry of one surface: triplets that change two of its samples for each other.

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
from ...voting.proposals import CENTRALITY_TOLERANCE, LEAST_SPREAD, LENGTH_TOLERANCE
from ...voting.votes import KEPT, WEIGHT_POWER, WEIGHT_SCALE, Votes

BATCHES = 32
ATTEMPTS = 50
"""Draws for one triplet, on average, before the search for more is given up."""

STAYING = 0.1
"""Distance per sqrt(area) to its image at which a point counts 1 - 1 / e: less speaks for the identity as well."""

SIMILARITY = 1.5
"""Width of the similarity of descriptors, in medians of the difference from a sample to the most similar other one."""


def cast_swap_votes(surface: Surface, settings: MatchSettings, progress: Progress | None = None) -> Votes:
    """Algorithm 2 with weighed pairs on a surface and its mirror image, by triplets that swap two samples.

    Parameters
    ----------
    surface
        The surface.
    settings
        How many triplets are evaluated, the seed, and how many threads; the result does not depend on the last.
    progress
        Called as ``progress("voting", batches done, batches)``.

    Returns
    -------
    Votes
        ``best2`` and the columns of the matrix are samples of the same surface.
    """
    geodesics, central = surface.normalized_distances, surface.average_distances
    points, mirrored = homogeneous(surface.positions), homogeneous(surface.positions.conj())
    allowed = np.abs(central[:, None] - central) <= CENTRALITY_TOLERANCE * np.minimum(central[:, None], central)
    similarity = self_similarity(surface.signatures) * (1 - np.exp(-((geodesics / STAYING) ** 2)))

    def batch(stream: np.random.SeedSequence, size: int) -> Votes:
        here, there = swap_triplets(np.random.default_rng(stream), size, geodesics, allowed)
        matrix, triplet_weights = np.zeros(similarity.shape), np.empty(len(here))
        n_voting = vote_weighted(
            points,
            mirrored,
            here,
            there,
            geodesics1=geodesics,
            geodesics2=geodesics,
            similarity=similarity,
            scale=WEIGHT_SCALE,
            power=WEIGHT_POWER,
            least_pairs=0,
            spherical=False,
            votes=matrix,
            triplet_weights=triplet_weights,
        )
        best = np.argsort(-triplet_weights, kind="stable")[: min(KEPT, np.count_nonzero(triplet_weights))]
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
                votes += more
                if progress is not None:
                    progress("voting", done + 1, BATCHES)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return votes


def swap_triplets(
    generator: np.random.Generator, count: int, geodesics: np.ndarray, allowed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Triplets (i, j, k) and their images (j, i, l) that agree in their distances, (found, 3) int64 each.

    Parameters
    ----------
    generator
        Random stream of this batch.
    count
        How many are wanted; fewer are found where hardly any fits.
    geodesics
        (N, N) float64 distances between the samples per sqrt(area).
    allowed
        (N, N) bool: which samples may be matched.
    """
    n = len(geodesics)
    apart = geodesics >= LEAST_SPREAD
    found = np.empty((0, 4), np.int64)
    for _ in range(ATTEMPTS):
        if len(found) >= count:
            break
        i, j, k = generator.integers(0, n, (3, count))
        possible = allowed[i, j] & apart[i, j] & apart[i, k] & apart[j, k]
        i, j, k = i[possible], j[possible], k[possible]
        fits = allowed[k] & (geodesics[i] > 0) & (geodesics[j] > 0)
        for far, near in ((i, j), (j, i)):  # l lies as far from j as k does from i, and the other way round
            fits &= (
                np.abs(geodesics[far, k][:, None] - geodesics[near]) <= LENGTH_TOLERANCE * geodesics[far, k][:, None]
            )
        some = fits.any(axis=1)
        image = np.argmax(np.where(fits, generator.random(fits.shape), -1.0), axis=1)
        found = np.concatenate([found, np.stack([i, j, k, image], axis=1)[some]])
    i, j, k, image = found[:count].T
    return np.stack([i, j, k], axis=1), np.stack([j, i, image], axis=1)


def self_similarity(signatures: np.ndarray) -> np.ndarray:
    """How alike the wave kernel signatures (N, e) of the samples of one surface are: (N, N) in [0, 1].

    A Gaussian of the relative L1 distance. Its width comes from the most similar other sample: that a sample is like
    itself says nothing of how alike mirror images are.
    """
    differences = np.array([(np.abs(one - signatures) / (one + signatures)).mean(axis=1) for one in signatures])
    others = differences + np.diag(np.full(len(differences), np.inf))
    width = max(SIMILARITY * float(np.median(others.min(axis=1))), 1e-9)
    return np.exp(-((differences / width) ** 2))
