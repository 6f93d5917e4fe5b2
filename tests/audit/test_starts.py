"""A start measures what it would alone; a scale cuts runs; what is unknown decides nothing."""

import math
from dataclasses import replace
from itertools import product
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck import signals
from crosscheck.audit.experiments import ensembles, experiments
from crosscheck.audit.experiments.ensembles import EnsembleNumbers, EnsembleNumbersQuestion
from crosscheck.audit.experiments.experiments import BACK, CONSTANT, NO_ERROR, PD, build_question
from crosscheck.audit.experiments.paper_conditions import (
    CONSERVATIVE,
    INTEGRAL,
    LAWS,
    PRINTED,
    Condition,
)
from crosscheck.audit.experiments.pd import measure_transient_pd
from crosscheck.audit.experiments.samples import FULL, Scale, build_sample, collect_samples
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import COUPLED, Variant, rigid_arm
from crosscheck.audit.measures.run_signals import (
    JOINT_SIGNALS,
    MESH_SIGNALS,
    extract_signals,
    simulate_signals,
)
from crosscheck.audit.measures.undefined import UNDEFINED, combine_answers, format_number
from crosscheck.models.errors import Diverged
from crosscheck.registry import build
from tests.audit.runs import simulate

CLOCKED = Condition(PRINTED, 0.005)
BRIEF_S = 0.02


def _brief(source, seeds=(1, 2, 3), cell=CLOCKED):
    asked = experiments.build_question(source, cell, seeds)
    return replace(asked, variant=replace(asked.variant, duration_s=BRIEF_S))


@pytest.mark.parametrize("planets", ["free", "lumped"])
def test_a_start_measures_what_its_run_alone_does(planets):
    """To rounding, for the kernel of one member adds in another order than that of lanes."""
    asked = EnsembleNumbersQuestion(
        replace(_brief(experiments.NO_ERROR).variant, planets=planets), (4, 5, 6)
    )
    found = asked.answer()
    run = extract_signals(simulate(replace(asked.variant, seed=5)))
    rigid = extract_signals(simulate(rigid_arm(asked.variant, COUPLED))).at(run.time)
    alone = measure_transient_pd(run, rigid)
    defined = {name: value for name, value in alone.items() if value is not None}
    assert {"first", "mesh_over_gross", "planets_apart_m"} <= set(defined)
    own = {name: values[1] for name, values in found.numbers.items() if values[1] is not None}
    assert own == pytest.approx(defined, rel=1e-6, abs=1e-12)
    assert found.diverged_s == [None] * 3


def test_a_course_holds_what_the_trajectory_does():
    """To rounding, as above."""
    variant = replace(_brief(experiments.PD).variant, seed=3)
    (course,) = simulate_signals([build(variant.model, *variant.case())])
    trajectory = simulate(variant)
    run = extract_signals(trajectory)
    assert run.planet_spread_m == np.ptp(trajectory["x_pr"].values, axis=2).max()
    for name in ("time", *JOINT_SIGNALS, *MESH_SIGNALS, "F_outer"):
        one, other = getattr(course, name), getattr(run, name)
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(other).max())
    assert course.planet_spread_m == pytest.approx(run.planet_spread_m, rel=1e-6)
    assert course.planet_spread_m > 0


@pytest.mark.parametrize("law", [*LAWS, CONSERVATIVE], ids=lambda law: law.id)
def test_a_setting_is_run_under_its_law(law):
    case = experiments.build_question(
        experiments.PD, Condition(law, 0.02, "paper-swapped"), (1,)
    ).variant.case()
    chosen = case.switches
    assert (chosen.phase, chosen.ring_rate, chosen.mesh_work) == law
    assert chosen.planets == "free"
    assert case.arm.name == "paper-swapped"
    assert case.arm.joints[0].sun_mesh.damping_ratio == 0.02


def test_other_seeds_are_other_starts(tmp_path):
    study, wanted = Study(tmp_path), [(CLOCKED, experiments.NO_ERROR)]
    first, other = (
        collect_samples(
            study, Scale(longest_s=BRIEF_S, most_starts=2, first_seed=seed), wanted, "test"
        )
        for seed in (1, 3)
    )
    ((one,), (two,)) = (found.values() for found in (first, other))
    apart = [*one["planets_apart_m"], *two["planets_apart_m"]]
    assert len(set(apart)) == len(apart)


def test_a_start_that_diverged_has_no_numbers():
    sample = build_sample(EnsembleNumbers({"third": [1.0, None]}, [None, 0.3], 2))
    assert sample["third"][0] == 1.0
    assert np.isnan(sample["third"][1])
    assert list(sample.diverged) == [False, True]
    with pytest.raises(KeyError):
        sample["thrid"]


def test_where_all_diverged_every_number_is_undefined():
    sample = build_sample(EnsembleNumbers({}, [0.1, 0.2], 2))
    assert np.isnan(sample["third"]).all()


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("no backlash", {"backlash_m": 0.0}),
        ("turning back, b = 3000 um", {"backlash_m": 3e-3}),
        ("back and forth evenly, backlash 500 um", {"backlash_m": 5e-4}),
        ("backlash, no error 5 um", {"backlash_m": 5e-6, "tooth_error_m": 0.0}),
        ("constant torque, no error", {"tooth_error_m": 0.0}),
        ("tooth error 6.3 um", {"tooth_error_m": 6.3e-6}),
        ("constant stiffness", {"stiffness": {"amplitude_N_per_m": 0.0}}),
    ],
)
def test_an_experiment_changes_its_own_fields_of_every_mesh(name, changes):
    """Looked up in the case that is run; nothing else of a mesh is another."""
    variant = experiments.build_question(experiments.find_experiment(name), CLOCKED, ()).variant
    changed, own = (each.case().arm.joints for each in (variant, replace(variant, meshes=())))
    for joint, side in product((0, 1), ("sun_mesh", "ring_mesh")):
        mesh, before = (getattr(joints[joint], side).model_dump() for joints in (changed, own))
        right = before | changes | {"stiffness": before["stiffness"] | changes.get("stiffness", {})}
        assert right.pop("stiffness") == mesh.pop("stiffness")
        assert mesh == pytest.approx(right)


def test_a_run_is_cut_if_it_is_longer_and_so_is_the_scenarios_own_duration():
    for longest, own, cut in ((1.0, 0.5, 0.5), (1.0, 3.0, 1.0), (math.inf, 3.0, 3.0)):
        scale = Scale(longest_s=longest)
        assert scale.cut(Variant(duration_s=own)).case().scenario.duration_s == cut
        assert scale.limit_duration(own) == cut
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


NUMBER = st.one_of(st.none(), st.floats())
YES = st.sampled_from([True, False, None])


@given(one=YES, other=YES, third=YES)
def test_open_decisions_leave_the_whole_open(one, other, third):
    answer = combine_answers((one, other, third))
    assert answer in (True, False, None)
    assert (answer is True) == (one is other is third is True)


@given(value=NUMBER)
def test_a_number_that_is_none_is_a_word(value):
    assert (format_number(value) == UNDEFINED) == (value is None or not math.isfinite(value))


def test_a_run_that_diverges_keeps_its_place(monkeypatch):
    monkeypatch.setattr(ensembles, "extract_signals", lambda run: run)
    diverged = Mock(side_effect=Diverged("a model", 0.1))
    models = [Mock(simulate=each) for each in (diverged, Mock(return_value="run"))]
    assert ensembles.run_side_by_side(models) == [diverged.side_effect, "run"]
