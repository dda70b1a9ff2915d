"""The command line ``mobius``: reads arguments, calls the public functions and prints what they return.

Numerical libraries are imported only when a command runs, so that ``mobius --help`` starts quickly.
"""

from __future__ import annotations

import signal
import sys

from .signals import stopped, terminate


def main() -> None:
    """Run the command line on the arguments of the process, and exit."""
    signal.signal(signal.SIGTERM, terminate)
    try:
        # File names may hold bytes that are not valid text; they are printed as escapes.
        for stream in (sys.stdout, sys.stderr):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
        from .app import app

        app(prog_name="mobius")
    except KeyboardInterrupt as error:  # before a command has begun; afterwards common.py handles it
        code, text = stopped(error)
        sys.stderr.write(f"{text}\n")
        sys.exit(code)


__all__ = ["main"]
