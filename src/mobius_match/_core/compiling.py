"""Compilation of loops to kernels, and the message for users who have to wait for it.

numba caches compiled kernels: next to the sources, or in a folder of the user where those cannot be written.
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

_uncached: list[str] = []
"""Kernels that no folder could be found for."""


def jit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """A compiled function, cached if there is a folder for it; with numba's options only, a decorator."""
    if function is None:
        return partial(jit, **options)
    try:
        return numba.njit(function, cache=True, **OPTIONS, **options)
    except RuntimeError:  # no folder can be written
        _uncached.append(function.__name__)
        return numba.njit(function, **OPTIONS, **options)


def compiling() -> str:
    """The message for users who wait for kernels."""
    if _uncached:
        return "compiling (up to a minute, in every run: no cache folder is writable; set NUMBA_CACHE_DIR to one) ..."
    return "compiling (up to a minute, in the first run only) ..."


@contextmanager
def on_compiling(report: Callable[[], None]) -> Iterator[None]:
    """Call ``report``, in any thread, whenever a kernel is compiled, but not if it was cached."""
    with event.install_listener("numba:compile", _Listener(report)):
        yield


class _Listener(event.Listener):
    def __init__(self, report: Callable[[], None]) -> None:
        self._report = report

    def on_start(self, event: Any) -> None:
        self._report()

    def on_end(self, event: Any) -> None:
        pass
