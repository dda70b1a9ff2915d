"""``mobius view RESULT``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from ..errors import SettingsError
from .common import Reporter, say
from .options import Quiet, Verbose
from .output import STDOUT, check_outputs, write
from .results import draw

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence


def view(
    result: Annotated[Path, Argument(metavar="RESULT", help="Result of 'mobius match -o'.", show_default=False)],
    output: Annotated[
        Path | None,
        Option(
            "--output", "-o", metavar="FILE.html", help="Write the page to this file instead of opening the browser."
        ),
    ] = None,
    dense: Annotated[
        Path | None,
        Option("--with-map", metavar="FILE.npz", help="Show this dense map too (of 'mobius match --dense FILE.npz')."),
    ] = None,
    truth: Annotated[
        Path | None,
        Option(
            metavar="FILE",
            help="Show errors against a known correspondence: lines 'SOURCE TARGET', one line per source vertex, or "
            "a folder or manifest of 'mobius bench' that contains the pair.",
        ),
    ] = None,
    explain: Annotated[
        bool, Option("--explain", help="Show the votes too. For this the meshes are matched again.")
    ] = False,
    png: Annotated[
        Path | None,
        Option(metavar="FILE.png", help="Draw both shapes with their matches instead of opening the browser."),
    ] = None,
    size: Annotated[str, Option(metavar="WxH", help="Size of the picture in pixels.")] = "1600x800",
    view: Annotated[
        str | None,
        Option(
            metavar="AZ,EL",
            help="View direction of the picture, azimuth and elevation in degrees: 0,0 is the front, 90,0 the shapes' "
            "left, 0,90 above.  [default: the one in which most matches are visible]",
        ),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Show the matches of a result on both shapes, in the browser.

    The page is one file that needs no network. The meshes are read again from the paths in the result.
    """
    inputs = [path for path in (result, dense, truth) if path is not None]
    check_outputs({"--output": output, "--png": png}, inputs, {"--output": ".html", "--png": ".png"})
    pixels = _numbers("--size", size, "x", int)
    direction = None if view is None else _numbers("--view", view, ",", float)

    from ..results.correspondence import Correspondence

    with Reporter(quiet, verbose) as reporter:
        loaded = Correspondence.load(result)
        if png is not None:
            write(png, draw(loaded, size=pixels, view=direction))
            reporter.notes([f"picture written to {png}"])
            if output is None:
                return
        content = _page(loaded, dense, truth, explain, reporter)
    if output is not None:
        write(output, content.encode())
        if not quiet and output != STDOUT:
            say(f"page written to {output}")
        return
    from ..viewer.opening import open_in_browser

    path, opened = open_in_browser(content)
    if not opened:
        say(f"no browser was found; open {path} in one")
    elif not quiet:
        say(f"opened {path}")


def _page(result: Correspondence, dense: Path | None, truth: Path | None, explain: bool, reporter: Reporter) -> str:
    """The page, the text of an HTML file."""
    import numpy as np

    from ..results.surface_map import SurfaceMap
    from ..viewer import page

    surface_map = None if dense is None else SurfaceMap.load(dense)
    known = None
    if truth is not None:
        from ..evaluation import read_truth

        infos = result.source_info, result.target_info
        known = read_truth(truth, *(info.get("path") for info in infos), int(infos[0].get("vertices", 0)))
    if explain:
        from ..matching.rematch import rematch

        with reporter.compiling():
            again = rematch(result, cache=True, progress=reporter.progress)
        if not np.array_equal(again.pairs, result.pairs):
            reporter.notes(["matching again gave different matches: the result is from another version of the program"])
        result = replace(result, source=again.source, target=again.target, votes=again.votes)
    return page(result, dense=surface_map, truth=known)


def _numbers(option: str, text: str, separator: str, kind: type[int] | type[float]) -> tuple[Any, Any]:
    try:
        first, second = (kind(part) for part in text.lower().split(separator))
    except ValueError:
        example = "1600x800" if separator == "x" else "30,15"
        raise SettingsError(f"{option}: {text!r} is not two numbers, as in {example}.") from None
    return first, second
