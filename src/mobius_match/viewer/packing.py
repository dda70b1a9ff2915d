"""Numbers and colours as compact text, which viewer/data.js reads."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

STEPS = 65534
"""Steps to which coordinates are quantised; the next number, 65535, means none."""
SHADES = 254
"""Steps of a value along a colour scale; the next number, 255, means none."""
NOTHING = np.array([0.45, 0.45, 0.47])
"""Grey, the colour of points without counterpart."""

DIVERGING = ("#1f5aa6", "#92c5de", "#f7f7f7", "#f4b166", "#a64905")
RISING = ("#fbf3d5", "#f2c166", "#d97f3c", "#933d4e", "#2e144f")
"""Colour scales that are legible with red-green blindness."""


def packed(values: np.ndarray, kind: str) -> str:
    """The bytes of the values in base64."""
    return base64.b64encode(np.ascontiguousarray(values).astype(kind).tobytes()).decode()


def quantised(points: np.ndarray) -> dict[str, Any]:
    """Points (..., k) without NaN: the lowest corner of their box, the size of a step, and whole numbers of steps."""
    flat = points.reshape(-1, points.shape[-1])
    low, step = flat.min(axis=0), np.ptp(flat, axis=0) / STEPS
    codes = np.round((points - low) / np.where(step > 0, step, 1))
    return {"low": low.tolist(), "step": step.tolist(), "codes": packed(codes, "<u2")}


def colours(values: np.ndarray) -> str:
    """Colours (n, 3) from 0 to 1, with one byte per channel; NaN is grey."""
    return packed(np.round(255 * np.where(np.isnan(values), NOTHING, values)), "u1")


def shades(values: np.ndarray) -> str:
    """Values (n,), from 0 to 1 along a scale, with one byte each; NaN is 255."""
    return packed(np.where(np.isnan(values), SHADES + 1, np.round(SHADES * np.nan_to_num(values).clip(0, 1))), "u1")
