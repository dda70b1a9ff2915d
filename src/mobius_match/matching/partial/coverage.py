"""How much of each other two surfaces cover."""

from __future__ import annotations

from enum import Enum


class Coverage(Enum):
    """How much of each other two surfaces cover."""

    WHOLE = "whole"
    """Each of them covers the other one."""

    PART = "part"
    """One of them is a part of the other one."""

    BOTH_INCOMPLETE = "both incomplete"
    """Each of them may lack a part that the other one has."""
