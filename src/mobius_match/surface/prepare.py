"""From whatever a user hands over to prepared surfaces: by computing, from a file, or from the cache."""

from __future__ import annotations

import os
from dataclasses import asdict, replace
from typing import Any, Unpack

import numpy as np
from threadpoolctl import threadpool_limits

from .._core.threads import Progress
from .._core.timing import Stopwatch
from ..errors import MeshError
from ..geometry.curvature import integrated_curvatures, smoothed_density
from ..geometry.geodesics import geodesic_solver, heat_solver, nearest_centres
from ..geometry.laplacian import intrinsic_mesh
from ..geometry.spectral import eigenbasis, wave_kernel_signature
from ..mesh import Mesh
from ..mesh.envelope import Envelope, envelopes
from ..mesh.files import as_mesh
from ..mesh.handles import cut_faces, handle_loops, is_wild, number_of_handles
from ..mesh.pieces import main_piece
from ..mesh.repair import repair
from ..mesh.report import require_matchable
from ..mesh.topology import boundary_edges
from ..settings import WHICH_PIECES, PrepareOptions, PrepareSettings, Preset, make_prepare_settings
from .cache import load_cached, store
from .disc import disc_positions
from .flattening import choose_cut_face, flatten, vertex_positions
from .handles import handle_readings
from .parameters import SurfaceParameters
from .prepared import check_effective
from .sampling import proxy_points, sample_points, straightness
from .simplified import beside_envelope, simplified
from .storage import ENDING
from .surface import Surface

LARGEST_CLOSURE = 1e-6
"""Closure of the conjugate function above which a flattening is suspect: far above round-off, far below an edge."""


def prepare(
    mesh: Any,
    settings: PrepareSettings | None = None,
    *,
    preset: Preset | None = None,
    cache: bool = False,
    progress: Progress | None = None,
    parameters: SurfaceParameters = SurfaceParameters(),
    **overrides: Unpack[PrepareOptions],
) -> Surface:
    """Prepare a mesh for matching: sample points, flattening and descriptors (sections 4 and 5 of the paper).

    Parameters
    ----------
    mesh
        A path of a mesh file or of a file of :meth:`Surface.save` (.npz), ``(vertices, faces)`` as arrays of shapes
        (n, 3) and (m, 3), any object that has both, or a Surface, which is returned as it is.
    settings
        The settings; by default those of ``PrepareSettings()``.
    preset
        ``"paper"`` for the settings of the publication, in place of the values in ``settings``.
    cache
        If the mesh file was prepared before with these settings, read the surface from the cache; else store it there.
    progress
        Called as ``progress(stage, done, total)``.
    parameters
        The constants of the method.
    **overrides
        Fields of :class:`PrepareSettings`, in place of the values in ``settings`` and of the preset's.

    Returns
    -------
    Surface
        The prepared surface. Its lengths and areas are in the units of the mesh.

    Raises
    ------
    MeshError
        If the mesh cannot be read or used; the message says why and what to do.
    SettingsError
        If a setting is unknown or out of range, or the mesh is prepared already with another value of it.

    Examples
    --------
    >>> import mobius_match as mm
    >>> surface = mm.prepare(mm.examples.paths("person")[0], samples=50)
    >>> surface.samples.shape, surface.settings.samples
    ((50,), 50)
    """
    chosen = make_prepare_settings(settings, preset, overrides)
    begun = begin_preparation(mesh, chosen, cache, parameters)
    check_effective(begun, "mesh", overrides if settings is None else asdict(chosen), preset)
    return complete_preparation(mesh, begun, chosen, cache, progress, parameters)


def begin_preparation(
    thing: Any, settings: PrepareSettings, cache: bool, parameters: SurfaceParameters
) -> Surface | Mesh:
    """The first half of :func:`prepare`: a surface that is there already, or else the mesh that is to be prepared."""
    if isinstance(thing, Surface):
        return thing
    if isinstance(thing, str | os.PathLike):
        if os.fspath(thing).lower().endswith(ENDING):
            return Surface.load(thing)
        kept = load_cached(thing, settings, parameters) if cache else None
        if kept is not None:
            return kept
    return matchable_mesh(thing, settings.pieces)


