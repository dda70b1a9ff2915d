"""The dense map of all pieces: those that are matched, and the others, which ride along with what they lie next to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._core.display import one_line
from ...geometry.moving_least_squares import carried, similarity
from ...geometry.points import SurfacePoints, closest_points
from ...mesh import Mesh
from ...mesh.measure import areas, unit_box
from ...mesh.topology import components
from ...results.surface_map import SurfaceMap
from ...surface.sampling import proxy_points
from .parameters import PiecesParameters

NOWHERE = np.zeros(0, np.int64)


@dataclass(frozen=True, eq=False)
class PieceMap:
    """The dense map between a piece of the source and one of the target.

    Parameters
    ----------
    dense
        The map between the two pieces.
    source, target
        Vertices and faces of the two pieces, as numbers in the meshes of all pieces: two arrays each.
    """

    dense: SurfaceMap
    source: tuple[np.ndarray, np.ndarray]
    target: tuple[np.ndarray, np.ndarray]

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def inverse(self) -> PieceMap:
        """The map from the target's piece to the source's."""
        return PieceMap(self.dense.inverse, self.target, self.source)


def map_of_all_pieces(
    source: Mesh, target: Mesh, maps: list[PieceMap], parameters: PiecesParameters, controls: int
) -> SurfaceMap:
    """The map between all pieces of two meshes.

    Parameters
    ----------
    source, target
        The meshes of all pieces.
    maps
        The dense maps of the pieces that are matched.
    parameters
        The constants.
    controls
        Number of points of the matched pieces whose images say where the other pieces go.

    Returns
    -------
    SurfaceMap
        A vertex of a piece that is not matched has the image of the nearest point of the matched pieces, and is carried
        along with these.
    """
    back = [one.inverse for one in maps]
    target_points, source_mapped = _collected(source, target, maps)
    source_points, target_mapped = _collected(target, source, back)
    matched = SurfaceMap(source, target, target_points, source_points, source_mapped, target_mapped)
    points, mapped, positions = _with_riders(matched, maps, parameters, controls)
    back_points, back_mapped, back_positions = _with_riders(matched.inverse, back, parameters, controls)
    return SurfaceMap(source, target, points, back_points, mapped, back_mapped, positions, back_positions)


def _collected(source: Mesh, target: Mesh, maps: list[PieceMap]) -> tuple[SurfacePoints, np.ndarray]:
    """The images of all vertices of the source by the maps of its pieces, and which have one."""
    size = len(source.vertices)
    faces, barycentric = np.zeros(size, np.int64), np.tile([1.0, 0.0, 0.0], (size, 1))
    mapped = np.zeros(size, bool)
    for one in maps:
        here = one.source[0]
        points = one.dense.target_points[np.arange(len(here))]
        faces[here], barycentric[here] = one.target[1][points.faces], points.barycentric
        mapped[here] = one.dense.source_mapped[: len(here)]
    return SurfacePoints(faces, target.faces[faces], barycentric), mapped


def _with_riders(
    matched: SurfaceMap, maps: list[PieceMap], parameters: PiecesParameters, controls: int
) -> tuple[SurfacePoints, np.ndarray, np.ndarray | None]:
    """Images, which vertices have one, and carried positions, once the other pieces ride along with those matched."""
    source, points, mapped = matched.source, matched.target_points, matched.source_mapped
    on_pieces = np.zeros(len(source.vertices), bool)
    on_pieces[np.concatenate([one.source[0] for one in maps])] = True
    riders = np.flatnonzero(~on_pieces)
    if not len(riders):
        return points, mapped, None
    anchors = _nearest_points(source, np.concatenate([one.source[1] for one in maps]), riders)
    images, found = matched.map_points(anchors)
    points = points.replaced(riders, images)
    mapped = mapped.copy()
    mapped[riders] = found
    positions = np.full((len(on_pieces), 3), np.nan)
    positions[riders] = _carried(
        matched, anchors, images, riders, on_pieces & matched.source_mapped, parameters, controls
    )
    positions[~mapped] = np.nan
    return points, mapped, positions


def _carried(
    matched: SurfaceMap,
    anchors: SurfacePoints,
    images: SurfacePoints,
    riders: np.ndarray,
    known: np.ndarray,
    parameters: PiecesParameters,
    n_controls: int,
) -> np.ndarray:
    """Positions (q, 3) beside the target of vertices (q,) beside the source's matched pieces."""
    source, target = matched.source, matched.target
    weights = np.bincount(
        source.faces.ravel(), np.repeat(areas(source.vertices, source.faces), 3), len(source.vertices)
    )
    vertices = np.flatnonzero(known & (weights > 0))
    if not len(vertices):
        return np.full((len(riders), 3), np.nan)
    controls = vertices[proxy_points(weights[vertices], n_controls, NOWHERE)]
    rest = source.vertices[riders]
    positions = carried(
        rest,
        source.vertices[controls],
        matched.target_points[controls].values(target.vertices),
        anchors.values(source.vertices),
        images.values(target.vertices),
    )
    # A piece that nearly keeps its shape is solid: an eye must not take on the roughness of the map around it.
    label = np.full(len(source.vertices), -1, np.int64)
    label[source.faces.ravel()] = np.repeat(components(source.faces)[1], 3)
    for rows in _groups(label[riders]):
        rigid = similarity(rest[rows], positions[rows])
        size = np.linalg.norm(rigid - rigid.mean(axis=0), axis=1).mean()
        if np.linalg.norm(rigid - positions[rows], axis=1).mean() <= parameters.solid * size:
            positions[rows] = rigid
    return positions


def _groups(labels: np.ndarray) -> list[np.ndarray]:
    """The indices of each distinct label."""
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)


def _nearest_points(mesh: Mesh, faces: np.ndarray, vertices: np.ndarray) -> SurfacePoints:
    """The closest points (q,) of some faces of a mesh to vertices (q,)."""
    import igl

    unit, some = unit_box(mesh.vertices), np.ascontiguousarray(mesh.faces[faces])
    near = np.asarray(igl.point_mesh_squared_distance(unit[vertices], unit, some)[1]).reshape(-1)
    points = closest_points(unit, some, unit[vertices], some[near, 0])
    return SurfacePoints(faces[points.faces], points.corners, points.barycentric)
