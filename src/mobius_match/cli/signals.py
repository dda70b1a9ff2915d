"""How the command ends when it is interrupted."""

from __future__ import annotations

from types import FrameType


class Terminated(KeyboardInterrupt):
    """The process was asked to end (SIGTERM); handled like Ctrl-C, so that nothing half-written stays."""


def terminate(_signal: int, _frame: FrameType | None) -> None:
    """Handler of SIGTERM."""
    raise Terminated


def stopped(error: KeyboardInterrupt) -> tuple[int, str]:
    """Exit code, as shells report it, and last line after an interruption."""
    return (128 + 15, "terminated") if isinstance(error, Terminated) else (130, "interrupted")
