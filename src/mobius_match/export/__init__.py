"""Matches and dense maps for other programs, and landmarks from them; docs/formats.md tells what each format holds."""

from .formats import FORMATS, export, marks_writer, outputs_of, read_landmarks, read_specimens

__all__ = ["FORMATS", "export", "marks_writer", "outputs_of", "read_landmarks", "read_specimens"]
