"""What is written of a match: its pairs as landmarks of both shapes, and its dense map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .._core.display import one_line
from ..errors import MeshError, NothingFoundError, SettingsError
from ..landmarks.rows import SIDES
from ..landmarks.tables import Landmarks
from ..mesh import Mesh
from ..results.correspondence import Correspondence
from ..results.surface_map import SurfaceMap
from .figures import mesh_of, numbered

DIRECTION = "source -> target"


@dataclass(frozen=True, eq=False)
class Content:
    """A result, or a dense map, or both.

    Parameters
    ----------
    result
        The matches; None where there is only a map.
    dense
        The map, or None.

    Raises
    ------
    MeshError
        If the two are of different meshes.
    """

    result: Correspondence | None
    dense: SurfaceMap | None

    def __repr__(self) -> str:
        return one_line(self)

    def __post_init__(self) -> None:
        if self.result is None or self.dense is None:
            return
        ours, theirs = (self.result.source_info, self.result.target_info), (self.dense.source, self.dense.target)
        if any(info.get("sha256") != mesh.sha256 for info, mesh in zip(ours, theirs, strict=True)):
            raise MeshError("the map is of other meshes than the result; make it with the result (--dense)")

    @property
    def matches(self) -> Correspondence:
        """The matches.

        Raises
        ------
        SettingsError
            If there are none.
        """
        if self.result is None:
            raise SettingsError("a dense map holds no list of matches; give the result of mobius match -o")
        return self.result

    @property
    def given(self) -> np.ndarray:
        """Which matches are landmarks that the user gave, (Q,) bool."""
        found = self.matches.given
        return np.zeros(len(self.matches), bool) if found is None else found

    @property
    def map(self) -> SurfaceMap:
        """The dense map.

        Raises
        ------
        SettingsError
            If there is none.
        """
        if self.dense is None:
            raise SettingsError("this format holds a dense map: give it with --dense MAP.npz, of mobius match --dense")
        return self.dense

    @cached_property
    def meshes(self) -> tuple[Mesh, Mesh]:
        """Both repaired meshes, read again if need be."""
        if self.result is None:
            return self.map.source, self.map.target
        one = self.result
        return mesh_of(one.source, one.source_info), mesh_of(one.target, one.target_info)

    @property
    def names(self) -> list[str]:
        """Names of both mesh files."""
        if self.result is None:
            return [mesh.name for mesh in self.meshes]
        infos = self.result.source_info, self.result.target_info
        return [Path(str(info.get("path") or side)).name for info, side in zip(infos, SIDES, strict=True)]

    @cached_property
    def marks(self) -> tuple[Landmarks, Landmarks]:
        """The matches as landmarks of the source and of the target, named by their rank from 1."""
        pairs, exact = self.matches.pairs, self.matches.target_points
        points = [mesh.vertices[numbered(mesh, numbers)] for mesh, numbers in zip(self.meshes, pairs.T, strict=True)]
        if exact is not None:
            target = self.meshes[1]
            corners = target.vertices[numbered(target, exact.corners.ravel())].reshape(-1, 3, 3)
            points[1] = np.einsum("qk,qki->qi", exact.barycentric, corners)
        ranks = [str(i) for i in range(1, len(pairs) + 1)]
        here, there = (
            Landmarks(ranks, numbers, places, name)
            for numbers, places, name in zip(pairs.T, points, self.names, strict=True)
        )
        return here, there

    @property
    def comment(self) -> str:
        """What a file says of itself where it can."""
        return (
            f"mobius-match; {DIRECTION}: number k of the one is number k of the other; "
            "coordinates are those of the mesh files, vertices count from 0"
        )


def confident(result: Correspondence, least: float) -> Correspondence:
    """The matches of at least this confidence.

    Raises
    ------
    SettingsError
        If it is out of range.
    NothingFoundError
        If there is none.
    """
    if not 0 <= least <= 1:
        raise SettingsError(f"the least confidence is {least!r}; give a number from 0 to 1")
    kept = np.flatnonzero(result.confidence >= least)
    if not len(kept):
        highest = result.confidence.max(initial=0.0)
        raise NothingFoundError(f"no match has a confidence of {least} or more; the highest is {highest:.3f}")
    some: dict[str, Any] = {name: getattr(result, name)[kept] for name in ("pairs", "confidence", "kind")}
    points = result.target_points
    given = None if result.given is None else result.given[kept]
    return replace(result, **some, target_points=None if points is None else points[kept], given=given)
