"""After the site is made: every link inside it leads somewhere, and no page loads anything from the network."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from sphinx.util.logging import getLogger

logger = getLogger(__name__)


class Page(HTMLParser):
    """What a page links to, what it loads, and the places in it that can be linked to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.loaded: set[str] = set()
        self.places = {"", "top"}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Called by the parser at each element."""
        found = {name: value or "" for name, value in attrs}
        self.places |= {found[name] for name in ("id", "name") if name in found}
        if "src" in found or tag == "link":
            self.loaded.add(found.get("src") or found.get("href", ""))
        elif "href" in found:
            self.links.add(found["href"])
        self.loaded |= {part.split()[0] for part in found.get("srcset", "").split(",") if part.strip()}


def faults(folder: Path) -> list[str]:
    """One line for each dead link, and for each thing that a page would load from elsewhere."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        for link in sorted(page.links | page.loaded):
            where = urlsplit(link)
            if where.scheme or where.netloc:
                if link in page.loaded and where.scheme != "data":
                    found.append(f"{path.name}: loads {link}")
                continue
            goal = (path.parent / unquote(where.path)).resolve() if where.path else path
            if not goal.is_file():
                found.append(f"{path.name}: {link} leads nowhere")
            elif goal in pages and unquote(where.fragment) not in pages[goal].places:
                found.append(f"{path.name}: {link}: no such place on that page")
    for path in sorted(folder.rglob("*.css")):
        loaded = re.findall(r"""(?:url\(|@import)\s*["']?((?:https?:)?//[^"')]+)""", path.read_text(encoding="utf-8"))
        found += [f"{path.name}: loads {link}" for link in loaded]
    return found


def check(app: Any, failed: Exception | None) -> None:
    """Called by Sphinx at the end."""
    if failed is None and app.builder.name == "html":
        for fault in faults(Path(app.outdir).resolve()):
            logger.warning(fault)


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("build-finished", check)
    return {"parallel_read_safe": True}
