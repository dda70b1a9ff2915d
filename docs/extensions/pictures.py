"""Pictures that a gallery script writes as PNG files into its folder are shown where it wrote them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst


def scrape(_block: Any, variables: dict[str, Any], config: dict[str, Any]) -> str:
    """Called by sphinx-gallery after each block of a script."""
    written = sorted(Path(variables["src_file"]).parent.glob("*.png"))
    places = [place for _, place in zip(written, variables["image_path_iterator"], strict=False)]
    for picture, place in zip(written, places, strict=True):
        picture.replace(place)
    return figure_rst(places, config["src_dir"])


def _get_sg_image_scraper() -> Any:
    return scrape
