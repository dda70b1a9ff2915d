"""The shape of recovered matches, and the direction of view."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius_match.exporting.scene import colours_of
from tests.exporting.test_figures import ball, drawn, halves, result_of, saturated


def test_recovered_matches_are_diamonds():
    """A disc fills pi / 4 of its bounding box, a diamond half of it."""
    mesh, ends = ball()
    result = result_of(mesh, mesh, [(ends[2], ends[2])])
    filled = []
    for kind in ("voted", "recovered"):
        spot = saturated(halves(drawn(replace(result, kind=np.array([kind])), size=(1000, 500)))[0])
        rows, columns = np.nonzero(spot)
        filled.append(len(rows) / ((np.ptp(rows) + 1) * (np.ptp(columns) + 1)))
    assert filled == pytest.approx([np.pi / 4, 0.5], abs=0.06)


@pytest.mark.parametrize(("view", "end"), [((0, 0), 2), ((90, 0), 0), ((0, 90), 1), ((-90, 0), 3), ((180, 0), 5)])
def test_the_direction_to_look_from_can_be_chosen(view, end):
    mesh, ends = ball()
    half = halves(drawn(result_of(mesh, mesh, [(i, i) for i in ends]), view=view))[0]
    colours = colours_of(mesh[0][ends] / np.linalg.norm(mesh[0][ends][0]))
    middle = half[95:105, 95:105].reshape(-1, 3).mean(axis=0)
    hue = [colour - colour.mean() for colour in (middle, *colours)]
    alike = [hue[0] @ other / np.linalg.norm(other) for other in hue[1:]]
    assert int(np.argmax(alike)) == end
