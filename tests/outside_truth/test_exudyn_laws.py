"""Exudyn's tree: the largest step by dampers, friction and gains."""

import numpy as np
import pytest

from crosscheck.models.experiment.scenario import switches
from crosscheck.models.exudyn.tree.tree import ExudynTree
from tests.loops import require_items
from tests.mixed_arms import NONE, PAYLOAD, ROD_MASS, Data, arm_of, direct, geared, scenario


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
    drives: tuple[tuple[float, Data, float], ...] = (
        (1e4, {"kind": "constant", "torque_N_m": 0.0}, 2.785293563 * inertia / 1e4),
        (0.0, pd(1e8), np.sqrt(8) / np.sqrt(1e8 / inertia)),
    )
    for friction, drive, limit in require_items(drives):
        arm = arm_of(direct(friction_N_m_s_per_rad=friction), gravity=NONE)
        model = ExudynTree(arm, scenario(drive=drive))
        assert model.mesh_modes().shape == (0,)
        # Where RK4's |R| passes 1 on the real and on the imaginary axis; steps are tried in 1e-4.
        assert model.largest_stable_step() == pytest.approx(limit, rel=1e-3)


def pd(gain: float) -> Data:
    return {
        "kind": "pd",
        "target_rad": 0.0,
        "proportional_N_m_per_rad": gain,
        "derivative_N_m_s_per_rad": 0.0,
    }
