"""The formats of landmark files, which are chosen by the ending of the file name."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .._core.files import write_atomically
from ..errors import FormatError, SettingsError
from .csv_npz import read_csv, read_npz, write_csv_landmarks
from .meshlab import read_pp, write_pp
from .morphometrics import read_morphologika, read_pts, read_tps, write_morphologika, write_pts, write_tps
from .slicer import check_system, read_fcsv, read_markups, write_fcsv, write_markups
from .tables import Landmarks
from .text import plain, read_text

LandmarkWriter = Callable[[Sequence[Landmarks], str, str], bytes]


@dataclass(frozen=True)
class LandmarkFormat:
    """How a format is read and written.

    Parameters
    ----------
    endings
        Endings of file names; the first is the usual one.
    read
        Reads the landmarks of all specimens from a path, in a coordinate system.
    write
        Makes the content of a file from landmarks, a comment and their coordinate system; None where landmarks alone
        are not written in this format.
    single
        Whether a file holds one specimen only.
    """

    endings: tuple[str, ...]
    read: Callable[[Path, str], list[Landmarks]]
    write: LandmarkWriter | None = None
    single: bool = False


def _read_txt(path: Path, coordinate_system: str) -> list[Landmarks]:
    """Morphologika, or a table of coordinates."""
    first = next((row for row in map(str.strip, read_text(path).splitlines()) if row and row[0] not in "'\""), "")
    return (read_morphologika if first.startswith("[") else read_csv)(path, coordinate_system)


LANDMARK_FORMATS = {
    "csv": LandmarkFormat((".csv",), read_csv, write_csv_landmarks),
    "slicer": LandmarkFormat((".mrk.json", ".json"), read_markups, write_markups, single=True),
    "fcsv": LandmarkFormat((".fcsv",), read_fcsv, write_fcsv, single=True),
    "tps": LandmarkFormat((".tps",), read_tps, write_tps),
    "morphologika": LandmarkFormat((".morphologika",), read_morphologika, write_morphologika),
    "pts": LandmarkFormat((".pts",), read_pts, write_pts, single=True),
    "pp": LandmarkFormat((".pp",), read_pp, write_pp, single=True),
    "npz": LandmarkFormat((".npz",), read_npz),
    "text": LandmarkFormat((".txt",), _read_txt),
}
"""By name."""


def landmark_writer(path: Path) -> LandmarkWriter:
    """The function that makes the content of a landmark file, from specimens, a comment and their coordinate system.

    Raises
    ------
    SettingsError
        If the ending of the name is not that of a format in which landmarks are written.
    """
    known = {ending: form.write for form in LANDMARK_FORMATS.values() if form.write for ending in form.endings}
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
    write = landmark_writer(path)
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
        A file; the ending of its name determines the format.
    specimen
        Which specimen of a file with several: its name, or its number from 0. A file of matches has two, the source
        and the target.
    coordinate_system
        ``"LPS"`` or ``"RAS"``, the system of the returned coordinates. Files that record the other one are converted
        (x and y change sign); files that record none are not changed.

    Returns
    -------
    Landmarks
        ``names`` (list), ``points`` (k, 3) float64 in the units of the file, NaN where a landmark is missing, and
        ``specimen``. From a CSV file with a column ``vertex``, also ``vertices`` (k,) counting from 0; ``points`` is
        None if it has no coordinates.

    Raises
    ------
    FormatError
        If the format is unknown or the file malformed; the message names the line.
    SettingsError
        If the file has several specimens and ``specimen`` names none or more than one of them.
    """
    path = Path(path)
    specimens = read_specimens(path, coordinate_system)
    listed = ", ".join(f"{number} {landmarks.specimen}".strip() for number, landmarks in enumerate(specimens))
    if specimen is None:
        if len(specimens) == 1:
            return specimens[0]
        raise SettingsError(
            f"{path}: holds {len(specimens)} specimens ({listed}); choose one by name or number with `specimen`"
        )
    chosen = [
        landmarks for number, landmarks in enumerate(specimens) if specimen in (number, str(number), landmarks.specimen)
    ]
    chosen = [landmarks for landmarks in chosen if landmarks.specimen == specimen] or chosen
    if len(chosen) != 1:
        matching = "several specimens match" if chosen else "no specimen matches"
        raise SettingsError(f"{path}: {matching} `specimen` {specimen!r}; there are {listed}")
    return chosen[0]


def read_specimens(path: Path, coordinate_system: str = "LPS") -> list[Landmarks]:
    """The landmarks of all specimens of a file; see :func:`read_landmarks`."""
    check_system(coordinate_system)
    known = {ending: form.read for form in LANDMARK_FORMATS.values() for ending in form.endings}
    ending = ending_of(path, known)
    if not ending:
        raise FormatError(f"{path}: unknown ending; landmarks are read from {', '.join(known)}")
    specimens = [landmarks for landmarks in known[ending](path, coordinate_system) if len(landmarks)]
    if not specimens:
        raise FormatError(f"{path}: holds no landmarks")
    for landmarks in specimens:
        if landmarks.points is not None and np.isinf(landmarks.points).any():
            raise FormatError(f"{path}: has a coordinate that is not a finite number")
    return [
        replace(
            landmarks,
            names=[plain(name) or str(k) for k, name in enumerate(landmarks.names or [""] * len(landmarks), 1)],
            specimen=plain(landmarks.specimen),
        )
        for landmarks in specimens
    ]


def ending_of(path: Path, known: Collection[str]) -> str:
    """The longest known ending that the name has, or an empty text."""
    return max((ending for ending in known if path.name.lower().endswith(ending)), key=len, default="")
