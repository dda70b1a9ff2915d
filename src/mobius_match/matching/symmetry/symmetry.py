"""The intrinsic symmetry of one surface: its Möbius voting against its own mirror image.

Beyond the paper, in the spirit of Kim, Lipman, Chen and Funkhouser (2010). An orientation-reversing isometry of a
surface onto itself is an anti-Möbius map of its flattening: a Möbius map after complex conjugation. So the surface is
matched with a copy whose positions are conjugated, by triplets that swap two points (``voting/swaps.py``). A mirror
symmetry is its own inverse: the functional map of the best alignment is projected to such a map, and a pair is accepted
if the map of the whole surface sends each of its points to the other.
"""

from __future__ import annotations

import time
from dataclasses import asdict, replace
from typing import Any, Unpack

import numpy as np
from threadpoolctl import threadpool_limits

from ..._core.threads import Progress
from ..._core.versions import software
from ...alignments.alignment import Alignment
from ...alignments.candidates import Candidates
from ...alignments.parameters import AlignmentParameters
from ...errors import NothingFoundError
from ...geometry.geodesics import geodesic_solver
from ...geometry.nearest_neighbors import nearest_neighbors
from ...geometry.spectral import functional_map, wave_kernel_signature
from ...mesh.measure import box_scale, unit_box
from ...results.symmetry import Symmetry
from ...settings import SymmetryOptions, check_names, make_settings
from ...surface.parameters import SurfaceParameters
from ...surface.prepare import begin_preparation, complete_preparation
from ...surface.prepared import check_effective
from ...surface.surface import Surface
from ...voting.assignment import max_row_column
from ...voting.votes import Votes
from .parameters import SymmetryParameters
from .swaps import cast_swap_votes


def symmetry(
    mesh: Any,
    *,
    cache: bool = False,
    progress: Progress | None = None,
    parameters: SymmetryParameters = SymmetryParameters(),
    **settings: Unpack[SymmetryOptions],
) -> Symmetry:
    """Find the intrinsic mirror symmetry of one surface, in any pose.

    Parameters
    ----------
    mesh
        A path of a mesh file, ``(vertices, faces)`` as arrays of shapes (n, 3) and (m, 3), any object that has both, or
        a prepared :class:`Surface` or the file (.npz) of one. A prepared surface is used as it is.
    cache
        If the mesh file was prepared before, read its surface from the cache; else store it there. The result does not
        depend on it.
    progress
        Called as ``progress(stage, done, total)`` from the calling thread.
    parameters
        The constants of the method, for those who study it; the defaults are the method.
    **settings
        The fields of :class:`PrepareSettings`, and ``votes``, ``seed`` and ``jobs`` of :class:`MatchSettings`.

    Returns
    -------
    Symmetry
        Pairs of mirrored vertices, the most confident first, and the vertices that stay in place.

    Raises
    ------
    MeshError
        If the mesh cannot be read or used.
    SettingsError
        If a setting is unknown or out of range, or was given and a prepared surface has another value of it.
    NothingFoundError
        If no pair of points is confirmed.

    References
    ----------
    V. G. Kim, Y. Lipman, X. Chen and T. Funkhouser, "Möbius Transformations for Global Intrinsic Symmetry Analysis",
    Computer Graphics Forum 29 (5), 2010.

    Examples
    --------
    >>> import mobius_match as mm
    >>> from mobius_match import examples
    >>> found = mm.symmetry(examples.paths("person")[0])
    >>> found.score > 0.9
    True
    """
    known = list(SymmetryOptions.__annotations__)
    check_names(settings, known, "symmetry")
    chosen = make_settings(**settings)
    start = time.perf_counter()
    half = begin_preparation(mesh, chosen.preparation(), cache, SurfaceParameters())
    check_effective(half, "mesh", settings)
    timings = {"reading": time.perf_counter() - start}
    surface = complete_preparation(mesh, half, chosen.preparation(), cache, progress, SurfaceParameters())
    chosen = replace(chosen, **asdict(surface.settings))
    if half is not surface:
        timings |= surface.timings
    begin = time.perf_counter()
    alignment = AlignmentParameters()
    votes = cast_swap_votes(surface, chosen, parameters, alignment.voting, progress)
    timings["voting"] = time.perf_counter() - begin
    begin = time.perf_counter()
    # One BLAS thread: sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        mirrored = replace(surface, positions=surface.positions.conj())
        found = Candidates(surface, mirrored, alignment).voted(votes, discs=False)
        pairs, confidence, stationary, score = _pairs(surface, votes, found, parameters)
    timings |= {"pairs": time.perf_counter() - begin, "total": time.perf_counter() - start}
    numbers = surface.mesh.vertex_ids
    return Symmetry(
        pairs=numbers[pairs],
        confidence=confidence,
        stationary=np.unique(numbers[stationary]),
        score=score,
        source_info=surface.info,
        settings={name: getattr(chosen, name) for name in known} | {"votes": votes.n_triplets},
        timings=timings,
        software=dict(software()),
        warnings=(*surface.notes, *_score_warnings(surface, score, parameters)),
        source=surface,
    )


