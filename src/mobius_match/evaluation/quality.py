"""How good a dense map looks without knowing the truth: distortion, orientation, coverage, round trip, isometry."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.farthest_points import farthest_points
from ..geometry.geodesics import geodesic_solver
from ..mesh import Mesh
from ..mesh.measure import areas, box_scale, cross_products
from ..mesh.topology import edges_of
from ..results.surface_map import SurfaceMap

LANDMARKS = 20
"""Points that geodesic distances are compared from."""

NEAR = 1.5
"""Edges of the source's mean length, up to which a vertex of the target counts as covered by an image."""


@dataclass(frozen=True, eq=False)
class Quality:
    """What a map does to the source, at each of its n1 vertices and as a whole.

    Parameters
    ----------
    area
        (n1,) float64: by how much areas grow around each vertex, as logarithm to base 2; 0 for none, after both
        surfaces are scaled to the same area. NaN, here and below, where nothing corresponds.
    angle
        (n1,) float64: logarithm to base 2 of how much longer the one axis of a small circle's image is than the other.
    geodesic
        (n1,) float64: mean difference of the geodesic distances to landmarks, on the source and on the target between
        the images, per sqrt(area).
    round_trip
        (n1,) float64: how far from a vertex the way to the target and back ends, per sqrt(area) of the source, in
        space.
    kept
        (m1,) bool: which of the source's faces have an image with the same orientation.
    orientation
        Share of the mapped faces whose image keeps the orientation.
    coverage
        Share of the target's area that lies within 1.5 edges of the image of a source vertex.
    mapped
        Share of the source's vertices that have a counterpart.
    """

    area: np.ndarray
    angle: np.ndarray
    geodesic: np.ndarray
    round_trip: np.ndarray
    kept: np.ndarray
    orientation: float
    coverage: float
    mapped: float

    def summary(self) -> dict[str, float]:
        """Single numbers: medians of the magnitudes at the vertices, and the shares."""
        found = {}
        for name, value in asdict(self).items():
            if np.ndim(value) == 0:
                found[name] = float(value)
            elif name != "kept":
                sizes = np.abs(value[~np.isnan(value)])
                found[name] = float(np.median(sizes)) if len(sizes) else float("nan")
        return found

    def __str__(self) -> str:
        found = self.summary()
        return (
            f"{self.mapped:.1%} of the vertices mapped, {self.orientation:.1%} of their faces keep the orientation, "
            f"{self.coverage:.1%} of the target covered; median distortion: areas x {2 ** found['area']:.2f}, "
            f"circles 1 : {2 ** found['angle']:.2f}, distances by {found['geodesic']:.3f} of sqrt(area), "
            f"the way there and back {found['round_trip']:.4f}"
        )


def quality(surface_map: SurfaceMap) -> Quality:
    """What can be said of a map without ground truth."""
    source, target = surface_map.source, surface_map.target
    mapped, images = surface_map.source_mapped, surface_map.positions
    here, there = _unit(source.vertices, source), _unit(images, target)
    before, after = cross_products(here, source.faces), cross_products(there, source.faces)
    whole = mapped[source.faces].all(axis=1)
    sizes = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        area = np.where(whole, np.log2((sizes[1] + 1e-12) / (sizes[0] + 1e-12)), np.nan)
        angle = np.where(whole, np.log2(_stretch_ratio(here, there, source.faces)), np.nan)
    normals = cross_products(target.vertices / box_scale(target.vertices), target.faces)
    around = normals[surface_map.target_points.faces][source.faces]
    around = around / np.maximum(np.linalg.norm(around, axis=2, keepdims=True), np.finfo(float).tiny)
    kept = whole & (np.einsum("mi,mi->m", np.nan_to_num(after), around.sum(axis=1)) > 0)
    back, found = surface_map.inverse.map_points(surface_map.target_points)
    apart = np.linalg.norm(_unit(back.values(source.vertices), source) - here, axis=1)
    weights = areas(target.vertices, target.faces)
    shares = np.bincount(target.faces.ravel(), np.repeat(weights, 3), len(target.vertices))
    edge = np.linalg.norm(np.diff(here[edges_of(source.faces)], axis=1), axis=2).mean()
    far = (
        cKDTree(there[mapped]).query(_unit(target.vertices, target))[0]
        if mapped.any()
        else np.full(len(shares), np.inf)
    )
    return Quality(
        area=_at_vertices(area, source),
        angle=_at_vertices(angle, source),
        geodesic=geodesic_distortion(surface_map),
        round_trip=np.where(mapped & found, apart, np.nan),
        kept=kept,
        orientation=float(kept.sum() / max(whole.sum(), 1)),
        coverage=float(shares[far <= NEAR * edge].sum() / shares.sum()),
        mapped=float(mapped.mean()),
    )


