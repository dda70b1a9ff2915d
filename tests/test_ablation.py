"""The ablation's rows: each leaves out something that is there, and a pair can be matched without it."""

import numpy as np
import pytest

import mobius_match as mm
from benchmarks.ablation import PARAMETERS, ROWS, SETTINGS, record_without, reversed_case
from mobius_match._core.parameters import parameters_of, varied
from mobius_match.evaluation import Case, Truth, examples
from mobius_match.evaluation.summary import headline
from mobius_match.matching.parameters import Parameters
from mobius_match.settings import make_settings

LEFT_OUT = (
    "nothing left out",
    "choice by evidence (least cost)",
    "transport (nearest points)",
    "registration beyond the initial placement",
    "confidence: strain",
)


@pytest.fixture(scope="module")
def case():
    source, target = examples.paths("quadruped")
    faces, barycentric = examples.truth("quadruped")
    corners = mm.read_mesh(target).faces[faces]
    there = corners[np.arange(len(corners)), barycentric.argmax(axis=1)]
    return Case("quadruped", "", source, target, Truth(np.arange(len(there)), there))


@pytest.mark.parametrize("name", ROWS[1:])
def test_each_row_changes_a_setting_or_a_parameter(name):
    settings = make_settings(**SETTINGS.get(name, {}))
    parameters = varied(Parameters(), PARAMETERS.get(name, {}))
    assert settings != make_settings() or list(parameters_of(parameters)) != list(parameters_of(Parameters()))


def test_a_pair_is_matched_without_it_and_worse_without_the_registration(case, tmp_path):
    records = {name: record_without(case, tmp_path, name) for name in LEFT_OUT}
    assert {record["error"] for record in records.values()} == {None}
    names = "nothing left out", "registration beyond the initial placement"
    whole, initial = (headline([records[name]], "direct")["mean45"] for name in names)
    assert whole < initial


def test_a_pair_is_matched_the_other_way_round(case, tmp_path):
    back = reversed_case(case)
    assert (back.source, back.target) == (case.target, case.source)
    record = record_without(back, tmp_path, "nothing left out", seed=1)
    assert headline([record], "direct")["mean45"] < 0.05
