"""The Exudyn tree's coordinates, integrator, records and steps against what they must be."""

import numpy as np
import pytest

from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.exudyn.tree.tree import ExudynTree
from crosscheck.models.loading import load_case
from tests.loops import require_items
from tests.mixed_arms import NONE, PAYLOAD, ROD_MASS, Data, arm_of, direct, geared, scenario
from tests.one_stage import SPRINGS_ONLY, first_joint_only
from tests.robots.chains import stepped

TIGHT = "arm.joints.*.*_mesh.backlash_m=0.0"
EPSILON = np.finfo(float).eps


def tree(*settings: str, **switches: str) -> ExudynTree:
    case = load_case("paper-labelled", "constant-torque", switches, settings)
    return ExudynTree(*case)


@pytest.mark.parametrize("phase", ["angle", "omega_t"])
def test_connectors_and_motors_act_at_the_times_of_the_stages(phase):
    settings = ("scenario.step_s=1e-5", "scenario.duration_s=0.003", "scenario.record_every=7")
    case = load_case("paper-labelled", "back-and-forth", {"phase": phase}, settings)
    model = ExudynTree(*case)
    run = model.simulate()
    from_tree = np.linalg.pinv(model.from_paper)
    start = (from_tree @ part for part in model.start())
    # The textbook method on the model's own accelerations, its clock k h.
    q, v = stepped(lambda k, q, v: model.acceleration(k * 1e-5, q, v), *start, 300, 300 * 1e-5)
    end = run.isel(time=-1)
    np.testing.assert_allclose(run.time, 1e-5 * np.arange(0, 301), rtol=4 * EPSILON)
    # 300 steps round rotations below 0.1 rad to 1e-17 each; rates follow with the modes' 3e4 rad/s.
    np.testing.assert_allclose(end.theta, q[2::3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(end.theta_dot, v[2::3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(end.x_sp, q[0::3, None] * np.ones(3), rtol=0, atol=1e-15)


def test_too_large_a_step_diverges_in_silence_and_says_when(capfd):
    model = tree("scenario.duration_s=0.1", "scenario.step_s=2e-4", TIGHT)
    assert model.largest_stable_step() < 2e-4
    with pytest.raises(Diverged, match="exudyn:tree: diverged at t = 0"):
        model.simulate()
    assert capfd.readouterr() == ("", "")


def test_a_solver_that_gives_up_diverges_at_the_record_that_it_was_to_reach(monkeypatch):
    model = tree("scenario.duration_s=0.1", "scenario.step_s=1e-3", "scenario.record_every=20")

    def give_up(*_: float) -> None:
        raise FloatingPointError

    monkeypatch.setattr(model._driven_engine, "advance", give_up)
    with pytest.raises(Diverged, match=r"at t = 0\.02 s"):
        model.simulate()


def test_largest_stable_step_is_where_the_motion_begins_to_grow():
    linear = (TIGHT, *SPRINGS_ONLY, "scenario.start.sun_planet_offset_m=1e-6")
    limit = first_joint_only(tree(*linear)).largest_stable_step()
    peaks = []
    for step in (0.98 * limit, 1.02 * limit):
        settings = (*linear, f"scenario.step_s={step}", f"scenario.duration_s={100 * step}")
        run = first_joint_only(tree(*settings)).simulate()
        peaks.append(float(abs(run.x_sp).max()))
    # |R| = 1.15 two percent beyond the limit: 100 steps leave no doubt.
    assert peaks[0] < 1e-5 < 1e-3 < peaks[1]


@pytest.mark.parametrize("damping", ["always", "contact"])
def test_the_largest_step_is_of_damped_contact_wherever_in_the_clearance_a_run_begins(damping):
    heavy = {name: {**geared()[name], "damping_ratio": 3.0} for name in ("sun_mesh", "ring_mesh")}
    arm = arm_of(geared(**heavy), gravity=NONE)
    first, second = (
        ExudynTree(arm, scenario(start={"mesh": begin}), switches(damping=damping))
        for begin in ("contact", "centre")
    )
    # The engine linearises by differences at 1e-7.
    assert first.largest_stable_step() == pytest.approx(second.largest_stable_step(), rel=1e-5)


def test_without_gears_there_are_no_modes_and_the_step_follows_friction_and_gains():
    inertia = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + PAYLOAD * 0.9**2
    still: Data = {"kind": "constant", "torque_N_m": 0.0}
    gains = {"proportional_N_m_per_rad": 1e8, "derivative_N_m_s_per_rad": 0.0}
    drives: tuple[tuple[float, Data, float], ...] = (
        (1e4, still, 2.785293563 * inertia / 1e4),
        (0.0, {"kind": "pd", "target_rad": 0.0, **gains}, np.sqrt(8) / np.sqrt(1e8 / inertia)),
    )
    for friction, drive, limit in require_items(drives):
        arm = arm_of(direct(friction_N_m_s_per_rad=friction), gravity=NONE)
        model = ExudynTree(arm, scenario(drive=drive))
        assert model.mesh_modes().shape == (0,)
        # Where RK4's |R| passes 1 on the real and on the imaginary axis; steps are tried in 1e-4.
        assert model.largest_stable_step() == pytest.approx(limit, rel=1e-3)
