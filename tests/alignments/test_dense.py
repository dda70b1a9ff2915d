"""Which of two surfaces is deformed to the other for the dense map."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from scipy.spatial import cKDTree

import mobius_match as mm
from mobius_match.alignments import dense
from mobius_match.alignments.alignment import Alignment
from mobius_match.alignments.evidence import evidence, log_odds
from mobius_match.alignments.parameters import AlignmentParameters
from tests.shapes import cap, disc

PARAMETERS = AlignmentParameters()
PARAMETERS = replace(PARAMETERS, selection=replace(PARAMETERS.selection, repeats=1))
NOTHING_IS_OPEN = replace(PARAMETERS, discs=replace(PARAMETERS.discs, least_rim=np.inf))


def test_of_two_open_surfaces_the_one_whose_registration_has_the_higher_score_is_deformed(monkeypatch):
    vertices, faces = cap(1, count=600)
    source, target = mm.prepare(cap(0, count=600)), mm.prepare((vertices * (1, 0.8, 1.3), faces))
    true_images = cKDTree(disc(600, seed=1)[0]).query(disc(600, seed=0)[0])[1]
    alignment = Alignment(true_images[source.proxy], {}, 1.0, 1.0)
    calls = []

    def record(first, second, registration, parameters):
        calls.append((first, second, registration))
        return SimpleNamespace(inverse="inverse")

    monkeypatch.setattr(dense, "dense_map", record)
    assert dense.dense_map_of_alignment(source, target, alignment, PARAMETERS) == "inverse"
    assert dense.dense_map_of_alignment(source, target, alignment, NOTHING_IS_OPEN) != "inverse"
    likelier, slimmer = calls
    assert slimmer[0] is source and source.normalized_distances.mean() > target.normalized_distances.mean()
    assert likelier[0] is target
    scores = log_odds([evidence(*likelier), evidence(*slimmer)], PARAMETERS.choice)
    assert scores[0] > scores[1]
