"""A scale cuts runs and nothing else; signals that are too short for a number have none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck import signals
from crosscheck.audit.experiments.experiments import BACK, CONSTANT, NO_ERROR, PD, build_question
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.samples import FULL, Scale
from crosscheck.audit.experiments.variant import Variant


@pytest.mark.parametrize(
    ("longest", "own", "cut"), [(1.0, 0.5, 0.5), (1.0, 3.0, 1.0), (math.inf, 3.0, 3.0)]
)
def test_a_run_is_cut_if_it_is_longer(longest, own, cut):
    scale = Scale(longest_s=longest)
    assert scale.cut(Variant(duration_s=own)).case().scenario.duration_s == cut
    assert scale.limit_duration(own) == cut


def test_the_scenarios_own_duration_is_cut_as_well():
    assert Scale(longest_s=1.0).cut(Variant()) == Variant(duration_s=1.0)
    assert Scale(longest_s=1.0).cut(Variant("constant-torque")).duration_s == 0.5
    assert FULL.cut(Variant()) == Variant()


NOTHING = np.empty(0)


def test_nothing_has_no_size_and_no_event():
    for size in (signals.amplitude, signals.peak_to_peak, signals.middle, signals.mean_value):
        assert math.isnan(size(NOTHING))
    assert signals.onset(NOTHING, NOTHING) is None
    assert signals.crossing_time_below(NOTHING, NOTHING, 0.0) is None
    assert math.isnan(signals.dominant_frequency(NOTHING, NOTHING))


def test_a_still_signal_has_no_frequency():
    time = np.arange(100) * 1e-3
    assert math.isnan(signals.dominant_frequency(time, np.ones(100)))


@pytest.mark.parametrize("source", [PD, NO_ERROR, CONSTANT, BACK(50)], ids=str)
def test_an_experiment_measures_the_same_numbers_whatever_its_length(source):
    asked = build_question(source, Condition(INTEGRAL, 0.05), (1,))
    names = [
        set(replace(asked, variant=replace(asked.variant, duration_s=d)).answer().numbers)
        for d in (0.002, 0.02, 0.3)
    ]
    assert names[0] == names[1] == names[2]
