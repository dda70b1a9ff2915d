"""An interactive page with both shapes and their matches: one file that needs no network.

Its script, ``viewer.js``, is built from ``viewer/`` at the root of the repository. The modules ``shapes``, ``truth``,
``maps`` and ``insight`` compute the data that it shows.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from ..errors import FormatError
from . import shapes
from .opening import View as View
from .opening import displayed

if TYPE_CHECKING:
    from ..evaluation import Truth
    from ..results.correspondence import Correspondence
    from ..results.matches import Alternative
    from ..results.surface_map import SurfaceMap


def page(result: Correspondence, *, dense: SurfaceMap | None = None, truth: Truth | None = None) -> str:
    """A page (HTML) that shows both shapes side by side with their matches, in any browser and without network.

    Parameters
    ----------
    result
        A result of :func:`mobius_match.match`. The page can switch to its alternative alignments. For a result that was
        loaded from a file the meshes are read again, and the votes are not shown, as the file does not hold them.
    dense
        Its dense map (``result.dense()``). The page then also transfers colours from the source to the target, shows
        the distortion of the map, and morphs one shape into the other.
    truth
        Known correspondence of the two files; the page then shows errors.

    Returns
    -------
    str
        The text of an HTML file.

    Raises
    ------
    MeshError
        If the meshes of a loaded result cannot be read, have changed since the match, or are not those of the map.
    FormatError
        If numbers of a loaded result are not finite, or the truth names vertices that a mesh does not have.
    """
    try:
        text = json.dumps(result.to_dict(alternatives=bool(result.alternatives)), indent=1, allow_nan=False)
    except ValueError as error:
        raise FormatError("the result holds numbers that are not finite; match again, then view") from error
    title = html.escape(" - ".join(shapes.name_of(info) for info in (result.source_info, result.target_info)))
    script = files(__package__).joinpath("viewer.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data: blob:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<link rel="icon" href="data:,">
<title>{title}</title>
</head>
<body>
<noscript>This page needs JavaScript. The script is part of the file.</noscript>
<script type="application/json" id="result">{_harmless(text)}
</script>
<script type="application/json" id="shapes">{_harmless(json.dumps(_content(result, dense, truth)))}</script>
<script>{script}</script>
</body>
</html>
"""


def show(result: Correspondence, *, dense: SurfaceMap | None = None) -> View:
    """Show the page of a result in the notebook, or in the browser if there is no notebook; see :func:`page`."""
    return displayed(page(result, dense=dense))


def _harmless(text: str) -> str:
    """JSON text that cannot close the HTML element that contains it, nor open another."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _content(result: Correspondence, dense: SurfaceMap | None, truth: Truth | None) -> dict[str, Any]:
    """The data of the page as JSON-able values, which viewer/data.js reads."""
    sides, radius = shapes.sides_of(result, dense)
    content = shapes.content(result, sides, radius)
    alignments: list[Correspondence | Alternative] = [result, *result.alternatives]
    if truth is not None:
        from .truth import SCALE, WORST, Errors

        content["errors"] = {"worst": WORST, "scale": SCALE}
        errors = Errors(truth, sides)
        for packed, alignment in zip(content["alignments"], alignments, strict=True):
            packed |= errors.of_matches(alignment)
    if dense is not None:
        from .maps import add_map

        add_map(content, sides, dense, alignments)
        if truth is not None:
            content["colourings"].append(errors.of_map(dense))
    if result.votes is not None and result.source is not None and result.target is not None:
        from ..surface.reflected import reflected
        from .insight import insight

        source = reflected(result.source) if result.reflected else result.source
        votes = insight(source, result.target, result.votes, result.pairs)
        if votes is not None:
            content["insight"] = votes
    return content
