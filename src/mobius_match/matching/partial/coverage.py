"""How much of each other two surfaces cover, and which of them may be a part of the other one."""

from __future__ import annotations

from enum import Enum

from ...surface.surface import Surface
from .parameters import PartialParameters


class Coverage(Enum):
    """How much of each other two surfaces cover."""

    WHOLE = "whole"
    """Each of them covers the other one."""

    PART = "part"
    """One of them is a part of the other one."""

    BOTH_INCOMPLETE = "both incomplete"
    """Each of them may lack a part that the other one has."""


def may_be_part(surface: Surface, parameters: PartialParameters) -> bool:
    """Whether a surface may be a part of another one: one of its rims is long.

    The number of its small holes and its size in the file have no influence. It may be a whole surface all the same.
    """
    return surface.rim_length > parameters.opening
