"""What several commands do with a match: load its dense map, and draw it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .common import Reporter

if TYPE_CHECKING:
    from ..results.correspondence import Correspondence
    from ..results.surface_map import SurfaceMap


def load_map(path: Path, reporter: Reporter, *, cache: bool, back: bool) -> SurfaceMap:
    """The dense map in a file, or of the match that a result file describes; with ``back`` its inverse."""
    surface_map = _load_map(path, reporter, cache)
    return surface_map.inverse if back else surface_map


def _load_map(path: Path, reporter: Reporter, cache: bool) -> SurfaceMap:
    if path.suffix.lower() == ".npz":
        from ..results.surface_map import SurfaceMap

        return SurfaceMap.load(path)
    from ..matching.rematch import rematch
    from ..results.correspondence import Correspondence

    with reporter.compiling():
        result = rematch(Correspondence.load(path), cache=cache, progress=reporter.progress)
    reporter.notes(result.warnings)
    return result.dense()


def draw(result: Correspondence, **options: Any) -> bytes:
    """The picture of the matches, as the bytes of a PNG file."""
    from ..exporting.figures import draw_matches

    picture = io.BytesIO()
    draw_matches(result, picture, **options)
    return picture.getvalue()
