"""Experiments of an arm's own: sized to it, or chosen, and named when their loop is unstable."""

from pathlib import Path

import numpy as np
import pytest

from crosscheck.api import check
from crosscheck.models.arm.meshes import change_meshes, replace_damping
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.preparation import prepare_experiments
from crosscheck.planning.sizing import (
    compute_sizes,
    find_growing_mode,
    make_pd_scenario,
    make_step_scenario,
)
from crosscheck.registry import build, reference_model
from crosscheck.runner.workers import Workers

pytestmark = pytest.mark.slow


@pytest.fixture
def files(brief_plan) -> tuple[str, str]:
    """Names of files: of an arm, one link on a motor, all models in the least time; a scenario."""
    folder = Path(__file__).parent
    return str(folder / "one-motor.toml"), str(folder / "swing.toml")


@pytest.mark.parametrize("joints", [1, 4, 7])
def test_sized_controllers_hold_the_teeth_stable(crosscheck, tmp_path, joints):
    file = tmp_path / "arm.toml"
    assert crosscheck("init", str(file), "--joints", str(joints)).code == 0
    arm = load_arm(str(file))
    sizes = compute_sizes(arm)
    for scenario in (make_step_scenario(sizes), make_pd_scenario(sizes)):
        poles = build(reference_model(), arm, scenario).contact_poles()
        assert poles.real.max() <= 1e-9 * np.abs(poles).max()


def test_sizes_follow_the_arm():
    """An arm whose teeth are 4 times as stiff moves twice as fast, under 4 times the torques."""
    arm = load_arm("direct-between")
    one, other = compute_sizes(arm), compute_sizes(change_meshes(arm, _stiffer))
    assert other.mode_Hz == pytest.approx(2 * one.mode_Hz, rel=1e-9)
    assert other.rate == pytest.approx(2 * one.rate, rel=1e-9)
    # Both are rounded to six digits.
    assert other.step == pytest.approx(4 * np.array(one.step), rel=1e-5)
    assert make_pd_scenario(other).duration_s == pytest.approx(
        make_pd_scenario(one).duration_s / 2, rel=1e-2
    )


def _stiffer(mesh):
    scaled = {
        field: tuple(4 * value for value in number) if isinstance(number, tuple) else 4 * number
        for field, number in mesh.stiffness
        if field.endswith("N_per_m")
    }
    return mesh.model_copy(update={"stiffness": mesh.stiffness.model_copy(update=scaled)})


def test_an_unstable_loop_is_named_before_it_runs():
    arm, scenario = load_arm("three-unlike"), load_scenario("pd")
    growth = find_growing_mode(arm, scenario)
    there = {"theta_rad": scenario.drive.target_rad}
    turned = scenario.model_copy(update={"start": scenario.start.model_copy(update=there)})
    laws = usual_switches(arm)
    ends = [build(reference_model(), arm, pose, laws) for pose in (scenario, turned)]
    poles = np.concatenate([model.contact_poles() for model in ends])
    worst = max(poles[poles.imag > 0], key=lambda pole: pole.real)
    assert growth is not None
    assert growth.rate_per_s == worst.real > 100
    assert 2 * np.pi * growth.frequency_Hz == pytest.approx(worst.imag, rel=1e-12)
    with Workers(1) as workers:
        found = prepare_experiments(
            CrossCheckRequest(arm, quick=True, scenarios=(scenario,)), workers
        )
    assert f"pd: {growth}" in found.remarks
    assert "unstable while teeth touch: +" in found.remarks[0]
    assert " 1/s at " in found.remarks[0]


def test_the_papers_own_loop_is_stable():
    assert find_growing_mode(load_arm("paper-labelled"), load_scenario("pd")) is None


def test_a_scenario_of_ones_own_replaces_the_usual_ones(files):
    agreement = check(load_arm(files[0]), scenarios=[files[1]], quick=True)
    assert agreement.exit_code == 0
    cases = {finding.about.key.case for finding in agreement.findings}
    assert "swing" in cases
    assert not {"pd", "pd-motion", "torque-step", "constant-torque"} & cases
    assert [recorded.name for recorded in agreement.provenance.scenarios] == ["swing"]


def test_sized_experiments_of_an_arm_without_gears(files, tmp_path):
    agreement = check(load_arm(files[0]), quick=True, jobs=2)
    assert agreement.exit_code == 0, [finding.note for finding in agreement.disagreeing]
    cases = {f.about.key.case for f in agreement.findings}
    assert {"torque-step", "pd-motion", "short-plus", "short-minus"} <= cases
    assert not any("contact" in case or "crossing" in case for case in cases)
    agreement.write_report(tmp_path)
    assert "<p>Experiments sized to" in (tmp_path / "index.html").read_text("utf-8")
    remarks = agreement.provenance.remarks
    assert remarks[0].endswith("no gears, controller at 4 rad/s")
    drive = make_pd_scenario(compute_sizes(load_arm(files[0]))).drive
    stiff, damped = drive.proportional_N_m_per_rad, drive.derivative_N_m_s_per_rad
    gains = f"P {stiff[0]:.4g} N m/rad, D {damped[0]:.4g} N m s/rad"
    assert remarks[2] == f"pd-motion: to {drive.target_rad[0]:.4g} rad, {gains}"


def test_a_light_wrist_gives_way_until_its_teeth_are_stable():
    """With hardly any damping the first controller would shake the teeth."""
    arm = load_arm("three-unlike")
    sizes, usual = compute_sizes(replace_damping(arm, 1e-4)), compute_sizes(arm)
    assert np.less(sizes.derivative, np.array(usual.derivative) / 2).all()
    assert sizes.rate == usual.rate  # the arm's clock is its own
