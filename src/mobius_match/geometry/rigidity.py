"""The two sums over neighbourhoods of as-rigid-as-possible bending (Sorkine and Alexa 2007), all weights 1.

The neighbours of point i are ``ends[starts[i] : starts[i + 1]]``; ``rest`` are the vectors from them to i before it
was bent.
"""

from __future__ import annotations

import numpy as np

from ..compiling import jit


@jit
def covariances(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Sums (p, 3, 3) over each point's neighbours of rest vectors times what they are between positions (p, 3)."""
    found = np.zeros((len(positions), 3, 3))
    for i in range(len(positions)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                moved = positions[i, axis] - positions[ends[edge], axis]
                for row in range(3):
                    found[i, row, axis] += rest[edge, row] * moved
    return found


@jit
def turned_sums(starts: np.ndarray, ends: np.ndarray, rest: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Sums (p, 3) over each point's neighbours of rest vectors, turned by the mean of the turns (p, 3, 3) of both."""
    found = np.zeros((len(turns), 3))
    for i in range(len(turns)):
        for edge in range(starts[i], starts[i + 1]):
            for axis in range(3):
                for row in range(3):
                    turn = turns[i, row, axis] + turns[ends[edge], row, axis]
                    found[i, axis] += 0.5 * rest[edge, row] * turn
    return found
