"""A loaded result matched again, to have its surfaces, votes and dense map."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from .._core.threads import Progress
from ..mesh import unchanged
from ..results.correspondence import Correspondence
from ..settings import PrepareSettings
from ..surface.prepare import prepare
from .match import match


def rematch(result: Correspondence, *, cache: bool = False, progress: Progress | None = None) -> Correspondence:
    """Match the meshes of a loaded result again, with the settings that it records.

    The same version of the program gives the same pairs, also where the surfaces were prepared beforehand.

    Parameters
    ----------
    result
        A result of :meth:`Correspondence.load`; relative paths in it are relative to the current folder.
    cache, progress
        As in :func:`match`.

    Returns
    -------
    Correspondence
        The new result, with surfaces, votes and a dense map.

    Raises
    ------
    MeshError
        If a mesh was given as arrays, or its file is missing or has changed since (by its SHA-256).
    """
    things: list[Any] = [
        unchanged(info.get("path"), info.get("sha256", "")) for info in (result.source_info, result.target_info)
    ]
    settings = dict(result.settings)
    of_target = settings.pop("target_preparation", None)
    if of_target is not None:
        of_source = {field.name: settings.pop(field.name) for field in fields(PrepareSettings)}
        things = [
            prepare(path, PrepareSettings(**of_one), cache=cache, progress=progress)
            for path, of_one in zip(things, (of_source, of_target), strict=True)
        ]
    return match(*things, cache=cache, progress=progress, **settings)
