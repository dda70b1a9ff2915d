"""``mobius view RESULT``."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from ..errors import SettingsError
from .common import say
from .match import Quiet, Verbose
from .output import STDOUT, check_output, write


def view(
    result: Annotated[Path, Argument(metavar="RESULT", help="Result of 'mobius match -o'.", show_default=False)],
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="FILE.html", help="Write the page there, and open no browser."),
    ] = None,
    with_map: Annotated[
        Path | None,
        Option("--with-map", metavar="FILE.npz", help="Show the dense map too, of 'mobius match --dense FILE.npz'."),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Look at the matches of a result on both shapes, in the browser.

    The page is one file that needs no network. The meshes are read again from where they were.
    """
    if output is not None:
        if output != STDOUT and output.suffix.lower() != ".html":
            raise SettingsError(f"--output: {output} is not a .html file; name it so.")
        check_output("--output", output, [result] if with_map is None else [result, with_map])

    from ..correspondence import Correspondence
    from ..dense import SurfaceMap
    from ..viewer import page

    dense = None if with_map is None else SurfaceMap.load(with_map)
    content = page(Correspondence.load(result), dense=dense).encode()
    if output is not None:
        write(output, content)
        if not quiet and output != STDOUT:
            say(f"page written to {output}")
        return
    import webbrowser

    # The browser reads the file after this command has ended, so it stays.
    with tempfile.NamedTemporaryFile(prefix="mobius-", suffix=".html", delete=False) as file:
        file.write(content)
    if not webbrowser.open(Path(file.name).as_uri()):
        say(f"no browser was found; open {file.name} in one")
    elif not quiet:
        say(f"opened {file.name}")