def complete_preparation(
    thing: Any,
    begun: Surface | Mesh,
    settings: PrepareSettings,
    cache: bool,
    progress: Progress | None,
    parameters: SurfaceParameters,
) -> Surface:
    """The second half of :func:`prepare`: the surface of what :func:`begin_preparation` gave."""
    if isinstance(begun, Surface):
        return begun
    surface = prepare_mesh(begun, settings, progress, parameters)
    if cache and isinstance(thing, str | os.PathLike):
        store(thing, surface)
    return surface


def matchable_mesh(thing: Any, pieces: str = "largest") -> Mesh:
    """The repaired mesh of a path, of arrays, or of an object with both, if it can be matched at all.

    Of several pieces it is the :func:`.main_piece`, with the others beside it; ``pieces`` as in
    :class:`.PrepareSettings`.

    Raises
    ------
    MeshError
        If it cannot; the message says why and what to do.
    """
    mesh = main_piece(repair(as_mesh(thing)), None if pieces in WHICH_PIECES else pieces)
    require_matchable(mesh)
    return mesh


def prepare_mesh(
    mesh: Mesh,
    settings: PrepareSettings,
    progress: Progress | None = None,
    parameters: SurfaceParameters = SurfaceParameters(),
) -> Surface:
    """:func:`prepare` for a mesh that :func:`matchable_mesh` gave."""
    report = progress or (lambda stage, done, total: None)
    # One BLAS thread: these are many small calls, and sums must not depend on the number of processors.
    with threadpool_limits(limits=1, user_api="blas"):
        number = number_of_handles(mesh.faces)
        if is_wild(number):
            surfaces = [_on_envelope(mesh, one, settings, report, parameters) for one in envelopes(mesh)]
        else:
            handles = handle_readings(mesh, number, parameters.proxy_size)
            surfaces = [
                _prepare(one, handles.loops, handles.kept if k else None, settings, report, parameters)
                for k, one in enumerate(handles.meshes)
            ]
    return surfaces[0] if len(surfaces) == 1 else replace(surfaces[0], other=surfaces[1])


def _on_envelope(
    mesh: Mesh, outer: Envelope, settings: PrepareSettings, progress: Progress, parameters: SurfaceParameters
) -> Surface:
    """The surface of an envelope, cut open along its handles, with the mesh that it stands for as its detail."""
    handles = handle_readings(outer.mesh, number_of_handles(outer.mesh.faces), parameters.proxy_size)
    surface = _prepare(handles.meshes[0], handles.loops, None, settings, progress, parameters)
    return replace(surface, detail=beside_envelope(surface.mesh, mesh), envelope=outer.offset)


