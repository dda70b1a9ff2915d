"""Sums over neighbourhoods against sums over all pairs of points."""

import numpy as np

from mobius_match.registration.energy import covariances, rotated_edge_sums


def test_sums_are_those_over_all_pairs():
    generator = np.random.default_rng(0)
    joined = np.triu(generator.random((30, 30)) < 0.2, 1)
    joined[:, 7] = joined[7] = False  # a point without neighbours
    joined |= joined.T
    rest, moved = generator.standard_normal((2, 30, 3))
    turns = generator.standard_normal((30, 3, 3))
    start, end = np.nonzero(joined)
    starts = np.searchsorted(start, np.arange(31))
    edges = rest[start] - rest[end]
    before, after = (points[:, None] - points for points in (rest, moved))
    np.testing.assert_allclose(
        covariances(starts, end, edges, moved), np.einsum("ij,ija,ijb->iab", joined, before, after), atol=1e-12
    )
    means = (turns[:, None] + turns) / 2
    np.testing.assert_allclose(
        rotated_edge_sums(starts, end, edges, turns), np.einsum("ij,ija,ijab->ib", joined, before, means), atol=1e-12
    )
