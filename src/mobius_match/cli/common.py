"""What all commands share: exit codes, messages on standard error, and progress."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import re
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import typer

from ..errors import MeshError, MobiusError, NothingFoundError, SettingsError
from .signals import stopped

if TYPE_CHECKING:
    from rich.progress import Progress

FAILED, USAGE, UNUSABLE, NOTHING_FOUND, SOME_FAILED = 1, 2, 3, 4, 5
BROKEN_PIPE = 128 + 13  # as shells report it

_running: ContextVar[Callable[..., None] | None] = ContextVar("running", default=None)
"""The command that runs."""


def say(text: str) -> None:
    """Write one message to standard error, with options for the Python arguments that it names."""
    sys.stderr.write(with_options(text) + "\n")


def with_options(text: str) -> str:
    """Replace the Python arguments that a message names by the options of the running command.

    The library writes an argument in backquotes: ``lower `min_fraction` `` becomes ``lower --min-fraction``. Names
    that the command has no option for stay as they are.
    """
    command = _running.get()
    if command is None or "`" not in text:
        return text
    names = option_names(command)
    return re.sub(r"`(\w+)`", lambda found: names.get(found[1], found[0]), text)


def option_names(command: Callable[..., None]) -> dict[str, str]:
    """The option, or for an argument the name in the usage line, of each parameter of a command."""
    import typing

    names = {}
    for name, annotation in typing.get_type_hints(command, include_extras=True).items():
        for declared in getattr(annotation, "__metadata__", ()):
            # Typer holds the first name of an option as its default.
            words = declared.default, *(declared.param_decls or ())
            options = [word for word in words if isinstance(word, str) and word.startswith("--")]
            is_argument = type(declared).__name__ == "ArgumentInfo"
            default = (declared.metavar or name.upper()) if is_argument else f"--{name.replace('_', '-')}"
            names[name] = options[0] if options else default
    return names


def exit_code(error: MobiusError) -> int:
    """The exit code for an error of the package."""
    codes = {SettingsError: USAGE, MeshError: UNUSABLE, NothingFoundError: NOTHING_FOUND}
    return next((code for kind, code in codes.items() if isinstance(error, kind)), FAILED)


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Let a command end with one line on standard error and an exit code whatever is raised in it.

    The command has a parameter ``verbose``; if it is set, the traceback is printed too.
    """

    @functools.wraps(command)
    def run(**arguments: Any) -> None:
        _running.set(command)
        try:
            command(**arguments)
            sys.stdout.flush()
        except (SystemExit, typer.Exit, typer.BadParameter):
            raise
        except BaseException as error:  # noqa: BLE001  # interruptions too end with a message and their exit code
            raise SystemExit(_end(error, verbose=arguments["verbose"])) from None

    return run


def _end(error: BaseException, *, verbose: bool) -> int:
    """Report an error; its exit code."""
    code, text = _ending(error)
    if isinstance(error, KeyboardInterrupt):
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C would interrupt the ending
    if isinstance(error, BrokenPipeError):
        # Nobody reads standard output any more; the interpreter's own flush at exit must not fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    elif verbose and isinstance(error, Exception):
        import traceback

        traceback.print_exception(error)
    if text:
        say(text)
    return code


def _ending(error: BaseException) -> tuple[int, str]:
    """The exit code and the last line on standard error."""
    if isinstance(error, MobiusError):
        return exit_code(error), f"error: {error}"
    if isinstance(error, KeyboardInterrupt):
        return stopped(error)
    if isinstance(error, BrokenPipeError):
        return BROKEN_PIPE, ""
    if isinstance(error, OSError):
        return FAILED, f"error: {error}"
    what = " ".join(str(error).split()) or "no message"
    hint = "run again with --verbose for the traceback, and please report it"
    return FAILED, f"internal error: {type(error).__name__}: {what} ({hint})"


class Reporter:
    """Notes and progress on standard error; with ``verbose`` also the library's log, with ``quiet`` nothing.

    A context manager around the work. The progress bar is drawn on a terminal only. The method `progress` is passed to
    the library's functions as their ``progress``.
    """

    def __init__(self, quiet: bool, verbose: bool = False) -> None:
        self.quiet = quiet
        self.handler = _Handler(self.notes)
        self.verbose = verbose
        self.bar: Progress | None = None
        self.stage = ""
        self.compiled = False

    def __enter__(self) -> Reporter:
        if not self.quiet and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

            name, left = TextColumn("{task.description}", markup=False), TextColumn("left:", markup=False)
            columns = (name, BarColumn(), TimeElapsedColumn(), left, TimeRemainingColumn())
            self.bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self.bar.start()
        if self.verbose:
            logging.getLogger("mobius_match").addHandler(self.handler)
            logging.getLogger("mobius_match").setLevel(logging.INFO)
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()
            self.bar = None
        logging.getLogger("mobius_match").removeHandler(self.handler)

    def notes(self, lines: Iterable[str]) -> None:
        """Print lines for the user, unless quiet."""
        for line in () if self.quiet else lines:
            if self.bar is None:
                say(line)
            else:
                self.bar.console.print(with_options(line), markup=False, highlight=False, emoji=False, soft_wrap=True)

    @contextlib.contextmanager
    def compiling(self) -> Iterator[None]:
        """Report once if kernels are compiled during the work, which takes a while."""
        from .._core.compiling import compiling, on_compiling

        def report() -> None:
            if not self.compiled:
                self.compiled = True
                self.notes([compiling()])

        with on_compiling(report):
            yield

    def progress(self, stage: str, done: int, total: int) -> None:
        """Show the progress of a stage of the work."""
        if self.bar is not None:
            if self.stage != stage:
                for task in self.bar.task_ids:
                    self.bar.remove_task(task)
                self.bar.add_task(stage)
            self.bar.update(self.bar.task_ids[-1], completed=done, total=total)
        self.stage = stage


class _Handler(logging.Handler):
    def __init__(self, notes: Callable[[Iterable[str]], None]) -> None:
        super().__init__()
        self._notes = notes

    def emit(self, record: logging.LogRecord) -> None:
        self._notes([record.getMessage()])
