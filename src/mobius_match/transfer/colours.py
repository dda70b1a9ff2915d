"""The colour of surfaces without colours of their own, and of what has no counterpart."""

from __future__ import annotations

import numpy as np

SURFACE_GREY = (0.80, 0.81, 0.83)
"""sRGB from 0 to 1, in pictures and animations."""

GREY = np.array([*(round(255 * value) for value in SURFACE_GREY), 255], np.uint8)
"""The same as RGBA from 0 to 255, in mesh files."""
