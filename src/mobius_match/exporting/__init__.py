"""Matches and dense maps for other programs, and pictures of them; docs/formats.md tells what each format holds."""

from .formats import FORMATS, export, outputs_of

__all__ = ["FORMATS", "export", "outputs_of"]
