"""Files of matches and dense maps for other programs (docs/formats.md), and pictures of them."""

from .formats import FORMATS, export, outputs_of

__all__ = ["FORMATS", "export", "outputs_of"]
