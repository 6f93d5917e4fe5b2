"""An arm on a free base is a robot: its file, and equations of one derived by hand."""

from pathlib import Path

import numpy as np
import pytest

from crosscheck.checks.robot_states import sample_states
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.models.mechanism import find_section, select_mechanism
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.robots import compare_engines
from crosscheck.registry import build_robot_model
from crosscheck.trial.input.loading import load_equations
from tests.loops import require_items
from tests.robots.trials import run_robot_trial

SPACE = Path(__file__).parents[2] / "examples" / "space"
ARM = (SPACE / "space-arm.toml").read_text()
BASE = ARM[ARM.index("[base]") : ARM.index("[[joints]]")]


@pytest.mark.parametrize("name", ["space-arm", "paper-on-satellite"])
def test_an_arm_on_a_free_base_agrees_in_every_engine(name):
    own = load_robot(str(SPACE / f"{name}.toml"))
    assert own.coordinate_names == ["base_x", "base_y", "base_yaw", "joint_1", "joint_2"]
    assert own.motors == [3, 4]
    findings = compare_engines(own, sample_states(own, 3, 0))
    assert {each.verdict for each in require_items(findings)} == {"agree"}


def test_the_papers_arm_stands_on_its_cube():
    """Fifty times as heavy as all that it carries."""
    own = load_robot(str(SPACE / "paper-on-satellite.toml"))
    assert sum(body.mass for body in own.bodies) == pytest.approx(51 * 4646 / 50)


def test_a_cube_is_a_body_half_a_side_behind_the_shoulder(tmp_path):
    """M of the base's angle is m (s^2 / 6 + (s / 2)^2) more by a cube, J + m c^2 by any body."""
    masses, file = [], tmp_path / "arm.toml"
    for base in (
        "mass_kg = 30.0\nside_m = 1.2",
        f"mass_kg = 30.0\ninertia_kg_m2 = {30 * 1.2**2 / 6!r}\ncom_m = 0.6",
        "mass_kg = 30.0\ninertia_kg_m2 = 1e-9\ncom_m = 0.0",
    ):
        file.write_text(ARM.replace(BASE, f"[base]\n{base}\n"))
        model = build_robot_model("pinocchio", load_robot(str(file)), "links")
        masses.append(model.mass_matrix(np.zeros((1, 5)))[0, 2, 2])
    assert masses[0] == pytest.approx(masses[1], rel=1e-14)
    assert masses[0] - masses[2] == pytest.approx(30 * 1.2**2 * (1 / 6 + 1 / 4), rel=1e-9)


def test_what_is_for_planar_arms_alone_refuses_a_free_base():
    file = str(SPACE / "space-arm.toml")
    assert find_section(file) == "robot"
    with pytest.raises(InputError, match="base"):
        load_arm(file)


def test_settings_reach_the_robot():
    settings = ["robot.links.base.mass_kg=80.0", "robot.gravity_m_per_s2=[0, -1, 0]"]
    own = select_mechanism(str(SPACE / "space-arm.toml"), [], settings).mechanism
    assert own.bodies[2].mass == 80.0
    assert own.gravity == pytest.approx([0, -1, 0])


@pytest.mark.parametrize("name", ["equations", "fixed_base", "lost_reaction"])
def test_equations_of_a_space_robot_are_on_trial(name):
    """By hand: H, bias, and accelerations by the generalized inertia matrix; and two errors."""
    own = load_robot(str(SPACE / "space-arm.toml"))
    equations = load_equations(f"{SPACE / 'equations.py'}:{name}", own)
    trial = run_robot_trial(equations, own)
    assert trial.agrees == (name == "equations")
    assert "motors: at joint_1, joint_2 alone" in trial.scope
    if name == "lost_reaction":
        words = " ".join(trial.lines)
        assert "link_2, with what is fixed to it: Izz is missing in M[base_yaw, joint_2]" in words
