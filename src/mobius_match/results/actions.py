"""What other rooms do with a result, reached from the result without an import of those rooms.

A result is data; it knows no viewer and no export. The package's own ``__init__``, the one place that knows all rooms,
says here by name what does the work, and it is imported when it is first asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

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
