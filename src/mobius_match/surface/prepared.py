"""Settings and surfaces that are prepared already: what takes effect, and what is recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from ..errors import SettingsError
from ..mesh import Mesh
from ..settings import PRESETS, MatchSettings, PrepareSettings, prepared_piece
from .surface import Surface


def check_effective(thing: Surface | Mesh, argument: str, chosen: Mapping[str, Any], preset: str | None = None) -> None:
    """Refuse settings that cannot take effect, because the surface is prepared already and with others.

    Parameters
    ----------
    thing
        The surface; a mesh, which is yet to be prepared, is never refused.
    argument
        The argument that it was given as (``"source"``).
    chosen
        The settings that the caller chose; those that do not concern the preparation are ignored.
    preset
        The preset that the caller chose.

    Raises
    ------
    SettingsError
        For the first setting whose chosen value the surface does not have.
    """
    if isinstance(thing, Mesh):
        return
    of_preset = {} if preset is None else PRESETS[preset]
    for name, has in asdict(thing.settings).items():
        value = chosen.get(name, of_preset.get(name, has))
        if name == "pieces":
            value = prepared_piece(value)
        if value != has:
            if name in chosen:
                what, remedy = f"`{name}` is {value!r}", f"`{name}` {value!r}"
            else:
                what, remedy = f"`preset` {preset!r} sets `{name}` to {value!r}", f"`preset` {preset!r}"
            raise SettingsError(
                f"{what}, but the {argument} {thing.mesh.name} was prepared with `{name}` {has!r}; "
                f"give the mesh itself, prepare it with {remedy}, or set `{name}` to {has!r}"
            )


def settings_used(
    settings: MatchSettings, source: PrepareSettings, target: PrepareSettings
) -> tuple[MatchSettings, dict[str, Any], list[str]]:
    """The settings that a match of two prepared surfaces uses, which may not be the ones that it was called with.

    Parameters
    ----------
    settings
        The settings of the call.
    source, target
        The settings that the surfaces were prepared with.

    Returns
    -------
    used
        The settings of the call, with the preparation of the source.
    differing
        ``{"target_preparation": ...}``, the target's preparation as a dictionary, if it differs; else empty.
    warnings
        A line if it differs.
    """
    pieces = settings.pieces if prepared_piece(settings.pieces) == source.pieces else source.pieces
    used = replace(settings, **asdict(source) | {"pieces": pieces})
    if source == target:
        return used, {}, []
    if replace(source, pieces=target.pieces) == target:  # which piece is the main one need not be the same
        return used, {"target_preparation": asdict(target)}, []
    mine, theirs = asdict(source), asdict(target)
    values = [f"{name} {mine[name]} and {theirs[name]}" for name in mine if mine[name] != theirs[name]]
    warning = (
        f"source and target were prepared with different settings ({', '.join(values)}); "
        "matches are better if both are prepared with the same"
    )
    return used, {"target_preparation": theirs}, [warning]
