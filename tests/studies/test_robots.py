"""Studies of robots: members are the runs of `simulate`, and what does not fit is one line."""

from pathlib import Path

import numpy as np
import pytest

import crosscheck
from crosscheck.api import simulate
from crosscheck.models.errors import InputError
from crosscheck.models.mechanism import read_robot_data, select_robot
from crosscheck.models.robot.file import load_robot
from crosscheck.registry import build, engine_of, reference_model
from crosscheck.studies.batches.batch import run_batch, run_check
from crosscheck.studies.definition.files import read_study
from crosscheck.studies.members.cases import make_robot_case
from tests.faults.robots import ROBOTS
from tests.loops import require_items
from tests.robots.test_simulate import experiment
from tests.studies.studies import ARM, ROBOT_STUDY

MESH = {"pinion_base_radius_m": 0.01, "stiffness_N_per_m": 1e7, "backlash_m": 1e-5}


def write_study(folder: Path, text: str = ROBOT_STUDY) -> Path:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_members_are_the_runs_of_simulate(tmp_path):
    study = read_study(write_study(tmp_path))
    numbers = run_batch(study.text, 0, study.count)
    settings = ["scenario.duration_s=0.002", "scenario.start.mesh = centre"]
    member = 0
    for backlash in (2e-5, 6e-5):
        for mass in (18.9, 25.0):
            varied = [f"robot.joints.elbow.{s}_mesh.backlash_m={backlash}" for s in ("sun", "ring")]
            varied.append(f"robot.links.fore.mass_kg={mass}")
            robot, (scenario,), *_ = select_robot(ARM, ["pd"], settings + varied)
            run = simulate(build("analytic:geared", robot, scenario))
            # Bit for bit the same kernel; forces of a run are evaluated by other formulas.
            assert np.array_equal(numbers["theta_dot_final"][member], run["theta_dot"].values[-1])
            for name in ("F_sp", "F_pr"):
                peak = np.abs(run[name].values[:, 1, 0]).max()
                assert numbers[f"{name}_peak_joint2"][member] == pytest.approx(peak, rel=1e-10)
            member += 1
    assert len(set(numbers["theta_dot_final"][:, 1])) == 4  # every value counts


def test_the_mass_of_a_link_is_the_one_that_the_engines_have():
    heavier = select_robot(ARM, settings=["robot.links.fore.mass_kg=28.9"]).mechanism
    (plain, changed) = (sum(b.mass for b in r.bodies) for r in (load_robot(ARM), heavier))
    assert changed - plain == pytest.approx(10, rel=1e-12)
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(heavier.urdf)  # its own reader
    assert sum(body.mass for body in model.inertias) == pytest.approx(changed, rel=1e-12)


def test_a_second_engine_and_the_rigid_model_are_where_they_must_be(tmp_path):
    text = ROBOT_STUDY.replace('scenario = "pd"', 'scenario = "pd"\nlevel = "coupled"')
    text = text.replace('_s" = 0.002', '_s" = 0.001').replace('"F_sp"', '"theta_ddot"')
    text += '[[quantities]]\nkind = "rigid_deviation"\n'
    with pytest.raises(InputError, match="'F_pr': must be one of theta, theta_dot, theta_ddot"):
        run_batch(read_study(write_study(tmp_path, text)).text, 0, 1)  # of rigid gears
    study = read_study(write_study(tmp_path, text.replace('"F_pr"', '"torque"')))
    ours, theirs = run_batch(study.text, 0, 1), run_check(study.text, 0)
    for name in ("theta_dot_final", "theta_ddot_peak_joint2"):
        # Two engines by equal steps; velocities of 0.1 rad/s, accelerations of 60 rad/s^2.
        assert np.abs(ours[name] - theirs[name]).max() < 1e-10
    # The run is itself of the rigid level, which is integrated again by steps 10 times as long.
    assert ours["theta_rigid_deviation_coupled"].max() < 1e-9


def test_a_joint_that_follows_has_a_target_and_another_engine_checks():
    """The target is by the mimic's own multiplier and offset, -0.5 and 0.3."""
    member = make_robot_case(ROBOTS["unlike"](), "links", experiment())
    assert member.targets() == pytest.approx([0.5, -0.3, 0.2, -0.5 * -0.3 + 0.3])
    assert engine_of(member.second_model) != engine_of(reference_model())


def test_rotors_meshes_and_python(tmp_path):
    result = crosscheck.sweep(
        "six-joint",
        {"robot.joints.*.rotor_inertia_kg_m2": [1e-4, 2e-4]},
        scenario="constant-torque",
        settings={
            "scenario.duration_s": 1e-3,
            "scenario.step_s": 1e-6,
            "scenario.record_every": 100,
            **{f"robot.joints.{name}.mesh": MESH for name in ("turn", "wrist_bend")},
        },
        measures=[
            {"kind": "peak", "signal": "F_mesh"},
            {"kind": "trajectories", "signals": ["x_mesh", "theta"]},
        ],
    )
    assert result["F_mesh_peak"].dims == ("rotor_inertia_kg_m2", "joint")
    names = load_robot("six-joint").coordinate_names
    without = [name not in ("turn", "wrist_bend") for name in names]
    assert np.isnan(result["F_mesh_peak"].values).tolist() == 2 * [without]
    force = np.abs(result["x_mesh"].values[0, -1, 0]) - MESH["backlash_m"]
    assert result["F_mesh_peak"].values[0, 0] >= MESH["stiffness_N_per_m"] * force > 0
    assert result.rotor_inertia_kg_m2.attrs["units"] == "kg m^2"


@pytest.mark.parametrize("name", ["sliding", "puma560"])
def test_a_robot_has_the_paths_that_its_file_has(name):
    """Each link's mass among them."""
    content = load_robot(name).sections["robot"]
    assert content == read_robot_data(name)["robot"]
    assert all(link["mass_kg"] > 0 for link in require_items(content["links"].values()))
