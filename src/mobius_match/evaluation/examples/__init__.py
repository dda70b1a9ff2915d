"""Example shapes of the package: two bodies, each in two poses, and the true map between the poses.

Each pose is a closed surface of genus 0 with about 5,000 vertices, meshed independently, in metres, with y upward.
``LICENSE.md`` documents their origin; ``tools/make_shapes.py`` in the source tree generates them.
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
    """The true position of each vertex of one pose on the mesh of the other.

    It is the closest point of the mesh to the vertex's point of the body in the other pose. The distance between the
    two is the error of meshing, much less than an edge.

    Parameters
    ----------
    name
        One of `names`.
    mirrored
        Exchange left and right: map to the opposite point of the body, which is symmetric.
    reverse
        Map pose 1 to pose 0 instead of pose 0 to pose 1.

    Returns
    -------
    faces : (n,) int64
        A face of the other pose's mesh for each of the n vertices.
    barycentric : (n, 3) float64
        Barycentric coordinates in that face, in the file's order of its vertices.

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
    """The path of a data file."""
    if name not in names():
        raise SettingsError(f"there is no example called {name!r}; there are {', '.join(names())}")
    return Path(str(resources.files(__name__) / "data" / f"{name}{ending}"))
