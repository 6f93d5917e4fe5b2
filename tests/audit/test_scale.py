"""A scale cuts runs and nothing else; signals that are too short for a number have none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crosscheck import signals
from crosscheck.audit.experiments.experiments import BACK, CONSTANT, NO_ERROR, PD, build_question
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.scale import FULL, Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.hypotheses.damping_fit import torque_reversals
from crosscheck.audit.hypotheses.evidence.linear_limits import growth_rate
from crosscheck.audit.phase.handover import CELLS, LAWS_AFTER_SWITCH, run_handover
from crosscheck.audit.phase.runs import vibration
from crosscheck.audit.phase.stability import run_stability_test


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
    assert signals.settling_time(NOTHING, NOTHING, 0.0, 1.0) is None
    assert math.isnan(signals.dominant_frequency(NOTHING, NOTHING))
    assert vibration(np.arange(10) * 1e-5, np.ones(10)).size == 10


def test_a_still_signal_has_no_frequency_and_an_unknown_target_is_not_reached():
    time = np.arange(100) * 1e-3
    assert math.isnan(signals.dominant_frequency(time, np.ones(100)))
    assert signals.settling_time(time, np.ones(100), math.nan, 1.0) is None


def test_a_measure_has_the_same_numbers_for_a_run_of_any_length():
    variants = [Variant(duration_s=d, record_every=2) for d in (0.002, 0.02, 0.3)]
    runs = list(map(simulate, variants))
    grown = [growth_rate(run) for run in runs]
    assert set(grown[0]) == set(grown[1]) == set(grown[2])
    for numbers in [*(one.values() for one in grown), *map(torque_reversals, runs)]:
        assert all(value is None or math.isfinite(value) for value in numbers)


@pytest.mark.parametrize("source", [PD, NO_ERROR, CONSTANT, BACK(50)], ids=str)
def test_an_experiment_measures_the_same_numbers_whatever_its_length(source):
    asked = build_question(source, Condition(INTEGRAL, 0.05), (1,))
    names = [
        set(replace(asked, variant=replace(asked.variant, duration_s=d)).answer().numbers)
        for d in (0.002, 0.02, 0.3)
    ]
    assert names[0] == names[1] == names[2]


@pytest.mark.slow
def test_a_vibration_that_is_reached_is_followed_and_handed_over(tmp_path_factory):
    """Just past half a second there is something to linearise and to hand over, if not much."""
    study = Study(tmp_path_factory.mktemp("kept"))
    scale = Scale(longest_s=0.55, most_starts=2)
    followed, handed = run_stability_test(study, scale), run_handover(study, scale)
    assert all(one.largest is not None for one in followed.cells.values())
    assert all(one.onsets and one.begins is not None for one in followed.cells.values())
    assert len(handed.outcomes) == len(LAWS_AFTER_SWITCH) * len(CELLS)
    assert all(fate.asked == 2 for fate in handed.outcomes)
    before = [fate.before[1] for fate in handed.outcomes if fate.dying is not None]
    assert all(size is not None and size > 0 for size in before)