def _prepare(
    mesh: Mesh,
    loops: list[np.ndarray],
    kept: list[np.ndarray] | None,
    settings: PrepareSettings,
    progress: Progress,
    parameters: SurfaceParameters,
) -> Surface:
    """The surface of one reading of a mesh, with all loops around handles, and those that are kept, if any."""
    warnings = []
    clock = Stopwatch()
    mesh, detail = (
        simplified(mesh, settings.resolution, parameters.simplification_ratio) if settings.resolution else (mesh, None)
    )
    if detail:
        clock.lap("simplifying")
    # A box of size 1 keeps squares and areas far from overflow, whatever the units of the file.
    scale = float(np.ptp(mesh.vertices, axis=0).max())
    vertices = (mesh.vertices - mesh.vertices.mean(axis=0)) / scale
    triangulation = intrinsic_mesh(vertices, mesh.faces, delaunay=settings.triangulation == "delaunay")
    areas = triangulation.areas
    area = float(areas.sum())
    progress(f"sampling {mesh.name}", 0, 3)
    geodesics = settings.geodesics
    if (geodesics, settings.triangulation) == ("heat", "delaunay"):
        solver = heat_solver(triangulation)
    else:
        solver = geodesic_solver(vertices, mesh.faces, geodesics)
    samples = sample_points(triangulation, solver, settings.samples, parameters)
    straight = straightness(vertices[samples.vertices], samples)
    if geodesics == "heat" and straight < parameters.least_straightness:
        # Heat takes long thin faces, which no flip improves, for shortcuts.
        warnings.append(
            "has faces so long and thin that distances by the heat method were shorter than straight lines; shortest "
            "paths along edges were used instead"
        )
        geodesics = "dijkstra"
        solver = geodesic_solver(vertices, mesh.faces, geodesics)
        samples = sample_points(triangulation, solver, settings.samples, parameters)
    if not np.isfinite(samples.distances).all():
        raise MeshError(f"{mesh.name}: geodesic distances could not be computed; check the mesh for sliver triangles")
    if len(samples.vertices) < settings.samples:
        warnings.append(
            f"has only {len(samples.vertices)} vertices; each of them is a sample ({settings.samples} were asked for)"
        )
    cells = np.bincount(samples.distances.argmin(axis=0), areas, len(samples.vertices))
    distances = samples.distances[:, samples.vertices]
    # Heat distances are not quite symmetric.
    distances = (distances + distances.T) / 2
    np.fill_diagonal(distances, 0.0)
    clock.lap("sampling")
    progress(f"flattening {mesh.name}", 1, 3)
    average = cells @ samples.distances / area
    flat, origin = triangulation, np.arange(len(vertices))
    if kept is not None:
        faces, origin = cut_faces(mesh.faces, handle_loops(mesh) if detail or not kept else kept)
        flat = intrinsic_mesh(vertices[origin], faces, delaunay=settings.triangulation == "delaunay")
    flattening = flatten(flat, choose_cut_face(flat, average[origin]))
    if not flattening.closure < LARGEST_CLOSURE:
        warnings.append(
            f"the flattening closes only to {flattening.closure:.1e} of its extent; "
            "matches may suffer; remove sliver triangles"
        )
    positions = vertex_positions(flattening, flat, np.searchsorted(origin, samples.vertices), settings.placement)
    clock.lap("flattening")
    progress(f"describing {mesh.name}", 2, 3)
    eigenvalues, eigenfunctions = eigenbasis(triangulation, parameters.eigenfunctions)
    signatures = wave_kernel_signature(eigenvalues, eigenfunctions[samples.vertices])
    integrated = integrated_curvatures(triangulation, vertices, mesh.faces)
    curvatures = np.column_stack(
        [
            smoothed_density(triangulation, integrated, parameters.curvature_radius),
            smoothed_density(triangulation, integrated[:, 1], parameters.wide_curvature_radius),
        ]
    ).T
    proxy = proxy_points(areas, parameters.proxy_size, samples.vertices)
    # A boundary along which a handle was cut open is no edge of a disc.
    rim = np.isin(mesh.vertex_ids[boundary_edges(mesh.faces)], np.concatenate([*loops, []])).all()
    disc = np.empty(0, np.complex128) if rim else disc_positions(flattening, flat, np.searchsorted(origin, proxy))
    nearest = nearest_centres(vertices, mesh.faces, proxy)
    touching = np.sort(nearest[mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)], axis=1)
    clock.lap("descriptors")
    progress(f"prepared {mesh.name}", 3, 3)
    return Surface(
        mesh=mesh,
        detail=detail,
        settings=settings,
        parameters=parameters,
        geodesics=geodesics,
        samples=samples.vertices,
        n_maxima=samples.n_maxima,
        distances=distances * scale,
        cells=cells * scale**2,
        positions=positions,
        disc=disc,
        signatures=signatures,
        eigenvalues=eigenvalues,
        eigenfunctions=eigenfunctions.astype(np.float32),
        proxy=proxy,
        proxy_edges=np.unique(touching[touching[:, 0] < touching[:, 1]], axis=0),
        proxy_distances=(samples.distances[:, proxy] * scale).astype(np.float32),
        curvatures=np.ascontiguousarray(curvatures, np.float32),
        cut_vertex=int(np.argmin(average)),
        closure=flattening.closure,
        loops=np.array([vertex for loop in loops for vertex in loop.tolist()], np.int64),
        loop_sizes=np.array([len(loop) for loop in loops], np.int64),
        handles_kept=kept is not None,
        envelope=0.0,
        other=None,
        area=area * scale**2,
        diameter=float(samples.distances.max()) * scale,
        timings=clock.laps,
        warnings=tuple(warnings),
    )
