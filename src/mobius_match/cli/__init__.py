"""The command line ``mobius``: reads arguments, calls the public functions, shows what they return.

Nothing heavy is imported before a command runs, so that ``mobius --help`` answers at once.
"""

from __future__ import annotations

import signal
import sys

from .signals import stopped, terminate


def main() -> None:
    """Run the command line on the arguments of the process, and exit."""
    signal.signal(signal.SIGTERM, terminate)
    try:
        # A file name that is not text must not stop the program from showing it.
        for stream in (sys.stdout, sys.stderr):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
        from .app import app

        app(prog_name="mobius")
    except KeyboardInterrupt as error:  # before a command has begun; later common.py deals with it
        code, text = stopped(error)
        sys.stderr.write(f"{text}\n")
        sys.exit(code)


__all__ = ["main"]
