"""Sizes that tolerances and plans are taken of, and places of tips: closed forms."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from crosscheck.checks.first_principles import composite
from crosscheck.checks.scales import base_radius, largest_torques, largest_weights
from crosscheck.models.arm.layout import geared_layout, rigid_layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import PdDrive, Start
from crosscheck.models.files import read_raw_arm
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning import sizing
from crosscheck.planning.sizing import (
    GrowingMode,
    bearable_torques,
    compute_sizes,
    find_growing_mode,
)
from crosscheck.provenance import ROOT
from tests.arms import arm_of


def test_a_pd_drive_asks_the_most_where_it_starts():
    drive = PdDrive(
        kind="pd",
        target_rad=(1.0, -0.5),
        proportional_N_m_per_rad=(10.0, 20.0),
        derivative_N_m_s_per_rad=0.0,
    )
    start = Start(theta_rad=(0.2, 0.3))
    scenario = load_scenario("pd").model_copy(update={"drive": drive, "start": start})
    arm = load_arm("paper-labelled").model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
    assert largest_torques(arm, scenario) == pytest.approx([8.0, 16.0], rel=1e-14)


def test_weights_are_largest_whichever_way_gravity_points():
    arm, pull = arm_of(3), 9.81
    bounds = [
        largest_weights(
            arm.model_copy(update={"gravity_m_per_s2": (pull * math.cos(a), pull * math.sin(a))})
        )
        for a in (-math.pi / 2, 0.0, 0.7)
    ]
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-13)
    assert bounds[0] == pytest.approx(bounds[2], rel=1e-13)
    assert (bounds[0] > 0).all()


def test_experiments_of_a_link_on_a_motor_are_sized_by_hand():
    """A clock of 4 rad/s without gears; damping of 0.7; a step to half a radian, weight held."""
    sizes = compute_sizes(load_arm(str(ROOT / "tests" / "tool" / "one-motor.toml")))
    inertia = 0.01 + 0.08 + 3.0 * 0.2**2 + 1.0 * 0.5**2  # rotor, link, its mass, payload
    weight = 9.81 * (3.0 * 0.2 + 1.0 * 0.5)
    stiff = inertia * 4.0**2
    assert (sizes.rate, sizes.mode_Hz) == (4.0, None)
    assert sizes.inertia == pytest.approx([inertia], rel=1e-12)
    assert sizes.proportional == pytest.approx([stiff + 2 * weight], rel=1e-5)
    assert sizes.derivative == pytest.approx([2 * 0.7 * np.sqrt(stiff * inertia)], rel=1e-5)
    assert sizes.step == pytest.approx([0.5 * stiff + weight], rel=1e-5)


@pytest.mark.parametrize("gentler", [0, 1, 3])
def test_gains_are_of_half_the_rate_as_often_as_a_vibration_grows(gentler, monkeypatch):
    arm = load_arm("paper-labelled")
    growing = iter([GrowingMode(1.0, 100.0)] * gentler)
    monkeypatch.setattr(sizing, "find_growing_mode", lambda *_: next(growing, None))
    found, share = compute_sizes(arm), 2.0**-gentler
    damped = 2 * 0.7 * np.array(found.inertia) * found.rate * share
    stiff = np.array(found.inertia) * (found.rate * share) ** 2
    assert found.derivative == pytest.approx(damped, rel=1e-5)  # of six digits
    assert found.proportional == pytest.approx(stiff, rel=1e-5)


@pytest.mark.parametrize(
    ("pole", "is_growing"),
    [
        (0.102 + 100.0j, True),  # in the second that the experiment lasts
        (0.098 + 100.0j, False),
        (5.0 + 1.02e-5j, True),  # beside a pole of 1e4, whose rounding has no frequency
        (5.0 + 0.98e-5j, False),
    ],
)
def test_a_loop_is_unstable_if_a_vibration_grows_by_a_tenth(pole, is_growing, monkeypatch):
    poles = np.array([-1e4, pole, pole.conjugate()])
    model = SimpleNamespace(contact_poles=lambda: poles)
    monkeypatch.setattr(sizing, "build", lambda *_: model)
    scenario = load_scenario("constant-torque").model_copy(update={"duration_s": 1.0})
    mode = find_growing_mode(load_arm("paper-labelled"), scenario)
    assert (mode is not None) == is_growing


def test_bearable_torques_bend_teeth_by_a_tenth_of_their_module():
    """A torque T presses N meshes of a sun that turns n times as fast by T / (n r_s) together."""
    bent = []
    for sun, ring, count, module, alpha, stiffest in (
        (27, 99, 3, 0.003, 24.6, 1.2e8),
        (30, 90, 4, 0.0025, 20.0, 9.5e7),
    ):
        radius, ratio = module * sun / 2 * math.cos(math.radians(alpha)), 1 + ring / sun
        bent.append(count * stiffest * 0.1 * module * radius * ratio)
    assert bearable_torques(load_arm("probe")) == pytest.approx(bent, rel=1e-12)


@pytest.mark.parametrize("planets", ["lumped", "free"])
def test_gears_that_stand_still_on_each_other_turn_as_one_body(planets):
    """Locked gears of a joint carry their teeth along the ring, and all beyond the axis turns.

    So the inertia by displacements follows from that of rigid bodies alone.
    """
    arm, content = load_arm("probe"), read_raw_arm("probe")
    layout = geared_layout(arm, usual_switches(arm, planets=planets))
    pose = composite.arm_pose(content, np.array([[0.3, -1.1], [2.0, 0.4]]))
    parts = composite.build_parts(content)
    whole = [
        each._replace(turns=np.arange(2) <= each.link) if each.mesh_turn else each for each in parts
    ]
    locked = np.eye(len(layout))[layout.theta]
    for place, coordinate in enumerate(layout.coordinates):
        if coordinate.meaning in ("x_s", "x_pr"):
            joint = arm.joints[coordinate.joint - 1]
            locked[coordinate.joint - 1, place] = -base_radius(joint, joint.ring_teeth)
    found = locked @ composite.mass_matrix(parts, pose, layout) @ locked.T
    right = composite.mass_matrix(whole, pose, rigid_layout(arm))
    np.testing.assert_allclose(found, right, rtol=1e-13)  # sums of some twenty terms
