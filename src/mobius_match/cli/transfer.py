"""``mobius transfer RESULT --what WHAT -o OUT``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from .attributes import WORDS, Attributes
from .common import Reporter
from .options import Back, NoCache, Quiet, ResultFile, Verbose
from .output import STDOUT, check_output, write
from .results import load_map

ENDINGS = (".ply", ".glb", ".obj", ".npz", ".csv", ".txt")


def transfer(
    result: ResultFile,
    what: Annotated[
        list[str],
        Option(
            metavar="colors|uv|labels|positions|FILE",
            help="What to transfer; may be repeated. 'colors', 'uv' (with the texture) and 'labels' (of faces) are "
            "read from the mesh file; 'positions' writes the target's shape with the source's triangles. A FILE "
            "(.csv, .txt, .npy, .npz) has one row per vertex, one whole number per face, or landmarks (columns "
            "vertex, or x, y, z).",
        ),
    ],
    output: Annotated[
        Path,
        Option(
            "--output",
            "-o",
            metavar="OUT",
            help="File to write: .ply, .glb, .obj, .npz, .csv or .txt; '-' prints CSV.",
        ),
    ],
    back: Back = False,
    donor: Annotated[
        Path | None,
        Option(
            "--from",
            metavar="MESH",
            help="Read colours, texture or labels from this file, which has the vertices and faces of the source.",
        ),
    ] = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Transfer colours, textures, labels, values, landmarks or the shape itself between two matched meshes."""
    _check(what, output, result, donor)
    with Reporter(quiet, verbose) as reporter:
        surface_map = load_map(result, reporter, cache=not no_cache, back=back)

        from ..transfer.transfer import Transfer

        attributes = Attributes(Transfer(surface_map))
        for name in what:
            attributes.add(name, donor)
        files = attributes.files(output)
        reporter.notes(attributes.notes)
        for path, content in files.items():
            write(path, content)
        reporter.notes([] if output == STDOUT else [f"{', '.join(what)} written to {output}"])


def _check(what: list[str], output: Path, result: Path, donor: Path | None) -> None:
    from ..errors import SettingsError

    if output != STDOUT and output.suffix.lower() not in ENDINGS:
        raise SettingsError(f"--output: {output} must end in one of {', '.join(ENDINGS)}.")
    files = [Path(name) for name in what if name not in WORDS]
    for path in files:
        if not path.is_file():
            raise SettingsError(f"--what: {path} is neither a file nor one of {', '.join(WORDS)}.")
    check_output("--output", output, [result, *files, *([donor] if donor else [])])
