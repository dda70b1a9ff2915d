"""A page with both shapes and their matches, to turn and to look through: one file that needs no network.

The script, ``viewer.js``, is built from ``viewer/`` at the root of the repository; ``shapes``, ``truth``, ``maps`` and
``insight`` make what it shows.
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
        A result of :func:`mobius_match.match`; for one that was loaded from a file, the meshes are read again. Its
        alternatives can be switched to. The votes, which a loaded result lacks, are shown with the flattened samples.
    dense
        Its dense map (``result.dense()``): the page can then carry colours from the source to the target by it, show
        how it distorts, and turn one shape into the other.
    truth
        Known correspondence of the two files, which errors are shown against.

    Returns
    -------
    str
        All of an HTML file.

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
<noscript>This page needs JavaScript, which is in it.</noscript>
<script type="application/json" id="result">{_harmless(text)}
</script>
<script type="application/json" id="shapes">{_harmless(json.dumps(_content(result, dense, truth)))}</script>
<script>{script}</script>
</body>
</html>
"""


def show(result: Correspondence, *, dense: SurfaceMap | None = None) -> View:
    """Show the page of a result in the notebook, or else in the browser; see :func:`page`."""
    return displayed(page(result, dense=dense))


def _harmless(text: str) -> str:
    """JSON that cannot end the element it stands in, nor begin another."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _content(result: Correspondence, dense: SurfaceMap | None, truth: Truth | None) -> dict[str, Any]:
    """What is shown, as JSON-able values; viewer/data.js reads it."""
    sides, radius = shapes.sides_of(result)
    content = shapes.content(result, sides, radius)
    explanations: list[Correspondence | Alternative] = [result, *result.alternatives]
    if truth is not None:
        from .truth import SCALE, WORST, Errors

        content["errors"] = {"worst": WORST, "scale": SCALE}
        errors = Errors(truth, sides)
        for shown, matches in zip(content["explanations"], explanations, strict=True):
            shown |= errors.of_matches(matches)
    if dense is not None:
        from .maps import add_map

        add_map(content, sides, dense, explanations)
        if truth is not None:
            content["colourings"].append(errors.of_map(dense))
    if result.votes is not None and result.source is not None and result.target is not None:
        from .insight import insight

        found = insight(result.source, result.target, result.votes, result.pairs)
        if found is not None:
            content["insight"] = found
    return content
