"""The formats, and the function that writes a match in any of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from .._core.files import write_atomically
from ..errors import SettingsError
from ..landmarks.csv_npz import SIDES
from ..landmarks.formats import LANDMARK_FORMATS, LandmarkWriter, ending_of
from ..landmarks.slicer import check_system
from ..results.correspondence import Correspondence
from ..results.surface_map import SurfaceMap
from .content import Content, with_min_confidence
from .meshes import write_mesh
from .tables import write_csv, write_mat, write_npz, write_text


@dataclass(frozen=True)
class Format:
    """How a format is written.

    Parameters
    ----------
    endings
        Endings of file names; the first is the usual one.
    single
        Whether a file holds one shape, so that source and target are two files.
    write_landmarks
        Makes the content of a file from landmarks, of one specimen or (if not ``single``) of several, a comment, and
        their coordinate system.
    write_match
        Makes the content of a file from a whole match, for formats that hold more than landmarks.
    write_side
        Makes the content of a file from a match and the side, 0 or 1.
    """

    endings: tuple[str, ...]
    single: bool = False
    write_landmarks: LandmarkWriter | None = None
    write_match: Callable[[Content], bytes] | None = None
    write_side: Callable[[Content, int], bytes] | None = None


FORMATS = {
    **{name: Format(form.endings, form.single, form.write) for name, form in LANDMARK_FORMATS.items() if form.write},
    "ply": Format((".ply",), single=True, write_side=partial(write_mesh, ending=".ply")),
    "glb": Format((".glb",), single=True, write_side=partial(write_mesh, ending=".glb")),
    "npz": Format((".npz",), write_match=write_npz),
    "mat": Format((".mat",), write_match=write_mat),
    "text": Format((".txt",), write_match=write_text),
}
"""Formats by name."""
FORMATS["csv"] = replace(FORMATS["csv"], write_match=write_csv)


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
    """Write matches, or a dense map, for other programs; docs/formats.md describes the formats.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`, or a dense map alone. The meshes of a loaded result are read from their
        files.
    path
        Where to write. Formats that hold one shape write two files, with ``-source`` and ``-target`` in their names.
    format
        One of ``csv, slicer, fcsv, tps, morphologika, pts, pp, ply, glb, npz, mat, text``; by default the ending of
        ``path`` determines it.
    side
        ``"source"`` or ``"target"`` to write only this shape, to ``path`` itself.
    min_confidence
        Matches with a lower confidence are omitted.
    dense
        The dense map, for formats that hold one, and to transfer colours between the meshes.
    coordinate_system
        ``"LPS"`` or ``"RAS"``, the coordinate system of the meshes, for the formats that record it. Coordinates are
        not converted.

    Returns
    -------
    list of Path
        The written files. Each appears as a whole or not at all.

    Raises
    ------
    SettingsError
        For an unknown format or ending, or for what the format cannot hold.
    NothingFoundError
        If no match has the minimum confidence.
    MeshError
        If a mesh is missing or has changed since the match, or ``dense`` belongs to other meshes.
    """
    path = Path(path)
    form = _format_of(path, format)
    check_system(coordinate_system)
    if side is not None:
        _check_choice("side", side, SIDES)
    if isinstance(result, SurfaceMap):
        content = Content(None, dense or result)
    else:
        content = Content(with_min_confidence(result, min_confidence), dense)
    sides = range(2) if side is None else [SIDES.index(side)]
    if form.write_match is not None and side is None:
        files = {path: form.write_match(content)}
    elif form.write_side is not None:
        files = {
            name: form.write_side(content, k) for name, k in zip(outputs_of(path, format, side), sides, strict=True)
        }
    elif form.write_landmarks is not None:
        landmarks = [content.landmarks[k] for k in sides]
        specimens = [[of_side] for of_side in landmarks] if form.single else [landmarks]
        files = {
            name: form.write_landmarks(of_file, content.comment, coordinate_system)
            for name, of_file in zip(outputs_of(path, format, side), specimens, strict=True)
        }
    else:
        raise SettingsError(f"{path}: this format holds both shapes together; it cannot be written with `side`")
    for name, data in files.items():
        write_atomically(name, data)
    return list(files)


def endings() -> list[str]:
    """The endings of file names that :func:`export` knows."""
    return [ending for one in FORMATS.values() for ending in one.endings]


def outputs_of(path: Path, format: str | None, side: str | None) -> list[Path]:
    """The files that :func:`export` would write."""
    form = _format_of(path, format)
    return [_path_of_side(path, form, of_side) for of_side in SIDES] if form.single and side is None else [path]


def _format_of(path: Path, name: str | None) -> Format:
    if name is not None:
        _check_choice("format", name, FORMATS)
        return FORMATS[name]
    known = {ending: form for form in FORMATS.values() for ending in form.endings}
    ending = ending_of(path, known)
    if not ending:
        raise SettingsError(f"{path}: unknown ending; known are {', '.join(known)}. Or choose the format with `format`")
    return known[ending]


def _path_of_side(path: Path, form: Format, side: str) -> Path:
    ending = max((e for e in form.endings if path.name.lower().endswith(e)), key=len, default=path.suffix)
    stem = path.name[: len(path.name) - len(ending)]
    return path.with_name(f"{stem}-{side}{path.name[len(stem) :]}")


def _check_choice(argument: str, value: str, choices: Sequence[str] | dict[str, Format]) -> None:
    if value not in choices:
        raise SettingsError(f"`{argument}` is {value!r}; choose one of {', '.join(choices)}")
