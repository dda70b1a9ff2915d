"""Landmarks in CSV tables, and the matches in files that ``export`` has written as CSV or .npz."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import FormatError
from .tables import Landmarks, numbers, read_table, split_rows
from .text import read_text

SIDES = ("source", "target")
COORDINATE_COLUMNS = [f"{side}_{axis}" for side in SIDES for axis in "xyz"]


def write_csv_landmarks(specimens: Sequence[Landmarks], comment: str, coordinate_system: str) -> bytes:
    """One specimen: name, vertex (from 0), x, y, z."""
    (landmarks,) = specimens
    return landmarks.text()


def read_csv(path: Path, coordinate_system: str) -> list[Landmarks]:
    """Landmarks in columns ``x, y, z`` or ``vertex``, or those of both shapes in a table of matches."""
    heads, rows = split_rows(path, read_text(path))
    if not set(COORDINATE_COLUMNS) <= set(heads):
        table = read_table(path)
        if isinstance(table, Landmarks):
            return [table]
        raise FormatError(f"{path}: has no columns x, y, z, nor vertex; its first line must name the columns")
    names = [row[heads.index("name")] for _, row in rows] if "name" in heads else []
    points = numbers(path, rows, [heads.index(name) for name in COORDINATE_COLUMNS]).astype(np.float64)
    return [Landmarks(names, None, points[:, 3 * k : 3 * k + 3], side) for k, side in enumerate(SIDES)]


def read_npz(path: Path, coordinate_system: str) -> list[Landmarks]:
    """The matches in a file that ``export`` has written, as landmarks of the source and of the target."""
    try:
        with np.load(path, allow_pickle=False) as file:
            points = [np.asarray(file[f"{side}_points"], np.float64) for side in SIDES]
            specimens = [str(file[f"{side}_name"]) for side in SIDES]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise FormatError(f"{path}: not an .npz file of exported matches ({error})") from error
    if any(array.ndim != 2 or array.shape[1:] != (3,) for array in points):
        raise FormatError(f"{path}: its points do not have three coordinates each")
    return [Landmarks([], None, array, name) for array, name in zip(points, specimens, strict=True)]
