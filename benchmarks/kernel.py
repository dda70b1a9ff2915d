"""Microseconds that the voting kernel takes for a triplet, beside plain loops and whole numpy arrays.

    python benchmarks/kernel.py [N ...]

The samples are those of the shipped person, the triplets the paper's uniform ones, and all figures of a table come from
one run: the versions take turns, and the least time of all turns counts. The kernel gives up most of these triplets, as
they cannot reach the number of pairs that the paper asks for; "all pairs" asks for none, and weighed ones don't either.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from unittest.mock import patch

import numpy as np
import plain_kernel

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.voting import kernel, pairing, sweep
from mobius_match.voting.mobius import homogeneous
from mobius_match.voting.parameters import VotingParameters
from mobius_match.voting.proposals import uniform_triplets
from mobius_match.voting.votes import DEFAULT_MIN_FRACTION

VERSIONS = ("kernel", "all pairs", "spherical", "weighed", "plain", "numpy")
SIZES = (50, 100, 200, 500, 1000)
TURNS = 100
SECONDS = 0.003
"""What one batch in one thread should take, about: so little that other work on the machine misses some."""

Batch = Callable[[slice], int]


def versions(surfaces: list[mm.Surface], n: int, n_triplets: int) -> dict[str, Batch]:
    """The kernels on the first n samples, each a function of which triplets to evaluate."""
    points = [surface.positions[:n] for surface in surfaces]
    triplets = uniform_triplets(np.random.default_rng(0), n_triplets, n, n)
    least_pairs, epsilon = int(DEFAULT_MIN_FRACTION * n), 0.01
    planes = [homogeneous(z) for z in points]
    geodesics = [surface.normalized_distances[:n, :n].copy() for surface in surfaces]
    similarity = np.random.default_rng(1).random((n, n))

    def uniform(part: slice) -> int:
        mine = [side[part] for side in triplets]
        return kernel.vote(*planes, *mine, least_pairs, epsilon, False, np.zeros((n, n)))

    def all_pairs(part: slice) -> int:
        mine = [side[part] for side in triplets]
        return kernel.vote(*planes, *mine, 0, epsilon, False, np.zeros((n, n)))

    def spherical(part: slice) -> int:
        mine = [side[part] for side in triplets]
        return kernel.vote(*planes, *mine, least_pairs, epsilon, True, np.zeros((n, n)))

    def weighed(part: slice) -> int:
        mine = [side[part] for side in triplets]
        totals, votes = np.empty(len(mine[0])), np.zeros((n, n))
        weights = (*geodesics, similarity, VotingParameters.pair_scale, VotingParameters.weight_power)
        return kernel.vote_weighted(*planes, *mine, *weights, 0, False, votes, totals)

    def plain(part: slice) -> int:
        mine = [side[part] for side in triplets]
        return plain_kernel.vote(*points, *mine, least_pairs, epsilon, np.zeros((n, n)))

    def in_numpy(part: slice) -> int:
        mine = [side[part] for side in triplets]
        return plain_kernel.vote_numpy(*points, *mine, least_pairs, epsilon, np.zeros((n, n)))

    return dict(zip(VERSIONS, (uniform, all_pairs, spherical, weighed, plain, in_numpy), strict=True))


def seconds(batch: Batch, n_triplets: int, threads: int) -> float:
    """Time of one triplet where each thread evaluates as many."""
    with ThreadPoolExecutor(threads) as pool:
        parts = [slice(thread * n_triplets, (thread + 1) * n_triplets) for thread in range(threads)]
        list(pool.map(lambda part: batch(slice(part.start, part.start + 1)), parts))  # threads are started
        start = time.perf_counter()
        list(pool.map(batch, parts))
        return (time.perf_counter() - start) / (threads * n_triplets)


def measure(batches: dict[str, Batch], most: int) -> dict[tuple[str, int], float]:
    """Least microseconds a triplet of each version in one and two threads."""
    counts = {}
    for name, batch in batches.items():
        batch(slice(0, 2))  # compiled
        counts[name] = 2
        for _ in range(4):  # what a call costs beside its triplets counts less and less
            counts[name] = min(most // 2, max(2, int(SECONDS / seconds(batch, counts[name], 1))))
    times = {(name, threads): np.inf for name in batches for threads in (1, 2)}
    for _ in range(TURNS):
        for name, threads in times:
            if name != "numpy" or threads == 1:  # holds the lock of Python
                found = seconds(batches[name], counts[name], threads)
                times[name, threads] = min(times[name, threads], 1e6 * found)
    return times


def crossover(surfaces: list[mm.Surface]) -> None:
    """Print the time of both ways to pair the samples of a triplet, to see from which number on the sweep is faster."""
    print(f"\nmicroseconds of pairing the samples of a triplet (the kernel sweeps from {sweep.SWEEP_FROM} samples)")
    print("   N  comparing  sweeping")
    for n in (100, 200, 250, 300, 350, 400, 500, 700, 1000):
        points = [homogeneous(surface.positions[:n]) for surface in surfaces]
        triplets = uniform_triplets(np.random.default_rng(0), 100, n, n)
        best = []
        for first_to_sweep in (n + 1, 0):
            times = []
            with patch.object(pairing, "SWEEP_FROM", first_to_sweep):
                for _ in range(1 + TURNS // 5):
                    start = time.perf_counter()
                    list(pairing.candidate_pairs(*points, *triplets, 0, False))
                    times.append(1e6 * (time.perf_counter() - start) / 100)
            best.append(min(times[1:]))
        print(f"{n:5} {best[0]:10.1f} {best[1]:9.1f}", flush=True)


def main() -> None:
    sizes = [int(argument) for argument in sys.argv[1:]] or list(SIZES)
    surfaces = [mm.prepare(path, samples=max(*sizes, 1000)) for path in examples.paths("person")]
    print("microseconds a triplet; in brackets how many times the kernel's, and one thread's time over two's")
    print("   N  threads   kernel      all pairs         spherical         weighed           plain loops         numpy")
    for n in sizes:
        times = measure(versions(surfaces, n, 40_000), 40_000)
        for threads in (1, 2):
            reference = times["kernel", threads]
            cells = [f"{reference:8.2f}   "]
            cells += [
                f"{times[name, threads]:10.2f} ({times[name, threads] / reference:5.1f})"
                for name in VERSIONS[1:]
                if np.isfinite(times[name, threads])
            ]
            gains = [f"{name} {times[name, 1] / times[name, 2]:.2f}" for name in ("kernel", "weighed", "plain")]
            print(f"{n:5} {threads:6} {' '.join(cells)} {'  ' + ', '.join(gains) if threads == 2 else ''}", flush=True)
    crossover(surfaces)


if __name__ == "__main__":
    main()
