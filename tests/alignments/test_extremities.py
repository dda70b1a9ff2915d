"""The extremities of a shape (head, hands, feet), and all likely ways to match them."""

import numpy as np

import mobius_match as mm
from mobius_match.alignments.extremities import extremities, extremity_matchings, extremity_triplets
from mobius_match.alignments.parameters import ExtremityParameters
from mobius_match.voting.parameters import VotingParameters
from tests.shapes import ellipsoid, renumbered, true_places

PARAMETERS = ExtremityParameters()


def places_of_samples(source):
    """Where the source's samples belong on the target, (N1, 3)."""
    return true_places("person")[source.mesh.vertex_ids[source.samples]]


def test_a_person_has_a_head_two_hands_and_two_feet(person):
    for pose in person:
        ends = extremities(pose, PARAMETERS)
        assert len(ends) == 5
        apart = pose.normalized_distances[np.ix_(ends, ends)][np.triu_indices(5, 1)]
        assert apart.min() > 0.25
        central = pose.average_distances[ends]
        assert (np.diff(central) <= 0).all()
        assert central.min() > np.median(pose.average_distances)


def test_the_right_matching_of_extremities_is_among_the_likeliest(person):
    source, target = person
    truth, height = places_of_samples(source), np.ptp(target.mesh.vertices, axis=0).max()
    ways = extremity_matchings(source, target, PARAMETERS, 0.1)
    assert 0 < len(ways) <= PARAMETERS.likely
    apart = [
        np.linalg.norm(target.mesh.vertices[target.samples[way[:, 1]]] - truth[way[:, 0]], axis=1).max() / height
        for way in ways
    ]
    assert min(apart[:8]) < 0.1
    assert max(apart) > 0.5, "all ways that are likely, not the right one alone"
    for way in ways:
        assert way.shape[0] >= 4
        assert len(set(way[:, 0])) == len(set(way[:, 1])) == len(way)


def test_three_matched_extremities_place_all_samples(person):
    source, target = person
    truth, height = places_of_samples(source), np.ptp(target.mesh.vertices, axis=0).max()
    errors = []
    for pairs, triplet_weights in extremity_triplets(source, target, PARAMETERS, 0.1, VotingParameters()):
        assert len(pairs) == len(triplet_weights)
        best = pairs[triplet_weights.argmax()]
        paired = np.flatnonzero(best >= 0)
        places = target.mesh.vertices[target.samples[best[paired]]]
        errors.append(np.linalg.norm(places - truth[paired], axis=1).mean() / height)
    assert min(errors) < 0.1


def test_the_numbering_of_the_vertices_does_not_matter(person):
    mesh = person[0].mesh
    copy, new = renumbered((mesh.vertices, mesh.faces))
    surfaces = mm.prepare(mesh), mm.prepare(copy)
    here, there = (surface.samples[extremities(surface, PARAMETERS)] for surface in surfaces)
    np.testing.assert_array_equal(new[here], there)


def test_fewer_than_three_extremities_give_no_triplets():
    cigar = mm.prepare(ellipsoid((1.0, 1.0, 4.0)))
    assert len(extremities(cigar, PARAMETERS)) == 2
    assert extremity_triplets(cigar, cigar, PARAMETERS, 0.1, VotingParameters()) == []
