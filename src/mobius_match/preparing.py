"""From whatever a user hands over to prepared surfaces: by computing, from a file, or from the cache."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from .cache import find, keep
from .mesh import Mesh
from .settings import PrepareSettings
from .storage import ENDING
from .surface import Progress, Surface, matchable, prepare_mesh

Result = TypeVar("Result")


def prepare(
    thing: Any,
    settings: PrepareSettings | None = None,
    *,
    cache: bool = False,
    progress: Progress | None = None,
    **overrides: Any,
) -> Surface:
    """Make a mesh ready for matching.

    Parameters
    ----------
    thing
        A path of a mesh file or of a file of :meth:`Surface.save` (.npz), ``(vertices, faces)``, anything with both as
        attributes, or a Surface, which is returned as it is.
    settings
        A :class:`PrepareSettings`; single values can be given as keywords instead.
    cache
        Take the surface of a mesh file from the cache if it was prepared before, else keep it there.
    progress
        Called as ``progress(stage, done, total)``.

    Raises
    ------
    MeshError
        If the mesh cannot be read or used; the message says why and what to do.
    SettingsError
        If a setting is out of range.
    """
    settings = settings or PrepareSettings(**overrides)
    return finished(thing, opened(thing, settings, cache), settings, cache, progress)


def opened(thing: Any, settings: PrepareSettings, cache: bool) -> Surface | Mesh:
    """The first half of :func:`prepare`: a surface that is there already, or else the mesh that is to be prepared."""
    if isinstance(thing, Surface):
        return thing
    if isinstance(thing, str | os.PathLike):
        if os.fspath(thing).lower().endswith(ENDING):
            return Surface.load(thing)
        kept = find(thing, settings) if cache else None
        if kept is not None:
            return kept
    return matchable(thing)


def finished(
    thing: Any, found: Surface | Mesh, settings: PrepareSettings, cache: bool, progress: Progress | None
) -> Surface:
    """The second half of :func:`prepare`: the surface of what :func:`opened` found."""
    if isinstance(found, Surface):
        return found
    surface = prepare_mesh(found, settings, progress)
    if cache and isinstance(thing, str | os.PathLike):
        keep(thing, surface)
    return surface


def each(
    work: Callable[[int, Progress], Result], number: int, jobs: int | None, progress: Progress | None
) -> list[Result]:
    """Results of ``work(0, tell), work(1, tell), ...`` in this order, worked out in as many threads as there may be.

    Parameters
    ----------
    work
        Given the number of a piece of work and what to tell progress to.
    jobs
        Threads; None for every processor.
    progress
        Called from the calling thread, whatever thread the news come from.
    """
    tell = progress or (lambda stage, done, total: None)
    if min(jobs or os.cpu_count() or 1, number) == 1:
        return [work(i, tell) for i in range(number)]
    news: SimpleQueue[tuple[str, int, int] | None] = SimpleQueue()
    ended = threading.Event()

    def note(*event: Any) -> None:
        if ended.is_set():
            raise CancelledError
        news.put(event)

    def run(i: int) -> Result:
        try:
            return work(i, note)
        finally:
            news.put(None)

    # The limit of BLAS threads is everyone's: set here, no thread lifts it while another works.
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(jobs) as pool:
        try:
            running = [pool.submit(run, i) for i in range(number)]
            for _ in running:
                while (event := news.get()) is not None:
                    tell(*event)
            return [one.result() for one in running]
        finally:
            ended.set()
