"""A part of a surface, located on the whole."""
