"""The table of formats, and what users call: a match written in any of them, and landmarks read back."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ..correspondence import Correspondence, write_atomically
from ..dense.surface_map import SurfaceMap
from ..dense.tables import Landmarks
from ..errors import FormatError, SettingsError
from .content import SIDES, Content, confident
from .meshes import write_mesh
from .meshlab import read_pp, write_pp
from .morphometrics import (
    read_morphologika,
    read_pts,
    read_tps,
    write_morphologika,
    write_pts,
    write_tps,
)
from .slicer import check_system, read_fcsv, read_markups, write_fcsv, write_markups
from .tables import read_csv, read_npz, write_csv, write_csv_marks, write_mat, write_npz, write_text
from .words import plain, read_text

MarksWriter = Callable[[Sequence[Landmarks], str, str], bytes]


@dataclass(frozen=True)
class Format:
    """How something is written and read.

    Parameters
    ----------
    endings
        Of files that are taken for it; the first is its own.
    apart
        Whether source and target are written to a file each.
    marks
        Writes landmarks, of one specimen or (where not ``apart``) of several, with a comment and their system.
    whole
        Writes a match, where that is more than landmarks.
    mesh
        Writes one side of a match.
    read
        Reads the landmarks of all specimens, in a system.
    """

    endings: tuple[str, ...]
    apart: bool = False
    marks: MarksWriter | None = None
    whole: Callable[[Content], bytes] | None = None
    mesh: Callable[[Content, int], bytes] | None = None
    read: Callable[[Path, str], list[Landmarks]] | None = None


def _read_txt(path: Path, wanted: str) -> list[Landmarks]:
    """Morphologika, or a table of coordinates."""
    first = next((row for row in map(str.strip, read_text(path).splitlines()) if row and row[0] not in "'\""), "")
    return (read_morphologika if first.startswith("[") else read_csv)(path, wanted)


FORMATS = {
    "csv": Format((".csv",), marks=write_csv_marks, whole=write_csv, read=read_csv),
    "slicer": Format((".mrk.json", ".json"), apart=True, marks=write_markups, read=read_markups),
    "fcsv": Format((".fcsv",), apart=True, marks=write_fcsv, read=read_fcsv),
    "tps": Format((".tps",), marks=write_tps, read=read_tps),
    "morphologika": Format((".morphologika",), marks=write_morphologika, read=read_morphologika),
    "pts": Format((".pts",), apart=True, marks=write_pts, read=read_pts),
    "pp": Format((".pp",), apart=True, marks=write_pp, read=read_pp),
    "ply": Format((".ply",), apart=True, mesh=partial(write_mesh, ending=".ply")),
    "glb": Format((".glb",), apart=True, mesh=partial(write_mesh, ending=".glb")),
    "npz": Format((".npz",), whole=write_npz, read=read_npz),
    "mat": Format((".mat",), whole=write_mat),
    "text": Format((".txt",), whole=write_text, read=_read_txt),
}
"""By name."""


def export(
    result: Correspondence | SurfaceMap,
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    side: str | None = None,
    min_confidence: float = 0.0,
    dense: SurfaceMap | None = None,
    coordinate_system: str = "LPS",
) -> list[Path]:
    """Write matches, or a dense map, for other programs; docs/formats.md tells what each format holds.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`, or a dense map alone. The meshes of a loaded result are read again.
    path
        Where to write. Formats that hold one shape write two files, with ``-source`` and ``-target`` in their names.
    format
        One of ``csv, slicer, fcsv, tps, morphologika, pts, pp, ply, glb, npz, mat, text``; by default as the name ends.
    side
        ``"source"`` or ``"target"``: only this shape, to just this path.
    min_confidence
        Matches of less are left out.
    dense
        The dense map, for formats that hold one, and to carry the colours of meshes.
    coordinate_system
        ``"LPS"`` or ``"RAS"``: what the meshes' coordinates are, for the formats that say so. Nothing is converted.

    Returns
    -------
    list of Path
        The files that were written, each as a whole or not at all.

    Raises
    ------
    SettingsError
        For an unknown format or ending, or what the format cannot hold.
    NothingFoundError
        If no match is confident enough.
    MeshError
        If a mesh is missing or has changed since the match.
    """
    path = Path(path)
    chosen = _chosen(path, format)
    check_system(coordinate_system)
    if side is not None:
        _check_choice("side", side, SIDES)
    if isinstance(result, SurfaceMap):
        content = Content(None, dense or result)
    else:
        content = Content(confident(result, min_confidence), dense)
    those = range(2) if side is None else [SIDES.index(side)]
    if chosen.whole is not None and side is None:
        files = {path: chosen.whole(content)}
    elif chosen.mesh is not None:
        files = {name: chosen.mesh(content, k) for name, k in zip(outputs_of(path, format, side), those, strict=True)}
    elif chosen.marks is not None:
        names = outputs_of(path, format, side)
        groups = [[content.marks[k]] for k in those] if chosen.apart else [[content.marks[k] for k in those]]
        files = {
            name: chosen.marks(marks, content.comment, coordinate_system)
            for name, marks in zip(names, groups, strict=True)
        }
    else:
        raise SettingsError(f"{path}: this format holds both shapes together; leave the side out")
    for name, data in files.items():
        write_atomically(name, data)
    return list(files)


def outputs_of(path: Path, format: str | None, side: str | None) -> list[Path]:
    """The names of the files that :func:`export` would write."""
    chosen = _chosen(path, format)
    return [_beside(path, chosen, one) for one in SIDES] if chosen.apart and side is None else [path]


def marks_writer(path: Path) -> MarksWriter:
    """What makes the content of a file of landmarks: called with specimens, a comment, and their coordinate system.

    Raises
    ------
    SettingsError
        If the format that its name says is not known, or none of landmarks.
    """
    chosen = _chosen(path, None)
    if chosen.marks is None:
        known = [ending for one in FORMATS.values() if one.marks is not None for ending in one.endings]
        raise SettingsError(f"{path}: landmarks are written as {', '.join(known)}")
    return chosen.marks


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
    known = {ending: one for one in FORMATS.values() if one.read is not None for ending in one.endings}
    ending = _ending(path, known)
    read = known[ending].read if ending else None
    if read is None:
        raise FormatError(f"{path}: unknown ending; landmarks are read from {', '.join(known)}")
    found = [one for one in read(path, coordinate_system) if len(one)]
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


def _chosen(path: Path, name: str | None) -> Format:
    if name is not None:
        _check_choice("the format", name, FORMATS)
        return FORMATS[name]
    known = {ending: one for one in FORMATS.values() for ending in one.endings}
    ending = _ending(path, known)
    if not ending:
        raise SettingsError(f"{path}: unknown ending; known are {', '.join(known)}. Or name the format (--format)")
    return known[ending]


def _ending(path: Path, known: dict[str, Format]) -> str:
    """The longest known ending that the name has, or nothing."""
    return max((ending for ending in known if path.name.lower().endswith(ending)), key=len, default="")


def _beside(path: Path, chosen: Format, side: str) -> Path:
    ending = max((e for e in chosen.endings if path.name.lower().endswith(e)), key=len, default=path.suffix)
    stem = path.name[: len(path.name) - len(ending)]
    return path.with_name(f"{stem}-{side}{path.name[len(stem) :]}")


def _check_choice(what: str, value: str, known: Sequence[str] | dict[str, Format]) -> None:
    if value not in known:
        raise SettingsError(f"{what} is {value!r}; choose one of {', '.join(known)}")