def _pairs(
    surface: Surface, votes: Votes, found: list[Alignment], parameters: SymmetryParameters
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Pairs (Q, 2), confidence (Q,), stationary vertices (S,), all in numbers of the repaired mesh, and score."""
    samples, unit = surface.samples, surface.scale
    images = mirror_images(surface, found[0], samples) if found else samples
    solver = _Distances(surface)
    distances = solver(images)[:, samples] / unit
    agreement = np.exp(-((distances / parameters.radius) ** 2))
    ballots = votes.matrix + votes.matrix.T
    support = (ballots * agreement).sum(axis=1) / np.maximum(ballots.sum(axis=1), np.finfo(float).tiny)
    # An isometry that is its own inverse keeps d(T x, y) = d(x, T y).
    certainty = support * np.exp(-np.abs(distances - distances.T).mean(axis=1) / parameters.radius)
    matched, _ = max_row_column(ballots * agreement * agreement.T)
    confidence = np.sqrt(certainty[matched].prod(axis=1))
    once = np.flatnonzero((matched[:, 0] < matched[:, 1]) & (confidence >= parameters.least_confidence))
    if not len(once):
        raise _not_found(surface, votes)
    once = once[np.argsort(-confidence[once], kind="stable")]
    here, confidence = matched[once, 0], confidence[once]
    pairs = np.stack([samples[here], images[here]], axis=1)
    first, second = (solver(pairs[: parameters.stationary_pairs, side]) for side in range(2))
    off = np.abs(first - second).mean(axis=0)
    stationary = np.flatnonzero(off <= max(parameters.stationary_tolerance * unit, solver.mean_edge))
    taken = set(stationary.tolist())
    kept = []
    for number, pair in enumerate(pairs.tolist()):
        if taken.isdisjoint(pair):
            taken.update(pair)
            kept.append(number)
    if not kept:
        raise _not_found(surface, votes)
    return pairs[kept], confidence[kept], stationary, _score(surface, images)


def mirror_images(surface: Surface, alignment: Alignment, vertices: np.ndarray) -> np.ndarray:
    """Images (q,) int64 of vertices (q,) under the nearest map to an alignment that is its own inverse.

    The functional map C of an isometry that is its own inverse is orthogonal and symmetric, with eigenvalues 1 and -1.
    The nearest such matrix to the functional map of the alignment has the eigenvectors of (C + C^T) / 2 and the signs
    of its eigenvalues.
    """
    functions = surface.eigenfunctions.astype(np.float64)
    transfer = functional_map(functions[surface.proxy], functions[alignment.image])
    values, vectors = np.linalg.eigh((transfer + transfer.T) / 2)
    involution = (vectors * np.where(values < 0, -1.0, 1.0)) @ vectors.T
    return nearest_neighbors(functions[vertices] @ involution, functions)


def _score(surface: Surface, images: np.ndarray) -> float:
    """How similar samples and their images (N,) are, compared with two random samples: in [0, 1]."""
    here, there = (
        wave_kernel_signature(surface.eigenvalues, surface.eigenfunctions[vertices].astype(np.float64))
        for vertices in (surface.samples, images)
    )
    shares = surface.cells / surface.cells.sum()
    appearance_cost = shares @ _differences(here, there)
    chance = sum(share * (shares @ _differences(one, here)) for share, one in zip(shares, here, strict=True))
    return float(np.clip(1 - appearance_cost / chance, 0.0, 1.0)) if chance > 0 else 1.0


def _differences(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return (np.abs(first - second) / (first + second)).mean(axis=1)


class _Distances:
    """Geodesic distances from vertices (q,) to all, (q, n), in the units of the mesh."""

    def __init__(self, surface: Surface) -> None:
        vertices, faces = unit_box(surface.mesh.vertices), surface.mesh.faces
        self._scale = box_scale(surface.mesh.vertices)
        self._solve = geodesic_solver(vertices, faces, surface.geodesics)
        corners = vertices[faces]
        self.mean_edge = self._scale * float(np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).mean())

    def __call__(self, vertices: np.ndarray) -> np.ndarray:
        return self._scale * np.array([self._solve(int(vertex)) for vertex in vertices])


def _not_found(surface: Surface, votes: Votes) -> NothingFoundError:
    return NothingFoundError(
        f"{surface.mesh.name}: no mirror symmetry was found with {votes.n_triplets} triplets of points; "
        "raise `votes` or `samples`, or the shape has none"
    )


def _score_warnings(surface: Surface, score: float, parameters: SymmetryParameters) -> list[str]:
    if score >= parameters.low_score:
        return []
    return [
        f"{surface.mesh.name}: hardly symmetric (score {score:.2f}; bodies in any pose reach {parameters.low_score} or "
        "more): the pairs belong to the map closest to a symmetry"
    ]
