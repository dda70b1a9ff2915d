"""Shapes that come with the package: two bodies, each in two poses, and the true map between the poses.

Each pose is a closed surface of genus 0 with about 5,000 vertices, meshed and numbered on its own, in metres,
with y upward. ``tools/make_shapes.py`` in the source tree made them; ``LICENSE.md`` says from what.
"""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import SettingsError

if TYPE_CHECKING:
    import numpy as np

__all__ = ["names", "paths", "truth"]


def names() -> tuple[str, ...]:
    """Names of the pairs.

    >>> names()
    ('person', 'quadruped')
    """
    return "person", "quadruped"


def paths(name: str) -> tuple[Path, Path]:
    """Files of both poses of a body.

    Parameters
    ----------
    name
        One of `names`.

    Returns
    -------
    tuple of Path
        Two binary PLY files, pose 0 (standing) and pose 1.

    Raises
    ------
    SettingsError
        If there is no pair of this name.
    """
    return _file(name, "0.ply"), _file(name, "1.ply")


def truth(name: str, mirrored: bool = False, reverse: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Where each vertex of one pose lies on the mesh of the other.

    The point of the body that the vertex is, carried over to the other pose, then moved to the closest point
    of the mesh there: a distance of the order of what meshing has cut off, far less than an edge.

    Parameters
    ----------
    name
        One of `names`.
    mirrored
        Swap left and right: the opposite point of the body, which is a symmetric one.
    reverse
        From pose 1 to pose 0 instead of from pose 0 to pose 1.

    Returns
    -------
    faces : (n,) int64
        For each of the n vertices of the pose that the map starts from, a face of the other pose's mesh.
    barycentric : (n, 3) float64
        Place on that face, as weights of its vertices in the file's order; none negative, each row's sum 1.

    Raises
    ------
    SettingsError
        If there is no pair of this name.
    """
    import numpy as np

    key = ("reverse" if reverse else "forward") + ("_mirrored" if mirrored else "")
    with np.load(_file(name, "_truth.npz"), allow_pickle=False) as arrays:
        faces = arrays[f"{key}_faces"].astype(np.int64)
        barycentric = arrays[f"{key}_barycentric"].astype(np.float64)
    return faces, barycentric / barycentric.sum(axis=1, keepdims=True)


def _file(name: str, ending: str) -> Path:
    """A data file, once the name is known to be good."""
    if name not in names():
        raise SettingsError(f"there is no example called {name!r}; there are {', '.join(names())}")
    return Path(str(resources.files(__name__) / "data" / f"{name}{ending}"))
