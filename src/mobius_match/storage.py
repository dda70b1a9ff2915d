"""Prepared surfaces as files."""

from __future__ import annotations

import io
import json
import os
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .correspondence import write_atomically
from .errors import FormatError
from .mesh import Mesh
from .settings import PrepareSettings

if TYPE_CHECKING:
    from .surface import Surface

ENDING = ".npz"
FORMAT = "mobius-match/surface"
VERSION = 1
"""To be raised whenever other numbers come out of the preparation, or go into the file."""


def save_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a surface to a file (numpy's .npz); an existing one is replaced at once or not at all."""
    mesh_values, mesh_arrays = _split(surface.mesh, "mesh.")
    values, arrays = _split(surface, "")
    del values["mesh"]
    values |= {"format": FORMAT, "version": VERSION, "settings": asdict(surface.settings)}
    buffer = io.BytesIO()
    arrays |= mesh_arrays | {"values": np.array(json.dumps(values | mesh_values, default=str))}
    np.savez(buffer, allow_pickle=False, **arrays)
    write_atomically(Path(path), buffer.getvalue())


def load_fields(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The fields of the surface in a file that :func:`save_surface` wrote.

    Raises
    ------
    FormatError
        If the file cannot be read or is none of this version.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            # Each member as a whole, for only then its checksum is looked at.
            members = {name.removesuffix(".npy"): io.BytesIO(archive.read(name)) for name in archive.namelist()}
        found: dict[str, Any] = {
            name: np.lib.format.read_array(data, allow_pickle=False) for name, data in members.items()
        }
        found |= json.loads(str(found.pop("values")))
        if (found.pop("format"), found.pop("version")) != (FORMAT, VERSION):
            raise FormatError(f"{path}: not a prepared surface of version {VERSION}; prepare the mesh again")
        mesh = {name[5:]: found.pop(name) for name in list(found) if name.startswith("mesh.")}
        mesh["path"] = None if mesh["path"] is None else Path(mesh["path"])
        found["settings"], found["warnings"] = PrepareSettings(**found["settings"]), tuple(found["warnings"])
        return {"mesh": Mesh(**mesh), **found}
    except FormatError:
        raise
    except Exception as error:  # a damaged archive makes numpy fail in many ways
        raise FormatError(f"{path}: not a readable prepared surface ({error}); prepare the mesh again") from error


def _split(record: Surface | Mesh, prefix: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """A record's fields that are no arrays, and its arrays."""
    fields = {prefix + name: value for name, value in vars(record).items()}
    arrays = {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}
    return {name: value for name, value in fields.items() if name not in arrays}, arrays
