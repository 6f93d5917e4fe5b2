"""Recorded motions: the true level is named, a wrong number found, and noise blamed for nothing."""

import re
import runpy
import sys
from collections.abc import Sequence
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.provenance import ROOT
from crosscheck.recordings.compare import Repair
from crosscheck.recordings.forward import run_windows
from crosscheck.recordings.gravity import GravityFit
from crosscheck.recordings.messages import describe_answers, format_estimate
from crosscheck.recordings.output import comparison_page, describe_comparison
from crosscheck.recordings.parameters import (
    Estimate,
    Parameter,
    apply_estimate,
    change_parameters,
    estimate_separately,
    find_parameters,
    increase_parameter,
)
from crosscheck.recordings.record import Record, read_record, require_same_units
from crosscheck.recordings.residual import build_normal_equations
from crosscheck.recordings.smoothing import select_spacing, smooth_record
from crosscheck.registry import RIGID_LEVELS
from tests.arms import arm_of
from tests.measured.records import ANGLE_NOISE, TORQUE_NOISE, compared, level, motion, record_of

PAYLOAD = "arm.payload_mass_kg"
SHIPPED = ROOT / "examples" / "recordings" / "payload.csv"


@pytest.mark.parametrize("true", RIGID_LEVELS)
def test_the_true_level_is_named(labelled, true):
    found = compared(record_of(level(labelled, true), rows=3000), labelled)
    assert (found.best.name, found.decided, found.explained) == (true, True, True)
    assert found.repairs == ()
    assert found.angle_noise == pytest.approx([ANGLE_NOISE] * 2, rel=0.05)
    assert found.torque_noise == pytest.approx([TORQUE_NOISE] * 2, rel=0.05)


def test_an_arm_without_gears_has_one_level_and_one_answer():
    """A wrong payload is one explanation, not one of each level that is the same there."""
    arm = arm_of(2, direct=[0, 1])
    bare = {"motor_mass_kg": 0.0, "rotor_inertia_kg_m2": 0.0}
    joints = tuple(joint.model_copy(update=bare) for joint in arm.joints)
    arm = arm.model_copy(update={"joints": joints})
    found = compared(record_of(level(arm, "links"), rows=3000), arm)
    assert [each.name for each in found.levels] == ["links"]
    assert found.decided
    heavier = arm.model_copy(update={"payload_mass_kg": 1.1 * arm.payload_mass_kg})
    changed = compared(record_of(level(heavier, "links"), rows=3000), arm)
    answers = describe_answers(changed)
    payloads = [line for line in answers if "payload is" in line]
    assert len(payloads) == 1
    assert payloads[0].startswith("The recording fits the rigid arm if the payload is")
    words = " ".join([*answers, *describe_answers(found), *describe_comparison(changed)])
    assert not any(each in words for each in ("carriers", "armature", "coupled", "gears"))
    assert "Eq. 1" not in comparison_page(changed)


@pytest.mark.slow
def test_noise_is_that_of_each_level_where_a_joint_stands_still(labelled):
    """Noise of a joint's acceleration passes to both torques, by the level's own mass matrix."""
    model, time = level(labelled, "armature"), np.arange(4000) * 1e-3
    moved = motion(2, time, 0.3)
    for signal, value in zip(moved, (0.4, 0.0, 0.0), strict=True):
        signal[:, 1] = value
    rng = np.random.default_rng(0)
    torques = model.inverse_dynamics(*moved) + TORQUE_NOISE * rng.normal(size=(4000, 2))
    noisy = np.column_stack([np.round(moved[0][:, 0], 4), moved[0][:, 1]])  # steps of an encoder
    found = compared(Record("a record", time, noisy, None, torques), labelled)
    assert (found.best.name, found.explained) == ("armature", True)


def test_a_joint_that_is_zero_throughout_is_compared(labelled):
    record = record_of(level(labelled, "links"), rows=500)
    for signal in (record.angles, record.torques):
        signal[:, 1] = 0.0
    assert not compared(record, labelled).explained


