"""Sections 4 and 5: a mesh made ready for matching."""
