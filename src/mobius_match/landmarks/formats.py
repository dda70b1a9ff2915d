"""The formats of landmarks: read, and written, as a file's name ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .._core.files import write_atomically
from ..errors import FormatError, SettingsError
from .meshlab import read_pp, write_pp
from .morphometrics import read_morphologika, read_pts, read_tps, write_morphologika, write_pts, write_tps
from .rows import read_csv, read_npz, write_csv_marks
from .slicer import check_system, read_fcsv, read_markups, write_fcsv, write_markups
from .tables import Landmarks
from .text import plain, read_text

MarksWriter = Callable[[Sequence[Landmarks], str, str], bytes]


@dataclass(frozen=True)
class LandmarkFormat:
    """How landmarks are read and written.

    Parameters
    ----------
    endings
        Of files that are taken for it; the first is its own.
    read
        Reads the landmarks of all specimens, in a coordinate system.
    marks
        Writes landmarks, of one specimen or (where not ``apart``) of several, with a comment and their system; None
        where only results are written so.
    apart
        Whether each specimen is written to a file of its own.
    """

    endings: tuple[str, ...]
    read: Callable[[Path, str], list[Landmarks]]
    marks: MarksWriter | None = None
    apart: bool = False


def _read_txt(path: Path, wanted: str) -> list[Landmarks]:
    """Morphologika, or a table of coordinates."""
    first = next((row for row in map(str.strip, read_text(path).splitlines()) if row and row[0] not in "'\""), "")
    return (read_morphologika if first.startswith("[") else read_csv)(path, wanted)


LANDMARK_FORMATS = {
    "csv": LandmarkFormat((".csv",), read_csv, write_csv_marks),
    "slicer": LandmarkFormat((".mrk.json", ".json"), read_markups, write_markups, apart=True),
    "fcsv": LandmarkFormat((".fcsv",), read_fcsv, write_fcsv, apart=True),
    "tps": LandmarkFormat((".tps",), read_tps, write_tps),
    "morphologika": LandmarkFormat((".morphologika",), read_morphologika, write_morphologika),
    "pts": LandmarkFormat((".pts",), read_pts, write_pts, apart=True),
    "pp": LandmarkFormat((".pp",), read_pp, write_pp, apart=True),
    "npz": LandmarkFormat((".npz",), read_npz),
    "text": LandmarkFormat((".txt",), _read_txt),
}
"""By name."""


def marks_writer(path: Path) -> MarksWriter:
    """What makes the content of a file of landmarks: called with specimens, a comment, and their coordinate system.

    Raises
    ------
    SettingsError
        If its name does not end as that of a format of landmarks.
    """
    known = {ending: one.marks for one in LANDMARK_FORMATS.values() if one.marks for ending in one.endings}
    ending = ending_of(path, known)
    if not ending:
        raise SettingsError(f"{path}: unknown ending; landmarks are written as {', '.join(known)}")
    return known[ending]


def write_landmarks(
    landmarks: Landmarks, path: str | os.PathLike[str], *, comment: str = "", coordinate_system: str = "LPS"
) -> None:
    """Write landmarks in any format that :func:`read_landmarks` reads, but .npz and .txt.

    An existing file is replaced at once or not at all.

    Parameters
    ----------
    landmarks
        Landmarks with points, in the units of their mesh. Without names they are numbered from 1.
    path
        The file; the ending of its name says the format.
    comment
        A line for the formats that hold one.
    coordinate_system
        ``"LPS"`` or ``"RAS"``: what the coordinates are, for the formats that say so. Nothing is converted.

    Raises
    ------
    SettingsError
        If the ending is that of no format, or there are no points.
    """
    path = Path(path)
    check_system(coordinate_system)
    write = marks_writer(path)
    if landmarks.points is None:
        raise SettingsError(f"{path}: the landmarks have vertex numbers but no points; add the positions")
    named = replace(landmarks, names=landmarks.names or [str(k) for k in range(1, len(landmarks) + 1)])
    write_atomically(path, write([named], comment, coordinate_system))


def read_landmarks(
    path: str | os.PathLike[str], specimen: str | int | None = None, *, coordinate_system: str = "LPS"
) -> Landmarks:
    """Read landmarks: Slicer's Markups and .fcsv, TPS, Morphologika, .pts, .pp, CSV, matches written as CSV or .npz.

    Parameters
    ----------
    path
        A file; how its name ends tells the format.
    specimen
        Of a file with several: the name, or the number from 0. What was written of a match has the source and the
        target.
    coordinate_system
        ``"LPS"`` or ``"RAS"``: what the coordinates are to be in. Files that say that theirs are of the other are
        converted (x and y change sign); of all others they are taken as they are.

    Returns
    -------
    Landmarks
        ``names`` (list), ``points`` (k, 3) float64, NaN where a landmark is missing, and ``specimen``. From a CSV file
        with a column ``vertex``, ``vertices`` (k,) counting from 0; without coordinates in it ``points`` is None.

    Raises
    ------
    FormatError
        If the file is none of these or malformed; the message names the line.
    SettingsError
        If there are several specimens and none was chosen, or none is called so.
    """
    path = Path(path)
    found = read_specimens(path, coordinate_system)
    listed = ", ".join(f"{number} {one.specimen}".strip() for number, one in enumerate(found))
    if specimen is None:
        if len(found) == 1:
            return found[0]
        raise SettingsError(f"{path}: holds {len(found)} specimens ({listed}); choose one by name or number")
    named = [one for number, one in enumerate(found) if specimen in (number, str(number), one.specimen)]
    exact = [one for one in named if one.specimen == specimen] or named
    if len(exact) != 1:
        many = "several specimens are" if exact else "no specimen is"
        raise SettingsError(f"{path}: {many} called {specimen!r}; there are {listed}")
    return exact[0]


def read_specimens(path: Path, coordinate_system: str = "LPS") -> list[Landmarks]:
    """All that :func:`read_landmarks` can choose from."""
    check_system(coordinate_system)
    known = {ending: one.read for one in LANDMARK_FORMATS.values() for ending in one.endings}
    ending = ending_of(path, known)
    if not ending:
        raise FormatError(f"{path}: unknown ending; landmarks are read from {', '.join(known)}")
    found = [one for one in known[ending](path, coordinate_system) if len(one)]
    if not found:
        raise FormatError(f"{path}: holds no landmarks")
    for one in found:
        if one.points is not None and np.isinf(one.points).any():
            raise FormatError(f"{path}: has a coordinate that is not a finite number")
    return [
        replace(
            one,
            names=[plain(name) or str(k) for k, name in enumerate(one.names or [""] * len(one), 1)],
            specimen=plain(one.specimen),
        )
        for one in found
    ]


def ending_of(path: Path, known: Collection[str]) -> str:
    """The longest known ending that the name has, or nothing."""
    return max((ending for ending in known if path.name.lower().endswith(ending)), key=len, default="")
