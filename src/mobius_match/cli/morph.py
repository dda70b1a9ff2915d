"""``mobius morph RESULT -o DIR``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from .common import Reporter
from .options import Back, NoCache, Quiet, ResultFile, Verbose
from .output import check_output, make_folder, write
from .results import load_map

MAX_FRAMES = 1000


def morph(
    result: ResultFile,
    output: Annotated[Path, Option("--output", "-o", metavar="DIR", help="Output folder, created if needed.")],
    frames: Annotated[int, Option(metavar="N", help="Number of frames, including source and target.")] = 25,
    back: Back = False,
    seconds: Annotated[float, Option(metavar="S", help="Duration of the animation.")] = 2.0,
    pixels: Annotated[int, Option(metavar="P", help="Width and height of the pictures; 0 for none.")] = 600,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Morph one matched shape into the other: an animated morph.glb, and a picture of each frame.

    The first frame is the source, the last has the shape of the target; all have the triangles of the source. In
    between, limbs rotate as rigidly as possible.
    """
    _check(output, frames, seconds, pixels)
    with Reporter(quiet, verbose) as reporter:
        surface_map = load_map(result, reporter, cache=not no_cache, back=back)

        import numpy as np

        from ..exporting.figures import draw_shapes, png
        from ..transfer.animation import animated_glb
        from ..transfer.morph import morph as morph_shapes
        from ..transfer.morph import oriented

        unmapped = int((~surface_map.source_mapped).sum())
        if unmapped:
            reporter.notes([f"{unmapped} vertices have no counterpart and move with their neighbours"])
        if surface_map.reflected:
            reporter.notes(["the source was reflected first, as the map is that of its mirror image"])
        faces = oriented(surface_map).source.faces
        shapes = morph_shapes(surface_map, np.linspace(0, 1, frames))
        write(output / "morph.glb", animated_glb(shapes, faces, seconds))
        for number, picture in enumerate(draw_shapes(shapes, faces, size=(pixels, pixels)) if pixels else ()):
            reporter.progress("drawing", number, frames)
            write(output / f"frame{number:03d}.png", png(picture))
        reporter.notes([f"{frames} frames written to {output}"])


def _check(output: Path, frames: int, seconds: float, pixels: int) -> None:
    from ..errors import SettingsError
    from ..exporting.figures import LARGEST, SMALLEST

    if not 2 <= frames <= MAX_FRAMES:
        raise SettingsError(f"--frames is {frames}; give a number from 2 to {MAX_FRAMES}.")
    if not 0 < seconds <= 3600:
        raise SettingsError(f"--seconds is {seconds}; give a number above 0, up to 3600.")
    if pixels and not SMALLEST <= pixels <= LARGEST:
        raise SettingsError(f"--pixels is {pixels}; give 0, or a number from {SMALLEST} to {LARGEST}.")
    make_folder(output)
    check_output("--output", output / "morph.glb")
