"""What holds for any triplets and any matches: clusters are disjoint, rows of a coarse map sum to 1."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import mobius_match as mm
from mobius_match.alignments.clusters import agreed_matches, cluster_triplets, most_consistent_half
from mobius_match.alignments.coarse_map import coarse_map
from mobius_match.alignments.parameters import CoarseMapParameters
from tests.shapes import lump

triplets = arrays(int, st.tuples(st.integers(1, 30), st.just(6)), elements=st.integers(-1, 4))
lines = arrays(float, 5, elements=st.floats(0, 1))


@given(pairs=triplets, line=lines, radius=st.floats(0.01, 1), most=st.integers(1, 40), data=st.data())
def test_clusters_are_disjoint_and_within_a_radius_of_their_centres(pairs, line, radius, most, data):
    distances, least = np.abs(line[:, None] - line), 0.6
    weights = np.array(sorted(data.draw(st.lists(st.floats(0.1, 1), min_size=len(pairs), max_size=len(pairs)))))[::-1]
    clusters = cluster_triplets(pairs, distances, weights, radius, least, most)
    members = np.concatenate(clusters)
    assert len(np.unique(members)) == len(members)
    heavy = np.flatnonzero(weights >= least * weights.max())
    assert set(members.tolist()) <= set(heavy.tolist())
    assert len(clusters) <= most
    if len(clusters) < most:
        assert len(members) == len(heavy)
    centres = [cluster[0] for cluster in clusters]
    assert centres == sorted(centres)
    for k, cluster in enumerate(clusters):
        assert cluster[0] == cluster.min()
        for centre in centres[: k + 1]:
            for member in cluster[1:]:
                both = (pairs[member] >= 0) & (pairs[centre] >= 0)
                apart = distances[pairs[member, both], pairs[centre, both]].mean() if both.any() else np.inf
                assert (apart < radius) == (centre == cluster[0]), "in the first cluster that it fits into"


@given(pairs=triplets)
def test_the_consistent_half_of_a_cluster_is_a_half_with_its_centre(pairs):
    cluster = np.arange(len(pairs))
    distances = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    half = most_consistent_half(pairs, distances, cluster)
    assert len(half) == (len(cluster) + 1) // 2
    assert (np.diff(half) > 0).all()
    if (pairs[0] >= 0).any():
        assert half[0] == 0


@given(pairs=triplets)
def test_agreed_matches_use_each_sample_once_and_only_pairs_of_the_cluster(pairs):
    matches = agreed_matches(pairs, np.ones(len(pairs)), 5, 60)
    for column in matches.T:
        assert len(set(column.tolist())) == len(column)
    assert all((pairs[:, i] == j).any() for i, j in matches.tolist())
    assert len(matches) > 0 or (pairs == -1).all()


@pytest.fixture(scope="module")
def surfaces():
    vertices, faces = lump(2)
    return mm.prepare((vertices, faces), samples=30), mm.prepare((vertices * [1, 1, 1.4], faces), samples=25)


@settings(max_examples=10)
@given(matches=st.lists(st.tuples(st.integers(0, 29), st.integers(0, 24)), min_size=1, max_size=12, unique=True))
def test_rows_of_a_coarse_map_sum_to_1(surfaces, matches):
    source, target = surfaces
    found = coarse_map(source, target, np.array(matches), CoarseMapParameters())
    assert found.shape == (len(source.proxy), len(target.proxy))
    assert (found >= 0).all()
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-3)
