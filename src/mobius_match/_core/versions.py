"""Versions of the software that results depend on."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import version


@cache
def software() -> dict[str, str]:
    """Version by name of package."""
    names = ("mobius-match", "numpy", "scipy", "numba", "libigl")
    return {name: version(name) for name in names} | {"python": platform.python_version()}
