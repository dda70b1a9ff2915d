"""How Sphinx makes the documentation site: ``make docs``."""

from __future__ import annotations

import dataclasses
import sys
import warnings
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

import mobius_match  # noqa: E402

project = "mobius-match"
author = "The mobius-match authors"
copyright = author
version = release = mobius_match.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "commands",
    "mathml",
    "whole",
]
exclude_patterns = ["gallery"]
smartquotes = False  # options begin with two hyphens

myst_enable_extensions = ["colon_fence", "dollarmath", "amsmath"]
myst_heading_anchors = 3

autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 600,  # the first script may have to compile
    "remove_config_comments": True,
    "image_scrapers": ("matplotlib", "pictures"),
    "write_computation_times": False,
}
suppress_warnings = ["config.cache"]
warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")

html_theme = "furo"
html_math_renderer = "mathml"
html_title = "mobius-match"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False


def without_fields(_app: Any, _what: str, _name: str, thing: Any, *_rest: Any) -> tuple[str, None] | None:
    """Records that the library fills in are listed without the long call that makes them."""
    made_by_users = ("MatchSettings", "PrepareSettings")
    hidden = dataclasses.is_dataclass(thing) and isinstance(thing, type) and thing.__name__ not in made_by_users
    return ("", None) if hidden else None


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-signature", without_fields)
