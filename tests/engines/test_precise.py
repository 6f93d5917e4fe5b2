"""Precise runs, whose steps end where contacts change, against SciPy's and against themselves."""

import numpy as np
import pytest

from crosscheck.analytic.kernel.event_kernel import integrate_with_events
from crosscheck.analytic.model import PhysicalModel, RigidLinks
from crosscheck.models.loading import load_case
from tests.engines.precise_steps import wrong_impacts, wrong_steps
from tests.loops import require_items

SIGNALS = ("theta", "theta_dot", "x_sp", "x_pr", "F_sp")
ARMS = [
    ("paper-labelled", {"planets": "lumped"}),
    ("paper-labelled", {"phase": "omega_t", "damping": "contact"}),
    ("paper-labelled", {"dead_zone": "tanh"}),
    ("planets-apart", {"planets": "free", "mesh_work": "conservative"}),
    ("direct-between", {}),  # with a table of stiffnesses
]


def model_of(arm: str, switches: dict[str, str], duration_s: float = 0.02) -> PhysicalModel:
    settings = [f"scenario.duration_s={duration_s}", "scenario.start.planet_ring_offset_m=-2e-5"]
    return PhysicalModel(*load_case(arm, "constant-torque", switches, settings))


@pytest.mark.parametrize(("arm", "switches"), ARMS)
def test_agrees_with_scipy_as_well_as_scipy_with_itself(arm, switches):
    model = model_of(arm, switches, 0.008)
    precise, fine, coarse = model.precise(1e-11), model.reference(1e-11), model.reference(1e-9)
    for name in require_items(SIGNALS):
        size = np.nanmax(np.abs(fine[name].values))
        doubt = np.nanmax(np.abs(coarse[name].values - fine[name].values))
        apart = np.nanmax(np.abs(precise[name].values - fine[name].values))
        # SciPy steps over contact changes: it is off by what a hundredfold tolerance moves it.
        assert apart <= max(doubt, 1e-9 * size), name


def test_smooth_motion_takes_as_many_steps_as_scipys_and_comes_to_the_same_end():
    """With one record in a second, too: the first step that is tried leads far too far."""
    assert list(wrong_steps()) == []


def test_changes_of_contact_cost_no_more_than_the_tolerance_is_for():
    assert list(wrong_impacts()) == []


def test_errors_fall_with_the_tolerance_through_contact_changes():
    model = model_of("paper-labelled", {}, 0.1)
    best = integrate_with_events(model, 1e-13)
    assert best.changes > 5  # else nothing was to be ended at a change
    errors = [
        np.abs(integrate_with_events(model, rtol).records.q - best.records.q).max() / 50e-6
        for rtol in (1e-5, 1e-8, 1e-11)
    ]
    assert errors[0] < 1e-3
    assert errors[1] < 1e-6
    assert errors[2] < 1e-9


def test_fixed_steps_come_to_the_same_motion_slower():
    model = model_of("paper-labelled", {}, 0.05)
    precise = model.precise(1e-12)
    apart = []
    for step in (1e-5, 2.5e-6):
        update = {"step_s": step, "record_every": round(1e-4 / step)}
        scenario = model.scenario.model_copy(update=update)
        run = PhysicalModel(model.arm, scenario, model.switches).simulate()
        assert run.sizes == precise.sizes
        apart.append(np.abs(run["x_sp"].values - precise["x_sp"].values).max())
    # Of second order at least across contact changes: with a quarter of the step a sixteenth.
    assert 0 < apart[1] < apart[0] / 8


def test_a_rigid_arm_under_constant_torque_starts_as_first_principles_say():
    settings = ["arm.payload_mass_kg=3.0", "scenario.duration_s=0.01"]
    model = RigidLinks(*load_case("paper-labelled", "constant-torque", {}, settings))
    run = model.precise(1e-12)
    mass = model.mass_matrix(np.zeros(2))
    start = np.linalg.solve(mass, run["torque"].values[0])
    np.testing.assert_allclose(run["theta_ddot"].values[0], start, rtol=1e-12)
    # Within 10 ms the pose hardly changes: theta = a t^2 / 2, less terms of theta^2.
    np.testing.assert_allclose(run["theta"].values[-1], start * 0.01**2 / 2, rtol=1e-4)