def isometric_distance(surface_map: SurfaceMap) -> float:
    """How far two surfaces are from isometric under a map between them; free of units, and the same for the inverse.

    The mean difference of geodesic distances between points and between their images, per sqrt(area), of both
    directions. 0 is for isometric surfaces; distances of two poses of one shape differ by a few hundredths.
    """
    both = (geodesic_distortion(surface_map), geodesic_distortion(surface_map.inverse))
    return float(np.mean([np.nanmean(one) for one in both]))


def geodesic_distortion(surface_map: SurfaceMap) -> np.ndarray:
    """Mean difference (n1,) of geodesic distances from landmarks before and after the map, per sqrt(area)."""
    source, target = surface_map.source, surface_map.target
    distances, number = [], int(surface_map.source_mapped.sum())
    from_source = geodesic_solver(_unit(source.vertices, source), source.faces)
    from_target = geodesic_solver(_unit(target.vertices, target), target.faces)
    nearest = np.where(surface_map.source_mapped, np.inf, -np.inf)
    for landmark, mine in farthest_points(from_source, nearest, min(LANDMARKS, number)):
        theirs = surface_map.target_points.values(from_target(int(surface_map.target_points.nearest[landmark])))
        distances.append(np.abs(mine - theirs))
    found = np.mean(distances, axis=0) if distances else np.full(len(source.vertices), np.nan)
    return np.where(surface_map.source_mapped, found, np.nan)


def _unit(points: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Points (p, 3) in units in which the mesh has area 1."""
    return points / (np.sqrt(areas(mesh.vertices, mesh.faces).sum()) * box_scale(mesh.vertices))


def _stretch_ratio(here: np.ndarray, there: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The greater over the smaller stretch of each face (m,), from the first fundamental forms."""
    forms = []
    for points in (here, there):
        one, two = points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
        forms.append([(one * one).sum(axis=1), (one * two).sum(axis=1), (two * two).sum(axis=1)])
    (e, f, g), (a, b, c) = forms
    determinant = np.maximum(e * g - f * f, 1e-30)
    # Eigenvalues of the inverse of the first form times the second: squared stretches.
    trace = (g * a - 2 * f * b + e * c) / determinant
    product = np.maximum(a * c - b * b, 0.0) / determinant
    root = np.sqrt(np.maximum(trace**2 / 4 - product, 0.0))
    low, high = np.maximum(trace / 2 - root, 1e-12), trace / 2 + root
    return np.asarray(np.sqrt(np.maximum(high, 1e-12) / low))


def _at_vertices(of_faces: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Means (n,) over the faces around each vertex, weighted by area, of those that have a value."""
    known = ~np.isnan(of_faces)
    weights = np.where(known, areas(mesh.vertices, mesh.faces) + 1e-30, 0.0)
    corner, size = mesh.faces.ravel(), len(mesh.vertices)
    total = np.bincount(corner, np.repeat(weights * np.where(known, of_faces, 0.0), 3), size)
    number = np.bincount(corner, np.repeat(weights, 3), size)
    return np.divide(total, number, out=np.full(size, np.nan), where=number > 0)
