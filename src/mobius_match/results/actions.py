"""What other rooms do with a result, reached from the result without an import of those rooms.

A result is data; it knows no viewer and no export. The package's own ``__init__``, the one place that knows all rooms,
registers the functions here by name, and each is imported when it is first called.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import SettingsError

RESULT_ENDING = ".json"
MARKUPS_ENDING = ".mrk.json"
"""Of landmarks for 3D Slicer, which ends like a result file and is exported."""

_PROVIDERS: dict[str, tuple[str, str]] = {}


def provide(**providers: str) -> None:
    """Say what does an action: ``name="module:function"``."""
    for action, place in providers.items():
        module, _, function = place.partition(":")
        _PROVIDERS[action] = module, function


def action(name: str) -> Callable[..., Any]:
    """The function that does an action on a result."""
    module, function = _PROVIDERS[name]
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found


def check_json(path: Path) -> None:
    """Refuse a name under which JSON would not be expected.

    Raises
    ------
    SettingsError
        If the name does not end in .json.
    """
    if path.suffix.lower() != RESULT_ENDING and not _is_device(path):
        raise SettingsError(f"{path}: the result is written as JSON; give a name that ends in {RESULT_ENDING}")


def _is_device(path: Path) -> bool:
    """Whether there is something else than a file, such as a pipe, whose name says nothing."""
    return path.exists() and not path.is_file()


def is_result_file(path: Path) -> bool:
    """Whether a result is written there as a result file (JSON), rather than exported for another program.

    Raises
    ------
    SettingsError
        If the ending of the name is that of no format.
    """
    name = path.name.lower()
    if _is_device(path) or (name.endswith(RESULT_ENDING) and not name.endswith(MARKUPS_ENDING)):
        return True
    known = action("endings")()
    if not name.endswith(tuple(known)):
        others = ", ".join(one for one in known if one != RESULT_ENDING)
        raise SettingsError(
            f"{path}: unknown ending; name it {RESULT_ENDING} for a result file, or for other programs one of {others}"
        )
    return False
