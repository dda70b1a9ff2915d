"""Prepared surfaces as files."""

from __future__ import annotations

import io
import json
import os
import zipfile
from dataclasses import asdict
from dataclasses import fields as fields_of
from pathlib import Path
from typing import Any

import numpy as np

from .._core.files import write_atomically
from ..errors import FormatError
from ..mesh import Mesh
from ..settings import PrepareSettings
from .parameters import SurfaceParameters
from .simplified import Detail

ENDING = ".npz"
FORMAT = "mobius-match/surface"
VERSION = 11
"""To be raised whenever other numbers come out of the preparation, or go into the file."""


def save_surface(surface: Any, path: str | os.PathLike[str]) -> None:
    """Write a surface to a file (numpy's .npz); an existing one is replaced at once or not at all."""
    write_atomically(Path(path), _content(surface))


def _content(surface: Any) -> bytes:
    values, arrays = _split(surface, "")
    del values["mesh"], values["detail"], values["other"]
    parts: dict[str, Mesh | Detail] = {"mesh.": surface.mesh}
    if surface.detail is not None:
        parts |= {"detail.": surface.detail, "detail.mesh.": surface.detail.mesh}
    if surface.whole_mesh.others is not None:
        parts |= {"others.": surface.whole_mesh.others}
    for prefix, part in parts.items():
        more = _split(part, prefix)
        values |= {name: value for name, value in more[0].items() if not name.endswith((".mesh", ".names", ".others"))}
        arrays |= more[1]
    values |= {"format": FORMAT, "version": VERSION, "settings": asdict(surface.settings)}
    values["parameters"] = asdict(surface.parameters)
    if surface.other is not None:
        arrays["other"] = np.frombuffer(_content(surface.other), np.uint8)
    buffer = io.BytesIO()
    arrays |= {"values": np.array(json.dumps(values, default=str))}
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def load_fields(path: str | os.PathLike[str], file: io.BytesIO | None = None) -> dict[str, Any]:
    """The fields of the surface in a file that :func:`save_surface` wrote; ``other`` as its fields, too.

    Raises
    ------
    FormatError
        If the file cannot be read or is none of this version.
    """
    try:
        with zipfile.ZipFile(file or path) as archive:
            # Each member as a whole, for only then its checksum is looked at.
            members = {name.removesuffix(".npy"): io.BytesIO(archive.read(name)) for name in archive.namelist()}
        found: dict[str, Any] = {
            name: np.lib.format.read_array(data, allow_pickle=False) for name, data in members.items()
        }
        found |= json.loads(str(found.pop("values")))
        if (found.pop("format"), found.pop("version")) != (FORMAT, VERSION):
            raise FormatError(f"{path}: not a prepared surface of version {VERSION}; prepare the mesh again")
        others = _mesh(found, "others.") if "others.vertices" in found else None
        whole = _mesh(found, "detail.mesh.", others) if "detail.mesh.vertices" in found else None
        found["detail"] = None if whole is None else Detail(whole, **_taken(found, "detail."))
        found["mesh"] = _mesh(found, "mesh.", others if whole is None else None)
        other = found.pop("other", None)
        found["other"] = None if other is None else load_fields(path, io.BytesIO(other.tobytes()))
        found["settings"], found["warnings"] = PrepareSettings(**found["settings"]), tuple(found["warnings"])
        numbers: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in found["parameters"].items()}
        found["parameters"] = SurfaceParameters(**numbers)
        return found
    except FormatError:
        raise
    except Exception as error:  # a damaged archive makes numpy fail in many ways
        raise FormatError(f"{path}: not a readable prepared surface ({error}); prepare the mesh again") from error


def _taken(found: dict[str, Any], prefix: str) -> dict[str, Any]:
    """Take the fields with this prefix out."""
    return {name.removeprefix(prefix): found.pop(name) for name in list(found) if name.startswith(prefix)}


def _mesh(found: dict[str, Any], prefix: str, others: Mesh | None = None) -> Mesh:
    fields = _taken(found, prefix)
    path = None if fields["path"] is None else Path(fields["path"])
    return Mesh(**fields | {"path": path, "others": others})


def _split(record: Any, prefix: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """A record's fields that are no arrays, and its arrays."""
    fields = {prefix + field.name: getattr(record, field.name) for field in fields_of(record)}
    arrays = {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}
    return {name: value for name, value in fields.items() if name not in arrays}, arrays
