"""Display of a page: in the notebook, or in the browser if there is no notebook."""

from __future__ import annotations

import html
import logging
import os
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from pathlib import Path

from .._core.files import write_atomically

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class View:
    """A page that a notebook displays.

    Parameters
    ----------
    html
        The text of an HTML file.
    """

    html: str

    def __repr__(self) -> str:
        return f"<View: a page of {len(self.html):,} characters; save(path) writes it>"

    def _repr_html_(self) -> str:
        # A frame isolates the page from the notebook.
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts allow-downloads" '
            'title="Matches on both shapes" style="width: 100%; height: 640px; border: 0"></iframe>'
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file completely or not at all; an existing file is replaced.

        Parameters
        ----------
        path
            The file, with the ending .html.
        """
        write_atomically(Path(path), self.html.encode())


def displayed(content: str) -> View:
    """A page for display in a notebook; without a notebook it is also opened in the browser."""
    view = View(content)
    if not in_notebook():
        path, opened = open_in_browser(content)
        if not opened:
            log.warning("no browser was found; open %s in one", path)
    return view


def in_notebook() -> bool:
    """Whether this runs in a notebook, that is in IPython with a kernel."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None


def open_in_browser(content: str) -> tuple[Path, bool]:
    """Write a page to a temporary file and open it; the file, and whether a browser was found."""
    # The file stays, as the browser may read it after this process has ended.
    with tempfile.NamedTemporaryFile(prefix="mobius-", suffix=".html", delete=False) as file:
        file.write(content.encode())
    path = Path(file.name)
    return path, webbrowser.open(path.as_uri())
