"""Settings of a match from a TOML file."""

from __future__ import annotations

import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

from ..errors import SettingsError
from ..settings import PRESETS, MatchSettings, make_settings


def read_config(path: Path) -> dict[str, Any]:
    """Read and check the settings in a TOML file; ``min-fraction`` and ``min_fraction`` are the same key.

    Raises
    ------
    SettingsError
        The file cannot be read, is not TOML, or has an unknown key or a value out of range.
    """
    try:
        given = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"--config: {path} cannot be read ({error.strerror}).") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"--config: {path} is not valid TOML: {error}.") from error
    config = {key.replace("-", "_"): value for key, value in given.items()}
    known = ["preset", *(field.name for field in fields(MatchSettings))]
    unknown = [key for key in given if key.replace("-", "_") not in known]
    if unknown:
        raise SettingsError(
            f"--config: {path} has an unknown key {unknown[0]!r}; known keys are {', '.join(sorted(known))}."
        )
    try:
        make_settings(**config)
    except SettingsError as error:
        # A file has the names themselves, without the backquotes that the command turns into options.
        raise SettingsError(f"--config: {path}: {str(error).replace('`', '')}") from error
    return config


def given_settings(config: Path | None = None, **options: Any) -> dict[str, Any]:
    """The settings given in a file and by options (None where not given), which override the file.

    A ``preset`` among the options overrides the file too.
    """
    given = {name: value for name, value in options.items() if value is not None}
    from_preset = PRESETS.get(given.get("preset", ""), {})
    from_file = read_config(config) if config else {}
    return {name: value for name, value in from_file.items() if name not in from_preset} | given
