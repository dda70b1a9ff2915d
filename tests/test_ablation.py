"""The ablation's rows: each leaves out something that is there, and a pair can be matched without it."""

import numpy as np
import pytest

import mobius_match as mm
from benchmarks.ablation import WITHOUT, record_without, reversed_case
from mobius_match.evaluation import Case, Truth, examples
from mobius_match.evaluation.summary import headline

LEFT_OUT = (
    "nothing left out",
    "choice: strain of close ones",
    "transport (nearest points)",
    "registration",
    "confidence: stretch",
)


@pytest.fixture(scope="module")
def case():
    source, target = examples.paths("quadruped")
    faces, barycentric = examples.truth("quadruped")
    corners = mm.read_mesh(target).faces[faces]
    there = corners[np.arange(len(corners)), barycentric.argmax(axis=1)]
    return Case("quadruped", "", source, target, Truth(np.arange(len(there)), there))


@pytest.mark.parametrize("name", list(WITHOUT))
def test_what_is_left_out_is_there(name):
    _, patches = WITHOUT[name]
    with patches():
        pass


def test_a_pair_is_matched_without_it_and_worse_without_the_registration(case, tmp_path):
    records = {name: record_without(case, tmp_path, name) for name in LEFT_OUT}
    assert {record["error"] for record in records.values()} == {None}
    whole, unbent = (headline([records[name]], "direct")["mean45"] for name in ("nothing left out", "registration"))
    assert whole < unbent


def test_a_pair_is_matched_the_other_way_round(case, tmp_path):
    back = reversed_case(case)
    assert (back.source, back.target) == (case.target, case.source)
    record = record_without(back, tmp_path, "nothing left out", seed=1)
    assert headline([record], "direct")["mean45"] < 0.05
