"""The content of exported files: the matches as landmarks on both shapes, and the dense map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .._core.display import one_line
from ..errors import MeshError, NothingFoundError, SettingsError
from ..landmarks.csv_npz import SIDES
from ..landmarks.tables import Landmarks
from ..mesh import Mesh
from ..results.correspondence import Correspondence
from ..results.surface_map import SurfaceMap
from .result_meshes import mesh_of, vertices_numbered

DIRECTION = "source -> target"


@dataclass(frozen=True, eq=False)
class Content:
    """A result, or a dense map, or both.

    Parameters
    ----------
    result
        The matches; None if only a map is exported.
    dense
        The dense map, or None.

    Raises
    ------
    MeshError
        If the two belong to different meshes.
    """

    result: Correspondence | None
    dense: SurfaceMap | None

    def __repr__(self) -> str:
        return one_line(self)

    def __post_init__(self) -> None:
        if self.result is None or self.dense is None:
            return
        infos, meshes = (self.result.source_info, self.result.target_info), (self.dense.source, self.dense.target)
        if any(info.get("sha256") != mesh.sha256 for info, mesh in zip(infos, meshes, strict=True)):
            raise MeshError("`dense` is a map between other meshes; export the map of this result")

    @property
    def matches(self) -> Correspondence:
        """The matches.

        Raises
        ------
        SettingsError
            If only a map is exported.
        """
        if self.result is None:
            raise SettingsError("this format holds matches, and `result` is a dense map; give the result of a match")
        return self.result

    @property
    def given(self) -> np.ndarray:
        """Which matches are landmarks that the user gave, (Q,) bool."""
        given = self.matches.given
        return np.zeros(len(self.matches), bool) if given is None else given

    @property
    def reflected(self) -> bool:
        """Whether the mirror image of the source was matched."""
        return any(one is not None and one.reflected for one in (self.result, self.dense))

    @property
    def map(self) -> SurfaceMap:
        """The dense map.

        Raises
        ------
        SettingsError
            If there is none.
        """
        if self.dense is None:
            raise SettingsError("this format holds a dense map; give one as `dense`")
        return self.dense

    @cached_property
    def meshes(self) -> tuple[Mesh, Mesh]:
        """Both repaired meshes: of the map, or read from their files if the result was loaded."""
        result = self.result
        # Only the map of a loaded result knows which handles were cut open.
        if result is None or (self.dense is not None and None in (result.source, result.target)):
            return self.map.source, self.map.target
        return mesh_of(result.source, result.source_info), mesh_of(result.target, result.target_info)

    @property
    def names(self) -> list[str]:
        """Names of both mesh files."""
        if self.result is None:
            return [mesh.name for mesh in self.meshes]
        infos = self.result.source_info, self.result.target_info
        return [Path(str(info.get("path") or side)).name for info, side in zip(infos, SIDES, strict=True)]

    @cached_property
    def landmarks(self) -> tuple[Landmarks, Landmarks]:
        """The matches as landmarks on the source and on the target, named by their rank from 1."""
        pairs, target_points = self.matches.pairs, self.matches.target_points
        points = [
            mesh.vertices[vertices_numbered(mesh, numbers)] for mesh, numbers in zip(self.meshes, pairs.T, strict=True)
        ]
        if target_points is not None:
            target = self.meshes[1]
            corners = target.vertices[vertices_numbered(target, target_points.corners.ravel())].reshape(-1, 3, 3)
            points[1] = np.einsum("qk,qki->qi", target_points.barycentric, corners)
        ranks = [str(i) for i in range(1, len(pairs) + 1)]
        on_source, on_target = (
            Landmarks(ranks, numbers, positions, name)
            for numbers, positions, name in zip(pairs.T, points, self.names, strict=True)
        )
        return on_source, on_target

    @property
    def comment(self) -> str:
        """The comment in files whose format has comments."""
        return (
            f"mobius-match; {DIRECTION}: landmark k of the source corresponds to landmark k of the target; "
            "coordinates are those of the mesh files, vertices count from 0"
            + ("; the mirror image of the source was matched" if self.reflected else "")
        )


def with_min_confidence(result: Correspondence, min_confidence: float) -> Correspondence:
    """The matches with at least this confidence.

    Raises
    ------
    SettingsError
        If ``min_confidence`` is not from 0 to 1.
    NothingFoundError
        If no match is left.
    """
    if not 0 <= min_confidence <= 1:
        raise SettingsError(f"`min_confidence` is {min_confidence!r}; give a number from 0 to 1")
    kept = np.flatnonzero(result.confidence >= min_confidence)
    if not len(kept):
        highest = result.confidence.max(initial=0.0)
        raise NothingFoundError(
            f"no match has a confidence of at least {min_confidence}; the highest is {highest:.3f}. Lower "
            "`min_confidence`"
        )
    columns: dict[str, Any] = {name: getattr(result, name)[kept] for name in ("pairs", "confidence", "kind")}
    points = result.target_points
    given = None if result.given is None else result.given[kept]
    return replace(result, **columns, target_points=None if points is None else points[kept], given=given)
