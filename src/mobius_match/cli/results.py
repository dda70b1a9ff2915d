"""What commands that go on from a match take: its result, or its dense map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument

from .common import Reporter

if TYPE_CHECKING:
    from ..results.surface_map import SurfaceMap

ResultFile = Annotated[
    Path,
    Argument(
        metavar="RESULT",
        help="A dense map (.npz, of mobius match --dense), or a result (.json, of mobius match -o), which is matched "
        "again.",
    ),
]


def load_map(path: Path, reporter: Reporter, *, cache: bool) -> SurfaceMap:
    """The dense map that a file holds, or that matching its result again gives."""
    if path.suffix.lower() == ".npz":
        from ..results.surface_map import SurfaceMap

        return SurfaceMap.load(path)
    from ..matching.rematch import rematch
    from ..results.correspondence import Correspondence

    with reporter.compiling():
        result = rematch(Correspondence.load(path), cache=cache, progress=reporter.progress)
    reporter.notes(result.warnings)
    return result.dense()
