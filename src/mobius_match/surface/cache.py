"""Prepared surfaces kept from one run to the next, under what they were made from.

The name of a file is a digest of the mesh file's bytes, the settings, this program and the libraries: whatever of them
changes, the surface is made anew. Files appear whole or not at all and may be deleted at any moment, so any number of
processes share the folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import platform
import re
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

from .._core.versions import software
from ..errors import FormatError, MobiusError, SettingsError
from ..settings import PrepareSettings
from .parameters import SurfaceParameters
from .surface import Surface

FOLDER, SIZE = "MOBIUS_CACHE_DIR", "MOBIUS_CACHE_MB"
"""Environment variables: where surfaces are kept, and how many megabytes at most."""

DEFAULT_SIZE = 2000
SEVERAL_FILES = (".gltf", ".glb")
"""Kinds of mesh files that may name others, so that their own bytes do not tell what they hold."""

_OURS = re.compile(r"\.?[0-9a-f]{64}\.npz(\..*)?")  # with what a killed process may leave

log = logging.getLogger(__name__)


def cache_folder() -> Path:
    """Where prepared surfaces are kept: MOBIUS_CACHE_DIR, or the system's place for caches.

    Raises
    ------
    SettingsError
        If the system names no such place.
    """
    if os.environ.get(FOLDER):
        return Path(os.environ[FOLDER])
    try:
        if sys.platform == "win32":
            place = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
        elif sys.platform == "darwin":
            place = Path.home() / "Library" / "Caches"
        else:
            place = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError as error:  # no home
        raise SettingsError(f"no folder for the cache is known ({error}); name one in {FOLDER}") from error
    return Path(place) / "mobius-match"


def cache_limit() -> int:
    """How many bytes the cache may have: MOBIUS_CACHE_MB million, or 2000 million.

    Raises
    ------
    SettingsError
        If MOBIUS_CACHE_MB is no whole number.
    """
    given = os.environ.get(SIZE) or str(DEFAULT_SIZE)
    if not given.isdecimal():
        raise SettingsError(f"{SIZE} is {given!r}; give a whole number of megabytes")
    return int(given) * 1_000_000


def load_cached(
    mesh: str | os.PathLike[str], settings: PrepareSettings, parameters: SurfaceParameters = SurfaceParameters()
) -> Surface | None:
    """The surface of a mesh file, if one is kept that was made from the same bytes and settings."""
    cache_limit()  # better now than after the work
    mesh = Path(mesh)
    if mesh.suffix.lower() in SEVERAL_FILES or not mesh.is_file():
        return None
    try:
        with mesh.open("rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        path = _path(mesh, sha256, settings, parameters)
        if not path.exists():
            return None
        surface = Surface.load(path)
        if (surface.mesh.sha256, surface.settings, surface.parameters) != (sha256, settings, parameters):
            raise FormatError(f"{path}: of another mesh or other settings")
    except (OSError, MobiusError) as error:
        log.info("%s: prepared anew, the cache is of no use: %s", mesh.name, error)
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # used last now
    log.info("%s: prepared before, taken from %s", mesh.name, path)
    # A file of the same content may have had another name.
    one, *others = (replace(x, mesh=replace(x.mesh, path=mesh, name=mesh.name)) for x in surface.readings)
    return replace(one, other=others[0] if others else None)


def store(mesh: str | os.PathLike[str], surface: Surface) -> None:
    """Keep the surface of a mesh file; if that is not possible nothing happens."""
    mesh = Path(mesh)
    if mesh.suffix.lower() in SEVERAL_FILES:
        return
    try:
        path = _path(mesh, surface.mesh.sha256, surface.settings, surface.parameters)
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)  # meshes may be nobody else's business
        surface.save(path)
        _make_room(path.parent, cache_limit())
    except (OSError, SettingsError) as error:
        log.info("%s: not kept in the cache (%s)", mesh.name, error)


def cached_files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    """The files of the cache in a folder, and their sizes and times."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        for entry in entries:
            if _OURS.fullmatch(entry.name):
                with contextlib.suppress(FileNotFoundError):
                    yield Path(entry.path), entry.stat()


def clear_cache() -> None:
    """Delete the files of the cache, and no other."""
    for path, _ in cached_files(cache_folder()):
        path.unlink(missing_ok=True)


def _make_room(folder: Path, limit: int) -> None:
    """Delete the files that were not used for longest until the others are within the limit."""
    files = sorted(cached_files(folder), key=lambda file: file[1].st_mtime_ns, reverse=True)
    total = 0
    for path, stat in files:
        too_large = stat.st_size > limit
        total += 0 if too_large else stat.st_size
        if too_large or total > limit:
            with contextlib.suppress(PermissionError):  # open in another process, on Windows
                path.unlink(missing_ok=True)


def _path(mesh: Path, sha256: str, settings: PrepareSettings, parameters: SurfaceParameters) -> Path:
    made_from = json.dumps([sha256, mesh.suffix.lower(), asdict(settings), asdict(parameters), _program()])
    return cache_folder() / f"{hashlib.sha256(made_from.encode()).hexdigest()}.npz"


@cache
def _program() -> str:
    """A digest of what computes: the versions, and the program's own text for those who change it."""
    digest = hashlib.sha256(json.dumps([software(), sys.platform, platform.machine()]).encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()
