"""The ends of limbs, and all likely ways to match them."""

import numpy as np
import pytest

import mobius_match as mm
from mobius_match.alignments.extremities import LIKELY, MOST, extremities, extremity_matchings, extremity_triplets
from mobius_match.evaluation import examples
from tests.shapes import ellipsoid, renumbered


@pytest.fixture(scope="module")
def people():
    return [mm.prepare(path) for path in examples.paths("person")]


def true_places(source, target):
    """Where the source's samples belong on the target, (N1, 3)."""
    mesh = mm.read_mesh(examples.paths("person")[1])
    faces, barycentric = examples.truth("person")
    places = np.einsum("ijk,ij->ik", mesh.vertices[mesh.faces[faces]], barycentric)
    return places[source.mesh.vertex_ids[source.samples]]


def test_a_person_has_a_head_two_hands_and_two_feet(people):
    for person in people:
        ends = extremities(person)
        assert len(ends) == 5
        apart = person.normalized_distances[np.ix_(ends, ends)][np.triu_indices(5, 1)]
        assert apart.min() > 0.25
        central = person.average_distances[ends]
        assert (np.diff(central) <= 0).all()
        assert central.min() > np.median(person.average_distances)


def test_the_right_way_to_match_tips_is_among_the_likeliest(people):
    source, target = people
    truth, height = true_places(source, target), np.ptp(target.mesh.vertices, axis=0).max()
    ways = extremity_matchings(source, target)
    assert 0 < len(ways) <= LIKELY
    apart = [
        np.linalg.norm(target.mesh.vertices[target.samples[way[:, 1]]] - truth[way[:, 0]], axis=1).max() / height
        for way in ways
    ]
    assert min(apart[:8]) < 0.1
    assert max(apart) > 0.5, "all ways that are likely, not the right one alone"
    for way in ways:
        assert way.shape[0] >= 4
        assert len(set(way[:, 0])) == len(set(way[:, 1])) == len(way)


def test_three_of_the_matched_tips_tell_where_all_samples_go(people):
    source, target = people
    truth, height = true_places(source, target), np.ptp(target.mesh.vertices, axis=0).max()
    errors = []
    for pairs, triplet_weights in extremity_triplets(source, target):
        assert len(pairs) == len(triplet_weights)
        best = pairs[triplet_weights.argmax()]
        paired = np.flatnonzero(best >= 0)
        places = target.mesh.vertices[target.samples[best[paired]]]
        errors.append(np.linalg.norm(places - truth[paired], axis=1).mean() / height)
    assert min(errors) < 0.1


def test_numbers_of_vertices_do_not_matter(people):
    source, _ = people
    copy, new = renumbered((source.mesh.vertices, source.mesh.faces))
    other = mm.prepare(copy)
    here, there = (
        set(map(tuple, one.mesh.vertices[one.samples[extremities(one)]].round(6)))
        for one in (mm.prepare(source), other)
    )
    assert here == there
    assert len(new) == len(source.mesh.vertices)


def test_what_has_fewer_than_three_tips_has_no_groups():
    cigar = mm.prepare(ellipsoid((1.0, 1.0, 4.0)))
    assert 0 < len(extremities(cigar)) <= MOST
    assert len(extremities(cigar)) == 2
    assert extremity_triplets(cigar, cigar) == []
