"""The constants of preparation, sections 4 and 5 and the descriptors; docs/method.md has the formulas."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.parameters import AREA, HAND, parameter


@dataclass(frozen=True)
class SurfaceParameters:
    """How a mesh is made ready for matching."""

    simplification_ratio: float = parameter(
        1.5, "meshes of more vertices than this times the resolution are simplified", origin=HAND
    )
    sampling_smoothing: float = parameter(
        0.02, "width to which Gauss curvature is smoothed before its maxima are sought", unit=AREA, origin=HAND
    )
    least_straightness: float = parameter(
        0.5,
        "ratio of a distance by the heat method to the straight line below which shortest paths along edges are taken",
        origin="half of what is possible; on 26 meshes of eight sets the least ratio was 0.82, and 0.13 to 0.27 on "
        "three with a fan of long thin faces",
    )
    maximum_radius: float = parameter(
        0.05, "radius of the geodesic disc that a maximum of curvature is the largest of", unit=AREA, origin=HAND
    )
    proxy_size: int = parameter(1200, "vertices that stand for the surface", origin="time: its square enters the maps")
    eigenfunctions: int = parameter(50, "eigenfunctions of the Laplacian", origin=HAND)
    curvature_radius: float = parameter(
        0.035, "width to which curvatures are smoothed for comparison", unit=AREA, origin=HAND
    )
    wide_curvature_radius: float = parameter(
        0.1, "width to which the mean curvature of the cost is smoothed", unit=AREA, origin=HAND
    )
    curvature_gain: float = parameter(
        2.0, "curvatures in standard deviations are multiplied by this before asinh", origin=HAND
    )
    descriptor_step: int = parameter(
        8, "every so many-th energy describes all vertices, from half the step on", origin=HAND
    )