def test_levels_that_a_record_cannot_tell_apart_are_undecided(labelled):
    slow = record_of(level(labelled, "coupled"), amplitude=0.01)
    found = compared(slow, labelled)
    assert found.explained
    assert not found.decided
    assert {"armature", "coupled"} <= set(found.candidates)


def test_a_wrong_payload_is_found_with_its_level(labelled):
    heavier = change_parameters(labelled, {PAYLOAD: 1.02 * labelled.payload_mass_kg})
    found = compared(record_of(level(heavier, "coupled"), rows=3000), labelled)
    assert not found.explained
    assert [(each.level, each.estimate.parameter.path) for each in found.repairs] == [
        ("coupled", PAYLOAD)
    ]
    (repair,) = found.repairs
    apart = repair.estimate.value - heavier.payload_mass_kg
    assert abs(apart) < 2 * repair.estimate.half_width


@pytest.mark.parametrize(
    ("value", "half_width", "possible"), [(-1.0, 0.9, False), (-1.0, 1.1, True)]
)
def test_a_negative_number_is_impossible_beyond_its_interval(labelled, value, half_width, possible):
    found = Estimate(Parameter(PAYLOAD, 10.0), value, half_width, 1.0, 1.0)
    assert found.is_possible == possible
    assert (apply_estimate(labelled, found) is not None) == possible
    assert ("impossible" in format_estimate(found)) != possible


def test_places_are_counted_from_one_in_words(labelled):
    said = {each.path: each.name for each in find_parameters(labelled)}
    assert said["arm.joints.1.planet_mass_kg"] == "joint 2: planet mass"
    assert said["arm.links.0.density_kg_per_m3"] == "link 1: density"
    assert said["arm.joints.0.friction_N_m_s_per_rad"] == "joint 1: viscous friction"
    assert said[PAYLOAD] == "payload"


def test_intervals_cover_as_often_as_they_say(labelled):
    """Fewer than 16 of 20 intervals of 95 % cover once in 400 such tests."""
    model, own = level(labelled, "links"), {each.path: each for each in find_parameters(labelled)}
    more, by = increase_parameter(labelled, own[PAYLOAD])
    inside = 0
    for seed in range(20):
        record = record_of(model, seed, rows=2000)
        pieces = smooth_record(record, record.torques, select_spacing(record))
        normal = build_normal_equations(
            pieces, model, [(level(more, "links"), by)], lambda rows: None
        )
        (found,) = estimate_separately(normal, [own[PAYLOAD]])
        inside += abs(found.value - labelled.payload_mass_kg) < found.half_width
    assert inside >= 16


def test_residual_of_a_true_model_is_noise_at_uneven_times(labelled):
    """Chi squared over its degrees of freedom is one, whatever the times: nothing is resampled."""
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, 4000))
    found = compared(record_of(level(labelled, "carriers"), time=time), labelled)
    assert found.best.name == "carriers"
    assert found.residual_chi2 / found.residual_freedom == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow
def test_arms_with_weight_friction_and_more_joints():
    arm = load_arm("direct-between")
    found = compared(record_of(level(arm, "coupled"), rows=4000), arm)
    assert found.explained
    assert "coupled" in found.candidates
    assert {engine.verdict for engine in found.engines} == {"agree"}


