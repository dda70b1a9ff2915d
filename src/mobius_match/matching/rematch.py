"""A loaded result made alive again."""

from __future__ import annotations

from .._core.threads import Progress
from ..mesh import unchanged
from ..results.correspondence import Correspondence
from .match import match


def rematch(result: Correspondence, *, cache: bool = False, progress: Progress | None = None) -> Correspondence:
    """Match the meshes of a loaded result again, with its own settings.

    Parameters
    ----------
    result
        A result of :meth:`Correspondence.load`; its paths count from the current folder.
    cache, progress
        As in :func:`match`.

    Raises
    ------
    MeshError
        If a mesh was given as arrays, or its file is missing or has changed since (by its SHA-256).
    """
    paths = [unchanged(info.get("path"), info.get("sha256", "")) for info in (result.source_info, result.target_info)]
    return match(*paths, cache=cache, progress=progress, **result.settings)
