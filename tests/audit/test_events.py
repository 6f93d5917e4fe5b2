"""Events of made-up signals, and the rigid arm that runs are held against."""

import numpy as np
import pytest

from crosscheck.audit.experiments.variant import (
    COUPLED,
    GEARED_MODELS,
    Variant,
    remove_gears,
    rigid_arm,
)
from crosscheck.audit.measures import events

TIME = np.arange(0, 1.5, 1e-3)


def test_the_third_fluctuations_onset_and_peak():
    excess = np.where(TIME < 0.8, 0.1, np.exp((TIME - 0.8) / 0.1))
    window = events.third_window(TIME)
    onset = events.third_onset(TIME, excess, window)
    assert onset == pytest.approx(1.199 - 0.1 * np.log(2), abs=2e-3)
    near = events.third_peak(TIME, excess, window)
    assert TIME[near.start] == pytest.approx(1.199 - events.PEAK_S, abs=2e-3)
    assert TIME[near.stop - 1] <= 1.199


def test_the_third_fluctuation_of_a_run_that_ends_before_is_empty():
    assert TIME[:400][events.third_window(TIME[:400])].size == 0


def test_any_contact_counts_from_earlier_on_than_a_side_change():
    force = np.where((TIME > 0.21) & (TIME < 0.22), -1.0, 1.0)
    assert events.opposite_contact(TIME, force, 0.2) == pytest.approx(0.211)
    assert events.side_change(TIME, force) is None


def test_an_overshoot_is_over_the_step():
    angle = 0.5 * (1 - np.exp(-TIME / 0.1) * np.cos(2 * np.pi * TIME / 0.2))
    assert events.overshoot(angle, 0.5) == pytest.approx(angle.max() / 0.5 - 1)


def test_geared_runs_share_their_rigid_arm():
    tight = ("arm.joints.*.*_mesh.backlash_m=0.0",)
    some = Variant(zeta=0.01, phase="omega_t", seed=3, meshes=tight)
    assert rigid_arm(some) == rigid_arm(Variant()) == rigid_arm(Variant(record_every=7))


def test_printed_equations_have_a_rigid_arm_of_their_own():
    printed = Variant(model=GEARED_MODELS["printed"])
    assert rigid_arm(printed).model == "analytic:printed-rigid"
    assert rigid_arm(printed, "links") == rigid_arm(Variant(), "links")
    assert rigid_arm(Variant(), "links").model == "analytic:links"


def test_what_is_no_mesh_stays_in_the_rigid_arm():
    two = Variant(settings=("arm.joints.*.planet_count=2",), duration_s=0.5)
    assert rigid_arm(two, COUPLED).case().arm == two.case().arm
    assert rigid_arm(two).case().scenario.duration_s == 0.5
    assert remove_gears(two).case().scenario == two.case().scenario


def test_a_side_change_is_that_of_the_load_not_of_a_vibration():
    turning = np.where(TIME < 0.35, 1.0, np.where(TIME < 0.36, 0.0, -1.0))
    side = events.side_change(TIME, turning)
    assert side is not None
    assert (side.left_s, side.met_s) == pytest.approx((0.349, 0.36), abs=2e-3)
    assert events.side_change(TIME, np.cos(2 * np.pi * TIME / 0.01)) is None
    early = np.where((TIME > 0.3) & (TIME < 0.302), -1.0, turning)
    assert events.side_change(TIME, early) is None


def test_bouncing_ends_with_the_last_loss_of_contact():
    force = np.where((TIME > 0.42) & (TIME < 0.43), 0.0, -1.0)
    assert events.bounce_duration(TIME, force, 0.4) == pytest.approx(0.029, abs=2e-3)
    assert events.bounce_duration(TIME, force, 0.5) == 0
