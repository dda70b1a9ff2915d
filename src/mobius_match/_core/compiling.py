"""Compilation of kernels by numba, and the message that it takes a while.

numba caches kernels from run to run, beside the sources or, where these cannot be written, in a folder of the user.
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

_not_cached: list[str] = []


def jit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a kernel, cached from run to run if any folder can be written; with numba's options, a decorator."""
    if function is None:
        return partial(jit, **options)
    try:
        return numba.njit(function, cache=True, **OPTIONS, **options)
    except RuntimeError:  # no folder can be written
        _not_cached.append(function.__name__)
        return numba.njit(function, **OPTIONS, **options)


def compiling() -> str:
    """The message to show while kernels are compiled."""
    how_often = "every run: no folder can be written, set NUMBA_CACHE_DIR" if _not_cached else "first run only"
    return f"compiling kernels ({how_often}; up to 20 seconds or so)..."


@contextmanager
def on_compiling(report: Callable[[], None]) -> Iterator[None]:
    """Call ``report``, in any thread, whenever a kernel is compiled, not when it is loaded from the cache."""
    with event.install_listener("numba:compile", _Listener(report)):
        yield


class _Listener(event.Listener):
    def __init__(self, report: Callable[[], None]) -> None:
        self._report = report

    def on_start(self, event: Any) -> None:
        self._report()

    def on_end(self, event: Any) -> None:
        pass
