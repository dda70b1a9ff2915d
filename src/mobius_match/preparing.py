"""From whatever a user hands over to prepared surfaces: by computing, from a file, or from the cache."""

from __future__ import annotations

import os
from typing import Any

from .cache import find, keep
from .mesh import Mesh
from .settings import PrepareSettings
from .storage import ENDING
from .surface import Progress, Surface, matchable, prepare_mesh


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