def test_smoothing_keeps_motion_and_slopes(labelled):
    record = record_of(level(labelled, "links"))
    spacing = select_spacing(record)
    middle = next(iter(smooth_record(record, record.torques, spacing)))
    inner = slice(len(middle.time) // 4, -len(middle.time) // 4)
    _, rates, accelerations = motion(2, middle.time, 0.3)
    assert np.abs(middle.rates - rates)[inner].max() < 1e-3
    assert np.abs(middle.accelerations - accelerations)[inner].max() < 0.1


def test_runs_stay_with_their_own_level_and_leave_with_another(labelled):
    record = record_of(level(labelled, "coupled"))
    pieces = list(smooth_record(record, record.torques, select_spacing(record)))
    right = list(run_windows(pieces, labelled, "coupled", {}))
    wrong = list(run_windows(pieces, labelled, "links", {}))
    whole = right[0].time[-1] - right[0].time[0]
    assert np.median([each.stays_s for each in right]) == pytest.approx(whole)
    assert np.median([each.stays_s for each in wrong]) < whole / 3
    assert np.max([each.numerical.max() for each in right]) < 1e-8


def test_a_stated_tolerance_widens_the_uncertainty_of_inputs(labelled):
    record = record_of(level(labelled, "coupled"), rows=2000)
    pieces = list(smooth_record(record, record.torques, select_spacing(record)))
    plain, stated = (
        next(run_windows(pieces, labelled, "coupled", given)) for given in ({}, {PAYLOAD: 0.05})
    )
    assert (stated.inputs[-1] > 2 * plain.inputs[-1]).any()
    assert stated.data[-1] == pytest.approx(plain.data[-1])


def test_rates_in_another_unit_are_told(labelled):
    record = record_of(level(labelled, "links"), rows=500)
    _, rates, _ = motion(2, record.time, 0.3)
    require_same_units(replace(record, rates=rates), rates)
    for factor, said in ((180 / np.pi, "rates are in degrees"), (1e3, "times are in milliseconds")):
        with pytest.raises(InputError, match=said):
            require_same_units(replace(record, rates=factor * rates), rates)


def test_the_shipped_recording_is_what_its_script_makes(tmp_path):
    folder = ROOT / "examples" / "recordings"
    with patch.object(sys, "argv", ["", str(tmp_path / "again.csv")]):
        runpy.run_path(str(folder / "recorded_motion.py"))
    shipped, again = (read_record(path, 2) for path in (SHIPPED, tmp_path / "again.csv"))
    for one, other in ((shipped.angles, again.angles), (shipped.torques, again.torques)):
        assert one == pytest.approx(other, abs=1.1e-3)  # rounding may turn a last digit
    assert SHIPPED.stat().st_size < 300_000


@pytest.mark.slow
def test_the_command_of_the_readme_answers_as_the_docs_say(crosscheck, monkeypatch):
    monkeypatch.chdir(ROOT)
    (command,) = re.findall(
        r"\.venv/bin/crosscheck (compare \S+ \S+)", (ROOT / "README.md").read_text()
    )
    answer = crosscheck(*command.split())
    assert answer.code == 1
    fits = "The recording fits rigid gears (coupled) if the payload is 10.2 kg; the file says 10."
    told, _, _ = answer.out.partition("\n\n")
    assert told.splitlines()[0] == fits
    page = (ROOT / "docs" / "how-to" / "compare-a-recording.md").read_text()
    assert " ".join(told.split()) in " ".join(page.split())


def turn(vector: Sequence[float], degrees: float) -> tuple[float, float]:
    """A vector in the plane, turned."""
    turned = complex(*vector) * np.exp(1j * np.radians(degrees))
    return turned.real, turned.imag


@pytest.mark.parametrize("degrees", [5.0, -0.5])
def test_gravity_is_asked_before_numbers_where_the_base_is_tilted(degrees):
    arm = load_arm("three-unlike")
    tilted = arm.model_copy(update={"gravity_m_per_s2": turn(arm.gravity_m_per_s2, degrees)})
    found = compared(record_of(level(tilted, "coupled"), rows=3000), arm)
    assert not found.explained
    first = found.explanations[0]
    assert isinstance(first, GravityFit)
    assert first.level == "coupled"
    np.testing.assert_allclose(
        first.gravity.value, tilted.gravity_m_per_s2, atol=2 * first.gravity.half_width.max()
    )
    angle, half_width = first.gravity.angle_deg
    assert abs(angle - abs(degrees)) < 2 * half_width
    assert f"is the base tilted about {'-z' if degrees > 0 else 'z'}?" in first.gravity.describe()


def test_masses_and_a_right_gravity_are_no_tilt():
    arm = load_arm("three-unlike")
    heavier = change_parameters(arm, {PAYLOAD: 1.1 * arm.payload_mass_kg})
    found = compared(record_of(level(heavier, "coupled"), rows=3000), arm)
    assert not any(isinstance(each, GravityFit) for each in found.explanations)
    assert isinstance(found.explanations[0], Repair)
    assert not compared(record_of(level(arm, "coupled"), rows=3000), arm).gravities
