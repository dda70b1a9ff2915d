"""The commands and their names."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperCommand

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


class Command(TyperCommand):
    """A command whose help shows arguments as users write them: MESH..., without braces and Python types."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The words of the usage line."""
        return [self.options_metavar or "", *(argument.metavar or "" for argument in self._arguments(ctx))]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the lists of arguments and options."""
        arguments = [(one.metavar, one.get_help_record(ctx)[1]) for one in self._arguments(ctx)]
        options = [one.get_help_record(ctx) for one in self.get_params(ctx) if one.param_type_name == "option"]
        for title, rows in (("Arguments", arguments), ("Options", options)):
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)

    def _arguments(self, ctx: Any) -> list[Any]:
        return [one for one in self.get_params(ctx) if one.param_type_name == "argument"]


app = typer.Typer(
    name="mobius",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: loading rich takes longer than loading everything else
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
    """Find correspondences between two surfaces by Möbius voting.

    Exit codes: 0 done, 2 wrong usage, 3 unusable input, 4 nothing found, 5 some of several jobs failed,
    130 interrupted.
    """


# For the list of commands, where the first sentence of the help does not fit into 80 columns.
SHORT = {
    view: "Show the matches of a result on both shapes.",
    demo: "Match the example meshes and measure the errors.",
    bench: "Measure the errors on a data set with known correspondence.",
    symmetry: "Find the left-right symmetry of a mesh.",
    convert: "Convert a result for other programs.",
    landmarks: "Transfer landmarks from one matched shape to the other.",
    transfer: "Transfer colours, textures, labels or values.",
    morph: "Morph one matched shape into the other.",
    cache: "Show or clear the cache of prepared surfaces.",
}

for command in (match, view, info, demo, bench, symmetry, convert, landmarks, transfer, morph, prepare, cache):
    app.command(cls=Command, short_help=SHORT.get(command))(guarded(command))
