"""Sections 6 and 7: Möbius voting."""

from .votes import Votes, cast_votes

__all__ = ["Votes", "cast_votes"]
