"""Correspondences between two surfaces by Möbius voting."""

__version__ = "0.1.0"
