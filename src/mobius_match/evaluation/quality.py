"""Quality of a dense map without ground truth: distortion, orientation, coverage, round trip, isometry."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from .._core.display import html_table
from ..geometry.farthest_points import farthest_points
from ..geometry.geodesics import geodesic_solver
from ..mesh import Mesh
from ..mesh.measure import areas, box_scale, cross_products
from ..mesh.topology import edges_of
from ..results.main_map import main_map
from ..results.surface_map import SurfaceMap

LANDMARKS = 20
"""Points that geodesic distances are compared from."""

NEAR = 1.5
"""Edges of the source's mean length, up to which a vertex of the target counts as covered by an image."""


@dataclass(frozen=True, eq=False)
class Quality:
    """The distortion of a map at each of the source's n1 vertices, and how complete the map is.

    Parameters
    ----------
    area
        (n1,) float64: growth of areas around each vertex, as logarithm to base 2, after both surfaces are scaled to the
        same area; 0 is none. NaN, here and below, without a counterpart.
    angle
        (n1,) float64: anisotropy, as logarithm to base 2 of the ratio of the axes of the ellipse that a small circle is
        mapped to; 0 is conformal.
    geodesic
        (n1,) float64: mean difference between the geodesic distances to 20 landmarks on the source and those between
        their images on the target, per sqrt(area).
    round_trip
        (n1,) float64: distance in space between a vertex and the image of its image under the inverse map, per
        sqrt(area) of the source.
    kept
        (m1,) bool: which of the source's faces have an image with the same orientation; with the opposite one, where
        the map is reflected.
    orientation
        Share of the mapped faces that are kept so.
    coverage
        Share of the target's area within 1.5 mean edge lengths of the image of a source vertex.
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
        """The quality in single numbers.

        Returns
        -------
        dict
            Under the names of the fields: medians of the absolute values at the vertices, and the shares.
        """
        found = {}
        for name, value in asdict(self).items():
            if np.ndim(value) == 0:
                found[name] = float(value)
            elif name != "kept":
                sizes = np.abs(value[~np.isnan(value)])
                found[name] = float(np.median(sizes)) if len(sizes) else float("nan")
        return found

    def __repr__(self) -> str:
        return (
            f"<Quality at {len(self.area)} vertices: mapped {self.mapped:.3f}, orientation {self.orientation:.3f}, "
            f"coverage {self.coverage:.3f}>"
        )

    def __str__(self) -> str:
        found = self.summary()
        return (
            f"{self.mapped:.1%} of the vertices mapped, {self.orientation:.1%} of their faces keep the orientation, "
            f"{self.coverage:.1%} of the target covered; median distortion: area x{2 ** found['area']:.2f}, "
            f"anisotropy {2 ** found['angle']:.2f}, distance {found['geodesic']:.3f} sqrt(area), "
            f"round trip {found['round_trip']:.4f} sqrt(area)"
        )

    def _repr_html_(self) -> str:
        found = self.summary()
        rows = [
            ("vertices mapped", f"{self.mapped:.1%}"),
            ("faces with the same orientation", f"{self.orientation:.1%}"),
            ("target covered", f"{self.coverage:.1%}"),
            ("area, median factor", f"{2 ** found['area']:.2f}"),
            ("anisotropy, median", f"{2 ** found['angle']:.2f}"),
            ("distance, median per sqrt(area)", f"{found['geodesic']:.3f}"),
            ("round trip, median per sqrt(area)", f"{found['round_trip']:.4f}"),
        ]
        return html_table("Quality of the map", (), rows)


def quality(surface_map: SurfaceMap) -> Quality:
    """Measure the distortion and completeness of a map, without ground truth.

    Parameters
    ----------
    surface_map
        A dense map, ``result.dense()``.

    Returns
    -------
    Quality
        Values at the vertices of the repaired source, and shares. Of several pieces only the main one has values.

    Examples
    --------
    >>> import mobius_match as mm
    >>> dense = mm.match(*mm.examples.paths("person"), seed=0).dense()
    >>> mm.quality(dense).orientation > 0.95
    True
    """
    main, vertices, faces = main_map(surface_map)
    if main is not surface_map:
        return _padded(quality(main), vertices, faces, float(surface_map.source_mapped.mean()))
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
    same = np.einsum("mi,mi->m", np.nan_to_num(after), around.sum(axis=1))
    kept = whole & ((-same if surface_map.reflected else same) > 0)
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


def _padded(of_piece: Quality, vertices: np.ndarray, faces: np.ndarray, mapped: float) -> Quality:
    """The quality of the map of one piece, with no values at all other vertices (n,) and faces (m,)."""
    area, angle, geodesic, round_trip = (np.full(len(vertices), np.nan) for _ in range(4))
    area[vertices], angle[vertices] = of_piece.area, of_piece.angle
    geodesic[vertices], round_trip[vertices] = of_piece.geodesic, of_piece.round_trip
    kept = np.zeros(len(faces), bool)
    kept[faces] = of_piece.kept
    return replace(of_piece, area=area, angle=angle, geodesic=geodesic, round_trip=round_trip, kept=kept, mapped=mapped)


def isometric_distance(surface_map: SurfaceMap) -> float:
    """How far two surfaces are from isometric, under a map between them.

    The mean difference between geodesic distances of points and of their images, per sqrt(area), over both directions.
    It is the same for the inverse map.

    Parameters
    ----------
    surface_map
        A dense map, ``result.dense()``.

    Returns
    -------
    float
        Without unit: 0 for isometric surfaces, a few hundredths for two poses of one shape.
    """
    both = (geodesic_distortion(surface_map), geodesic_distortion(surface_map.inverse))
    return float(np.mean([np.nanmean(one) for one in both]))


def geodesic_distortion(surface_map: SurfaceMap) -> np.ndarray:
    """Mean difference (n1,) of geodesic distances from landmarks before and after the map, per sqrt(area)."""
    main, vertices, _ = main_map(surface_map)
    if main is not surface_map:
        padded = np.full(len(vertices), np.nan)
        padded[vertices] = geodesic_distortion(main)
        return padded
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
