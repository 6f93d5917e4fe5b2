"""Every built-in arm written as a robot and read again: the same dynamics, or one line why not."""

import numpy as np
import pytest

from crosscheck.cli.files.robot_files import FRICTIONLESS, export_as_robot, load_as_robot
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import geared_layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.files import builtin_arms, format_toml_fields, parse_toml
from crosscheck.models.loading import load_selection, make_rest_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.registry import build, build_robot_model
from tests.robots.chains import ENGINES

LEVELS = dict(zip(RIGID, ("carriers", "armature", "coupled"), strict=True))  # the arm's names
LAWS = {"damping": "contact", "mesh_work": "conservative"}  # those of robots


@pytest.fixture(scope="module", params=builtin_arms())
def written(request, tmp_path_factory):
    """An arm, and the robot that was read from what was written of it."""
    out = tmp_path_factory.mktemp("arms") / "arm.urdf"
    export_as_robot(request.param, [], out)
    return load_selection(request.param, [], []).arm, load_robot(str(out.with_suffix(".toml")))


def make_states(arm, geared):
    """Coordinates and rates, and where each of a robot's coordinates is in an arm's."""
    joints = len(arm.joints)
    layout = geared_layout(arm, usual_switches(arm))
    stages = [number for number, joint in enumerate(arm.joints) if joint.planet_count]
    order = [layout.at("theta", joint) for joint in range(joints)]
    for joint in stages if geared else ():
        if layout.free:
            planets = range(arm.joints[joint].planet_count)
            order += [layout.at("x_s", joint), *(layout.at("x_pr", joint, n) for n in planets)]
        else:
            order += [layout.at("x_sp", joint), layout.at("x_pr", joint)]
    random = np.random.default_rng(joints)
    q, v = random.uniform(-1, 1, (2, 4, len(order)))
    q[:, joints:] *= 1.5e-4  # in contact and in between
    return q, v, order


def assert_same(arm: Arm, robot: Robot, engine: str, level: str) -> None:
    """M, bias and the forces of weight, friction and teeth, each to 1e-12 of its size."""
    rigid = "physical" if level == "geared" else LEVELS[level]
    q, v, order = make_states(arm, level == "geared")
    model = build_robot_model(engine, robot, level)
    place = order if level == "geared" else list(range(len(arm.joints)))
    matrix, bias = model.mass_matrix(q), model.bias(q, v)
    held = model.inverse_dynamics(q, v, 0 * v) - bias
    planar = build(f"analytic:{rigid}", arm, make_rest_scenario(), usual_switches(arm, **LAWS))
    for state in range(len(q)):
        at, rate = np.zeros((2, len(order)))
        at[place], rate[place] = q[state], v[state]
        expected = planar.mass_matrix(at)[np.ix_(place, place)]
        assert np.abs(matrix[state] - expected).max() <= 1e-12 * np.abs(expected).max()
        wanted = planar.bias(at, rate)[place]
        assert np.abs(bias[state] - wanted).max() <= 1e-12 * np.abs(wanted).max()
        force = -planar.generalized_force(0.0, at, rate)[place]
        # An arm without gravity has none on rigid gears; springs' are differences of angles.
        assert np.abs(held[state] - force).max() <= 1e-12 * max(np.abs(force).max(), 1.0)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("level", [*RIGID, "geared"])
def test_levels_are_those_of_the_arm(written, engine, level):
    assert_same(*written, engine, level)


def test_a_robots_settings_are_in_the_files_that_are_written(crosscheck, tmp_path):
    changes = [
        "--set",
        "robot.links.boom.mass_kg=70.5",
        "--set",
        "robot.gravity_m_per_s2=[0,0,-1.5]",
    ]
    answer = crosscheck("export", "sliding", "--out", tmp_path / "a.urdf", *changes)
    assert (answer.code, answer.err) == (0, "")
    written, built_in = load_robot(str(tmp_path / "a.toml")), load_robot("sliding")
    assert written.gravity.tolist() == [0.0, 0.0, -1.5]
    assert written.rotors[2].mesh == built_in.rotors[2].mesh
    heavier = [
        new.mass - old.mass for new, old in zip(written.bodies, built_in.bodies, strict=True)
    ]
    assert sum(map(abs, heavier)) > 0
    odd = {"a b": 1, "a.b": {"c": 2}}
    assert parse_toml("\n".join(format_toml_fields(odd))) == odd


def test_cost_takes_an_arm_as_the_robot_that_is_written_of_it(crosscheck, tmp_path):
    """What armature leaves out of it is what Pinocchio's planar levels differ by."""
    answer = crosscheck("cost", "planets-apart", "--quick", "--json", tmp_path / "cost.json")
    assert (answer.code, answer.err) == (0, "")
    assert "Leaving the rotors out of planets-apart" in answer.out
    assert f"note: {FRICTIONLESS}" in answer.out
    assert "planets share a load by their teeth in joint_1, joint_2" in answer.out
    arm, robot = load_selection("three-unlike").arm, load_as_robot("three-unlike")
    assert robot.notes[-1] == FRICTIONLESS
    motion = np.random.default_rng(0).uniform(-1, 1, (3, 5, 3))
    robots, planar = (
        [make(level).inverse_dynamics(*motion) for level in ("coupled", "armature")]
        for make in (
            lambda level: build_robot_model("exudyn", robot, level),
            lambda level: build(f"pinocchio:{level}", arm, make_rest_scenario()),
        )
    )
    left_out, expected = robots[0] - robots[1], planar[0] - planar[1]
    assert np.abs(left_out - expected).max() <= 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("model", ["pinocchio:gears", "exudyn:tree"])
def test_engines_have_arms_that_no_robots_file_may_state(model):
    """A link of 1e10 kg, as checks lock a stage by one."""
    arm = load_selection("probe").arm
    link = arm.links[0].model_copy(update={"density_kg_per_m3": 1e13})
    arm = arm.model_copy(update={"links": (link, *arm.links[1:])})
    assert link.mass > 1e10
    q = np.full(6, 1e-4)
    found, expected = (
        build(each, arm, make_rest_scenario()).mass_matrix(q)
        for each in (model, "analytic:physical")
    )
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
