"""Exit codes and messages after Ctrl-C and SIGTERM."""

from __future__ import annotations

from types import FrameType


class Terminated(KeyboardInterrupt):
    """The process was asked to end (SIGTERM). It is handled like Ctrl-C, so that no half-written file is left."""


def terminate(_signal: int, _frame: FrameType | None) -> None:
    """Handler of SIGTERM."""
    raise Terminated


def stopped(error: KeyboardInterrupt) -> tuple[int, str]:
    """The exit code, as shells report it, and the last message after an interruption."""
    return (128 + 15, "terminated") if isinstance(error, Terminated) else (130, "interrupted")
