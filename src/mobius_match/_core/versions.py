"""Which software results come from."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import version


@cache
def software() -> dict[str, str]:
    """Versions of what results depend on."""
    names = ("mobius-match", "numpy", "scipy", "numba", "libigl")
    return {name: version(name) for name in names} | {"python": platform.python_version()}
