"""Formulas as MathML, which browsers draw by themselves: no page loads a script or a font for them."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import SphinxError
from sphinx.util.math import get_node_equation_number


def markup(latex: str, display: str) -> str:
    """One formula; a command that the converter does not know is an error, since it would be shown as it is written."""
    found = convert(latex, display=display)
    if "\\" in found:
        raise SphinxError(f"formula has a command that cannot be converted to MathML: {latex}")
    return found


def inline(writer: Any, node: nodes.math) -> None:
    """Called by Sphinx for a formula in a line of text."""
    writer.body.append(markup(node.astext(), "inline"))
    raise nodes.SkipNode


def block(writer: Any, node: nodes.math_block) -> None:
    """Called by Sphinx for a formula on lines of its own."""
    writer.body.append(writer.starttag(node, "div", CLASS="math"))
    if node["number"]:
        number = get_node_equation_number(writer, node)
        writer.body.append(f'<span class="eqno">({number})</span>')
    writer.body.append(markup(node.astext(), "block") + "</div>\n")
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True}
