"""The commands and their names."""

from __future__ import annotations

from typing import Annotated

import typer

from .. import __version__
from .bench import bench
from .cache import cache
from .common import guarded
from .convert import convert
from .demo import demo
from .info import info
from .landmarks import landmarks
from .match import match
from .morph import morph
from .prepare import prepare
from .symmetry import symmetry
from .transfer import transfer
from .view import view

app = typer.Typer(
    name="mobius",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: rich's takes longer to load than all the rest
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mobius-match {__version__}")
        raise typer.Exit


@app.callback()
def mobius(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Correspondences between two surfaces by Möbius voting.

    Exit codes: 0 done, 2 wrong usage, 3 unusable input, 4 nothing found, 5 some of several jobs failed,
    130 interrupted.
    """


# What the list of commands says where the first sentence of the help is too long for a terminal of 80 columns.
SHORT = {
    view: "Look at the matches of a result on both shapes.",
    demo: "Match the pairs of meshes that come with the program.",
    bench: "Measure errors on a set with known correspondence.",
    symmetry: "Find which half of a mesh mirrors the other.",
    convert: "Write a result for other programs.",
    landmarks: "Carry landmarks from one matched shape to the other.",
    transfer: "Carry colours, textures, labels or values along.",
    morph: "Turn one matched shape into the other.",
    cache: "Show or delete the prepared surfaces that are kept.",
}

for command in (match, view, info, demo, bench, symmetry, convert, landmarks, transfer, morph, prepare, cache):
    app.command(short_help=SHORT.get(command))(guarded(command))
