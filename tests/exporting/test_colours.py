"""Colours of matches and of colour scales, as they appear with a colour-vision deficiency."""

import numpy as np
import pytest

from mobius_match.exporting.scene import colours_of
from mobius_match.viewer import packing

# G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, "A physiologically-based model for simulation of color vision
# deficiency", 2009: linear sRGB, severity 1.
SEEN = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
LMS = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
]
LAB = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
]


def perceived(colours, kind):
    """Lightness and two axes of colour (n, 3) in Oklab, where equal distances look about equal."""
    linear = np.clip(colours**2.2 @ np.array(SEEN[kind]).T, 0, 1)
    return np.cbrt(linear @ np.array(LMS).T) @ np.array(LAB).T


def rgb(stops):
    return np.array([[int(stop[k : k + 2], 16) / 255 for k in (1, 3, 5)] for stop in stops])


@pytest.mark.parametrize("kind", SEEN)
def test_matches_half_a_shape_apart_differ(kind):
    seen = perceived(colours_of(np.linspace([-1, 0, 0], [1, 0, 0], 41)), kind)
    differences = np.linalg.norm(seen[:, None] - seen[None], axis=2)
    far = np.abs(np.subtract.outer(np.arange(41), np.arange(41))) >= 20
    assert differences[far].min() > 0.12
    assert differences[0, -1] > 0.3


@pytest.mark.parametrize("kind", SEEN)
def test_scales_keep_their_order(kind):
    rising, diverging = (perceived(rgb(stops), kind) for stops in (packing.RISING, packing.DIVERGING))
    assert (np.diff(rising[:, 0]) < -0.1).all()  # monotonically darker
    assert (np.diff(diverging[:, 0]) * [1, 1, -1, -1] > 0.1).all()  # darker towards both ends
    for k in (0, 1):
        assert np.linalg.norm((diverging[k] - diverging[-1 - k])[1:]) > 0.1  # both ends differ in hue
