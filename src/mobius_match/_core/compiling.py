"""How loops are compiled to kernels, and how a user is told that it takes a while.

numba keeps kernels from run to run: beside the sources, or where those cannot be written in a folder of the user.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numba
from numba.core import event

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
inlined = numba.njit(inline="always", **OPTIONS)

_not_kept: list[str] = []


def jit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """A kernel, kept from run to run if there is any folder to keep it in; with numba's options, a decorator."""
    if function is None:
        return partial(jit, **options)
    try:
        return numba.njit(function, cache=True, **OPTIONS, **options)
    except RuntimeError:  # no folder can be written
        _not_kept.append(function.__name__)
        return numba.njit(function, **OPTIONS, **options)


def compiling() -> str:
    """What a user is told who waits for kernels."""
    how_often = "every run: no folder can be written, name one in NUMBA_CACHE_DIR" if _not_kept else "first run only"
    return f"compiling kernels ({how_often}; up to 20 seconds or so)..."


@contextmanager
def on_compiling(tell: Callable[[], None]) -> Iterator[None]:
    """Have ``tell`` called, in any thread, whenever a kernel is compiled; not if it was kept."""
    with event.install_listener("numba:compile", _Listener(tell)):
        yield


class _Listener(event.Listener):
    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell

    def on_start(self, event: Any) -> None:
        self._tell()

    def on_end(self, event: Any) -> None:
        pass
