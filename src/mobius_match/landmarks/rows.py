"""Landmarks in CSV tables, and those of a match that was written as CSV or .npz."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import FormatError
from .tables import Landmarks, numbers, read_table, split_rows
from .text import read_text

SIDES = ("source", "target")
PLACES = [f"{side}_{axis}" for side in SIDES for axis in "xyz"]


def write_csv_marks(specimens: Sequence[Landmarks], comment: str, system: str) -> bytes:
    """One specimen: name, vertex (from 0), x, y, z."""
    (marks,) = specimens
    return marks.text()


def read_csv(path: Path, wanted: str) -> list[Landmarks]:
    """Landmarks in columns ``x, y, z`` (or ``vertex``), or both shapes' as :func:`write_csv` has them."""
    heads, rows = split_rows(path, read_text(path))
    if not set(PLACES) <= set(heads):
        table = read_table(path)
        if isinstance(table, Landmarks):
            return [table]
        raise FormatError(f"{path}: has no columns x, y, z, nor vertex; name them in its first line")
    names = [row[heads.index("name")] for _, row in rows] if "name" in heads else []
    places = numbers(path, rows, [heads.index(name) for name in PLACES]).astype(np.float64)
    return [Landmarks(names, None, places[:, 3 * k : 3 * k + 3], side) for k, side in enumerate(SIDES)]


def read_npz(path: Path, wanted: str) -> list[Landmarks]:
    """The matches that :func:`write_npz` wrote, as landmarks of the source and of the target."""
    try:
        with np.load(path, allow_pickle=False) as file:
            places = [np.asarray(file[f"{side}_points"], np.float64) for side in SIDES]
            found = [str(file[f"{side}_name"]) for side in SIDES]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise FormatError(f"{path}: not an .npz file of mobius convert with matches ({error})") from error
    if any(array.ndim != 2 or array.shape[1:] != (3,) for array in places):
        raise FormatError(f"{path}: its points are not rows of three coordinates")
    return [Landmarks([], None, array, name) for array, name in zip(places, found, strict=True)]
