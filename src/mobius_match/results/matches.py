"""Lists of matches: under one alignment, as rows of a result file, and as columns of a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..errors import MissingPackageError
from ..geometry.points import SurfacePoints

POINT_FIELDS = ("face", "vertices", "barycentric")
"""The parts of a target point in the file, in the order of :class:`SurfacePoints`."""


class Matches(Protocol):
    """What a :class:`Correspondence` and an :class:`Alternative` have in common."""

    @property
    def pairs(self) -> np.ndarray:
        """(Q, 2) int64 vertices of source and target."""

    @property
    def confidence(self) -> np.ndarray:
        """(Q,) float64."""

    @property
    def kind(self) -> np.ndarray:
        """(Q,) str."""

    @property
    def target_points(self) -> SurfacePoints | None:
        """(Q,) points of the target."""

    @property
    def given(self) -> np.ndarray | None:
        """(Q,) bool."""


@dataclass(frozen=True, eq=False)
class Alternative:
    """The matches under another alignment of the same two surfaces.

    Parameters
    ----------
    pairs, confidence, kind
        As in :class:`Correspondence`.
    margin
        The cost of this alignment minus the cost of the chosen one, without unit; negative where the evidence was for
        the one of higher cost.
    share
        The share of the best triplets, 0 to 1, that agree with this alignment.
    probability
        That this alignment is the right one; 0 if it was ruled out by its cost. NaN in files that have none.
    target_points, given
        As in :class:`Correspondence`.
    """

    pairs: np.ndarray
    confidence: np.ndarray
    kind: np.ndarray
    margin: float
    share: float
    probability: float = float("nan")
    target_points: SurfacePoints | None = None
    given: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.pairs)

    def __repr__(self) -> str:
        return f"<Alternative: {len(self)} pairs, probability {self.probability:.2f}>"


def to_rows(matches: Matches) -> list[dict[str, Any]]:
    """The matches as they stand in the result file."""
    rows: list[dict[str, Any]] = [
        {"source": i, "target": j, "confidence": confidence, "kind": kind}
        for (i, j), confidence, kind in zip(
            matches.pairs.tolist(), matches.confidence.tolist(), matches.kind.tolist(), strict=True
        )
    ]
    points = matches.target_points
    if points is not None:
        values = zip(points.faces.tolist(), points.corners.tolist(), points.barycentric.tolist(), strict=True)
        for row, value in zip(rows, values, strict=True):
            row["target_point"] = dict(zip(POINT_FIELDS, value, strict=True))
    for place in [] if matches.given is None else np.flatnonzero(matches.given):
        rows[place]["given"] = True
    return rows


def from_rows(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The fields of :class:`Matches`, from rows of a result file."""
    given = np.array([bool(row.get("given")) for row in rows], bool)
    return {
        "pairs": np.array([(row["source"], row["target"]) for row in rows], np.int64).reshape(-1, 2),
        "confidence": np.array([row["confidence"] for row in rows], np.float64),
        "kind": np.array([row["kind"] for row in rows], dtype="<U9"),
        "target_points": _points(rows),
        "given": given if given.any() else None,
    }


def to_columns(matches: Matches) -> dict[str, np.ndarray]:
    """The matches as columns of a table, (Q,) each."""
    columns = {
        "source": matches.pairs[:, 0],
        "target": matches.pairs[:, 1],
        "confidence": matches.confidence,
        "kind": matches.kind,
        "given": np.zeros(len(matches.pairs), bool) if matches.given is None else matches.given,
    }
    points = matches.target_points
    if points is not None:
        columns["target_face"] = points.faces
        columns |= {f"target_vertex_{k}": points.corners[:, k] for k in range(3)}
        columns |= {f"barycentric_{k}": points.barycentric[:, k] for k in range(3)}
    return columns


def data_frame(columns: dict[str, np.ndarray]) -> Any:
    """A pandas data frame of columns.

    Raises
    ------
    MissingPackageError
        If pandas is not installed.
    """
    try:
        import pandas
    except ImportError as error:
        raise MissingPackageError("to_dataframe needs pandas: pip install pandas") from error
    return pandas.DataFrame(columns)


def _points(rows: list[dict[str, Any]]) -> SurfacePoints | None:
    if not rows or "target_point" not in rows[0]:
        return None
    faces, corners, barycentric = ([row["target_point"][name] for row in rows] for name in POINT_FIELDS)
    return SurfacePoints(
        np.array(faces, np.int64).reshape(len(rows)),
        np.array(corners, np.int64).reshape(len(rows), 3),
        np.array(barycentric, np.float64).reshape(len(rows), 3),
    )
