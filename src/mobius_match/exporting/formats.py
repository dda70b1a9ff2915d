"""The table of formats, and what users call: a match written in any of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from .._core.files import write_atomically
from ..errors import SettingsError
from ..landmarks.formats import LANDMARK_FORMATS, MarksWriter, ending_of
from ..landmarks.rows import SIDES
from ..landmarks.slicer import check_system
from ..results.correspondence import Correspondence
from ..results.surface_map import SurfaceMap
from .content import Content, confident
from .meshes import write_mesh
from .tables import write_csv, write_mat, write_npz, write_text


@dataclass(frozen=True)
class Format:
    """How a match is written.

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
    """

    endings: tuple[str, ...]
    apart: bool = False
    marks: MarksWriter | None = None
    whole: Callable[[Content], bytes] | None = None
    mesh: Callable[[Content, int], bytes] | None = None


FORMATS = {
    **{name: Format(one.endings, one.apart, one.marks) for name, one in LANDMARK_FORMATS.items() if one.marks},
    "ply": Format((".ply",), apart=True, mesh=partial(write_mesh, ending=".ply")),
    "glb": Format((".glb",), apart=True, mesh=partial(write_mesh, ending=".glb")),
    "npz": Format((".npz",), whole=write_npz),
    "mat": Format((".mat",), whole=write_mat),
    "text": Format((".txt",), whole=write_text),
}
FORMATS["csv"] = replace(FORMATS["csv"], whole=write_csv)
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


def endings() -> list[str]:
    """The endings of file names that :func:`export` knows."""
    return [ending for one in FORMATS.values() for ending in one.endings]


def outputs_of(path: Path, format: str | None, side: str | None) -> list[Path]:
    """The names of the files that :func:`export` would write."""
    chosen = _chosen(path, format)
    return [_beside(path, chosen, one) for one in SIDES] if chosen.apart and side is None else [path]


def _chosen(path: Path, name: str | None) -> Format:
    if name is not None:
        _check_choice("the format", name, FORMATS)
        return FORMATS[name]
    known = {ending: one for one in FORMATS.values() for ending in one.endings}
    ending = ending_of(path, known)
    if not ending:
        raise SettingsError(f"{path}: unknown ending; known are {', '.join(known)}. Or name the format (--format)")
    return known[ending]


def _beside(path: Path, chosen: Format, side: str) -> Path:
    ending = max((e for e in chosen.endings if path.name.lower().endswith(e)), key=len, default=path.suffix)
    stem = path.name[: len(path.name) - len(ending)]
    return path.with_name(f"{stem}-{side}{path.name[len(stem) :]}")


def _check_choice(what: str, value: str, known: Sequence[str] | dict[str, Format]) -> None:
    if value not in known:
        raise SettingsError(f"{what} is {value!r}; choose one of {', '.join(known)}")
