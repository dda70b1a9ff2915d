"""The truth between known points, as the benchmark of coarse truth interpolates it."""

import numpy as np

from benchmarks.coarse_truth import carried
from mobius_match.mesh import as_mesh

from .shapes import lump, rotation


def test_truth_is_interpolated_between_known_points():
    """A rotated, larger copy: every vertex goes to its own, known or not, though only one in twenty is known."""
    vertices, faces = lump(4)
    source, target = as_mesh((vertices, faces)), as_mesh((3 * vertices @ rotation() + 5, faces))
    known = np.random.default_rng(1).permutation(len(vertices))[: len(vertices) // 20]
    every = np.arange(len(vertices))
    places, apart = carried(source, target, known, known, every)
    np.testing.assert_array_equal(places, every)
    assert (apart[known] == 0).all()
    assert apart.max() > 0
