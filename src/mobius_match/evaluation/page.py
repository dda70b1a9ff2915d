"""HTML for reports: elements with escaped text, tables, embedded figures, one style sheet."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .._core.files import write_atomically


class Markup(str):
    """Text that is already HTML; all other text is escaped."""

    __slots__ = ()


def printable(text: object) -> str:
    """The text on one line; control characters and lone surrogates are replaced."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in " ".join(str(text).split()))


def tag(element: str, *children: object, **attributes: object) -> Markup:
    """An element; children are escaped unless they are Markup. The attribute class is written ``class_``."""
    inner = "".join(child if isinstance(child, Markup) else html.escape(printable(child)) for child in children)
    given = "".join(f' {name.rstrip("_")}="{html.escape(printable(v))}"' for name, v in attributes.items())
    return Markup(f"<{element}{given}>{inner}</{element}>\n")


def join(parts: Iterable[Markup]) -> Markup:
    """Pieces of HTML joined to one."""
    return Markup("".join(parts))


def number(value: float | None, digits: int = 3) -> str:
    """A float with a fixed number of decimals, an integer without, a dash for None or NaN."""
    if value is None or value != value:
        return "–"
    return f"{value:,d}" if isinstance(value, int) else f"{value:.{digits}f}"


def setting(value: Any) -> str:
    """The value of a setting as text."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {setting(item)}" for name, item in value.items())
    return "not set" if value is None else str(value)


def percent(value: float | None) -> str:
    """A share as a percentage."""
    return "–" if value is None or value != value else f"{100 * value:.1f} %"


def table(caption: str, header: Sequence[str], rows: Iterable[Sequence[Any]], class_: str = "") -> Markup:
    """A table; the first cell of each row is its heading."""
    head = tag("tr", *(tag("th", name, scope="col") for name in header))
    body = [tag("tr", tag("th", first, scope="row"), *(tag("td", cell) for cell in rest)) for first, *rest in rows]
    whole = tag("table", tag("caption", caption), tag("thead", head), tag("tbody", *body), class_=class_)
    return tag("div", whole, class_="wide", tabindex=0, role="region", **{"aria-label": caption})


def without_empty(header: Sequence[str], rows: list[list[str]]) -> tuple[list[str], list[list[str]]]:
    """Header and rows without the columns that contain only dashes."""
    kept = [k for k in range(len(header)) if any(row[k] != number(None) for row in rows)]
    return [header[k] for k in kept], [[row[k] for k in kept] for row in rows]


def picture(content: bytes, kind: str, alternative: str, caption: str) -> Markup:
    """A picture embedded in the page; ``kind`` is ``"svg+xml"`` or ``"png"``."""
    data = f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
    image = Markup(f'<img src="{data}" alt="{html.escape(printable(alternative))}">')
    return tag("figure", image, tag("figcaption", caption))


def figure(files: dict[str, bytes], name: str, drawn: tuple[bytes, bytes], alternative: str, caption: str) -> Markup:
    """Add the SVG and the PNG of a figure to the files, and return the HTML that embeds it."""
    files[f"{name}.svg"], files[f"{name}.png"] = drawn
    return picture(drawn[0], "svg+xml", alternative, caption)


def save_figures(folder: Path, files: dict[str, bytes]) -> None:
    """Write the files into the subfolder ``figures``."""
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        write_atomically(folder / "figures" / name, content)


def tiles(values: Iterable[tuple[str, str]]) -> Markup:
    """The headline numbers, each with its name."""
    return tag("dl", *(tag("div", tag("dt", name), tag("dd", value)) for name, value in values), class_="tiles")


def section(title: str, *content: object, **attributes: object) -> Markup:
    """A section with a heading."""
    return tag("section", tag("h2", title), *content, **attributes)


def page(title: str, *content: object) -> bytes:
    """The content of the HTML file."""
    meta = Markup('<meta charset="utf-8">\n<meta name="viewport" content="width=device-width, initial-scale=1">\n')
    head = tag("head", meta, tag("title", title), tag("style", Markup(STYLE)))
    body = tag("body", tag("main", tag("h1", title), *content))
    return f'<!DOCTYPE html>\n<html lang="en">\n{head}{body}</html>\n'.encode()


STYLE = """
:root { color-scheme: light; --line: #c9ced6; --soft: #f3f5f8; --ink: #1b2430; --quiet: #566172; }
* { box-sizing: border-box; }
body { margin: 0; background: white; color: var(--ink); font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .3rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2.6rem 0 .6rem; padding-top: .6rem; border-top: 2px solid var(--ink); }
p { max-width: 46rem; margin: .5rem 0; overflow-wrap: anywhere; }
.quiet, figcaption, caption { color: var(--quiet); font-size: .9rem; }
.alert { border: 2px solid #a33b00; border-left-width: 8px; padding: .5rem 1rem; margin: 1rem 0; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: .6rem; margin: 1.2rem 0; }
.tiles div { background: var(--soft); border: 1px solid var(--line); border-radius: 6px; padding: .6rem .8rem; }
.tiles div { display: flex; flex-direction: column; justify-content: space-between; }
.tiles dt { color: var(--quiet); font-size: .82rem; line-height: 1.3; }
.tiles dd { margin: .2rem 0 0; font-size: 1.45rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.wide { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; min-width: min(100%, 24rem); font-size: .9rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding-bottom: .4rem; position: sticky; left: 0; max-width: calc(100vw - 3rem); }
th, td { padding: .25rem .7rem; border-bottom: 1px solid var(--line); text-align: right; vertical-align: top; }
thead th { border-bottom: 2px solid var(--ink); vertical-align: bottom; }
th:first-child { text-align: left; padding-left: 0; }
tbody th { font-weight: 500; }
td, tbody th { white-space: nowrap; }
.text th, .text td { text-align: left; }
.text td, .prose tbody th { white-space: normal; overflow-wrap: anywhere; min-width: 9rem; }
tbody tr:hover { background: var(--soft); }
figure { margin: 1.2rem 0; }
figure img { display: block; max-width: 100%; height: auto; }
figcaption { max-width: 52rem; margin-top: .4rem; overflow-wrap: anywhere; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 480px), 1fr)); gap: 0 1.5rem; }
dl.definitions dt { font-weight: 600; margin-top: .7rem; }
dl.definitions dd { margin: 0; max-width: 46rem; }
summary { cursor: pointer; font-weight: 600; }
@media screen and (max-width: 640px) {
  figure { overflow-x: auto; }
  figure img[src^="data:image/svg"] { max-width: none; width: 38rem; }
  th, td { padding: .25rem .4rem; }
}
@media print {
  @page { margin: 14mm; }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  h2, h2 + p { break-after: avoid; }
  figure, tr, .tiles div { break-inside: avoid; }
  figure img { max-height: 240mm; }
  .wide { overflow: visible; break-inside: avoid; }
  .grid { grid-template-columns: 1fr 1fr; }
  table { font-size: 8pt; }
  th, td { padding: .15rem .4rem; }
}
"""
