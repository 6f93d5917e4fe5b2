"""Joints of several degrees of freedom: chains without motors that move as their bodies do."""

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from crosscheck.analytic.robot.springs import largest_stable_step
from crosscheck.checks.momentum import find_conserved_directions
from crosscheck.checks.robot_states import sample_states
from crosscheck.cost.output import describe_result
from crosscheck.cost.shortcuts import QUICK, compute_costs
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import ConstantDrive, Scenario
from crosscheck.models.loading import load_scenario
from crosscheck.models.robot.file import RobotSource, load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.planning.robots import compare_engines
from crosscheck.registry import build_robot_experiment, build_robot_model
from crosscheck.trial.input.equations import Coordinates, Equations
from tests.loops import require_items
from tests.robots.chains import ENGINES, Solid, joint, link, robot, urdf
from tests.robots.test_mjcf import mass_matrix
from tests.robots.trials import run_robot_trial

WEIGHTLESS = {"gravity_m_per_s2": [0, 0, 0]}
SATELLITE = Solid(40.0, (0.05, 0.02, -0.03), (5, 0.3, -0.2, 6, 0.1, 7))
UPPER = Solid(4.0, (0.45, 0.03, 0.01), (0.02, 0.01, 0, 0.33, 0.005, 0.32))
FORE = Solid(3.0, (0.3, -0.02, 0.04), (0.011, 0, 0.004, 0.12, 0.002, 0.125))
ARM = (
    *(link("sat", SATELLITE), link("upper", UPPER), link("fore", FORE)),
    joint("j1", "sat", "upper", axis=(0, 0, 1), at=(0.5, 0.1, 0.2)),
    joint("j2", "upper", "fore", axis=(0, 1, 0), at=(0.9, 0, 0.1)),
)
GEARS = {
    "j1": {
        "kind": "geared",
        "ratio": 50.0,
        "rotor_inertia_kg_m2": 3e-4,
        "rotor_axis": [0.0, 0.6, 0.8],
        "stator": "sat",
    },
    "j2": {"kind": "geared", "ratio": -80.0, "rotor_inertia_kg_m2": 2e-4},
}


def moved(kind: str, more: str = "") -> str:
    """A joint that lets the satellite move in the inertial frame."""
    ends = f'<parent link="inertial"/><child link="sat"/>{more}'
    return f'<joint name="base" type="{kind}">{ends}</joint>'


def free_robot(kind: str = "floating", more: str = "", gears=GEARS) -> Robot:
    return robot(urdf(link("inertial"), *ARM, moved(kind, more)), gears, **WEIGHTLESS)


def body_rates(angles: np.ndarray) -> np.ndarray:
    """Angular velocity in a body's frame by the rates of yaw, pitch and roll (3, 3)."""
    turn = Rotation.from_euler("ZYX", angles).as_matrix()
    return turn.T @ euler_axes(angles[0], turn)


def euler_axes(yaw: float, turn: np.ndarray) -> np.ndarray:
    """Axes of yaw, pitch and roll, as columns: z, y turned by the yaw, and the body's x."""
    return np.array([[0, 0, 1], [-np.sin(yaw), np.cos(yaw), 0], turn[:, 0]]).T


def slope(function, q, v, step=1e-5):
    """Derivative of a matrix of q along v."""
    return (function(q + step * v) - function(q - step * v)) / (2 * step)


def free_flyer():
    """Pinocchio's tree of the arm on a free flyer; S(q), by which its velocities are S q'."""
    tree = pin.buildModelFromXML(urdf(*ARM), pin.JointModelFreeFlyer())
    tree.gravity.linear = np.zeros(3)

    def twists(q: np.ndarray) -> np.ndarray:
        s, turn = np.eye(8), Rotation.from_euler("ZYX", q[3:6]).as_matrix()
        s[:3, :3] = turn.T
        s[3:6, 3:6] = turn.T @ euler_axes(q[3], turn)
        return s

    return tree, twists


def place(q: np.ndarray) -> np.ndarray:
    """A configuration of that tree."""
    return np.concatenate([q[:3], Rotation.from_euler("ZYX", q[3:6]).as_quat(), q[6:]])


def symmetric(upper: np.ndarray) -> np.ndarray:
    return np.triu(upper) + np.triu(upper, 1).T


def test_a_floating_base_moves_as_pinocchios_free_flyer():
    """Twists of a quaternion's joint are S(q) q'; M and bias are then S' M S and S' (h + M S' q').

    Bias by a difference of S: 1e-9 of it.
    """
    own, (tree, twists) = free_robot(gears={}), free_flyer()
    data = tree.createData()
    states = sample_states(own, 10, 0)
    models = [build_robot_model(name, own, "links") for name in ENGINES]
    for q, v in require_items(zip(states.q, states.v, strict=True)):
        s = twists(q)
        mass = s.T @ symmetric(pin.crba(tree, data, place(q))) @ s
        force = pin.rnea(tree, data, place(q), s @ v, slope(twists, q, v) @ v)
        for model in require_items(models):
            assert model.mass_matrix(q[None])[0] == pytest.approx(mass, rel=1e-12, abs=1e-12)
            bias = model.bias(q[None], v[None])[0]
            assert bias == pytest.approx(s.T @ force, rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("kind", ["floating", "planar", "ball"])
def test_every_engine_agrees_on_what_moves_freely(kind):
    own = free_robot(kind, '<axis xyz="0.6 0 0.8"/>')
    findings = compare_engines(own, sample_states(own, 5, 0))
    assert {each.verdict for each in require_items(findings)} == {"agree"}
    assert own.motors == [len(own.coordinates) - 2, len(own.coordinates) - 1]


def test_a_planar_joint_moves_in_the_plane_of_its_axis():
    """And its first two coordinates are x and y of a plane about z."""
    for normal in require_items(([0, 0, 1], [0.6, 0, 0.8], [0, -2, 0])):
        text = '<axis xyz="{} {} {}"/>'.format(*normal)
        axes = [each.axis for each in free_robot("planar", text).joints[:3]]
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert axes[2] == pytest.approx(np.array(normal) / np.linalg.norm(normal))
        assert np.array(axes) @ np.transpose(axes) == pytest.approx(np.eye(3), abs=1e-15)
        if normal == [0, 0, 1]:
            assert np.array(axes) == pytest.approx(np.eye(3))


def test_states_keep_away_from_the_poles_and_notes_say_where_they_are():
    own = free_robot()
    pitch = own.coordinate_names.index("base_pitch")
    most = np.abs(sample_states(own, 1000, 0).q).max(axis=0)
    assert 1.0 < most[pitch] < np.radians(70) < most[pitch - 1]
    notes = " ".join(own.notes)
    assert "base_pitch has poles at +-90 degrees" in notes
    assert "no motor drives base_x, base_y, base_z, base_yaw, base_pitch, base_roll" in notes
    assert not any("no mass" in note for note in own.notes)


def test_what_is_read_is_read_again_from_its_own_text():
    """So from the file of a run, and from the URDF that export writes."""
    own = free_robot()
    again = RobotSource(file=own.content, urdf_text=own.urdf).build()
    assert again.urdf == own.urdf
    assert [each.has_motor for each in again.joints] == [False] * 6 + [True] * 2
    states = sample_states(own, 3, 0)
    masses = [
        build_robot_model("analytic", each, "coupled").mass_matrix(states.q)
        for each in (own, again)
    ]
    np.testing.assert_array_equal(*masses)
    assert "floating" not in own.urdf
    assert pin.buildModelFromXML(own.urdf).nv == 8


def experiment(**changes) -> Scenario:
    return load_scenario("constant-torque").model_copy(
        update={"duration_s": 0.1, "step_s": 1e-3, "record_every": 10, **changes}
    )


def test_drives_act_on_motors_alone():
    """One torque for all is for all motors; a list has a number for each of them."""
    own = free_robot()
    for torque in require_items((5.0, (5.0, 5.0))):
        scenario = experiment(drive=ConstantDrive(kind="constant", torque_N_m=torque))
        run = build_robot_experiment("analytic:coupled", own, scenario, None).simulate()
        np.testing.assert_array_equal(run["torque"], np.tile([0.0] * 6 + [5.0] * 2, (11, 1)))
    drive = ConstantDrive(kind="constant", torque_N_m=(5.0,) * 8)
    with pytest.raises(InputError, match="needs 2 values, has 8"):
        build_robot_experiment("analytic:coupled", own, experiment(drive=drive), None)


def test_the_largest_stable_step_is_not_that_of_a_pole():
    scenario = experiment(drive=load_scenario("pd").drive)
    steps = [
        largest_stable_step(build_robot_model("analytic", own, "coupled"), scenario)
        for own in (free_robot(), free_robot("planar", '<axis xyz="0 0 1"/>'))
    ]
    assert min(steps) > 1e-4
    assert max(steps) < 10 * min(steps)


FREE = """<mujoco><option gravity="0 1 -5"/><worldbody>
<body name="sat" pos="1 2 3" euler="10 20 30"><freejoint name="base"/>
  <inertial pos=".05 .02 -.03" mass="40" fullinertia="5 6 7 .3 -.2 .1"/>
  <body name="arm" pos=".5 .1 .2" euler="40 10 20"><joint name="wrist" type="ball" pos=".1 .2 .1"/>
    <inertial pos=".45 .03 .01" mass="4" fullinertia=".03 .33 .32 .01 0 .005"/>
    <body name="hand" pos=".9 0 .1"><joint name="turn" axis="0 1 0"/>
      <inertial pos=".3 0 .04" mass="3" fullinertia=".02 .12 .12 0 .004 .002"/>
</body></body></body></worldbody></mujoco>"""


def test_free_joints_and_balls_move_as_mujocos_own(tmp_path):
    """Of a free joint the velocity is in the world, all angular ones are in the bodies' frames."""
    file = tmp_path / "free.xml"
    file.write_text(FREE)
    own, model = load_robot(str(file)), mujoco.MjModel.from_xml_path(str(file))
    data, analytic = mujoco.MjData(model), build_robot_model("analytic", own, "links")
    states = sample_states(own, 10, 0)

    def rates(q: np.ndarray) -> np.ndarray:
        s = np.eye(10)
        s[3:6, 3:6], s[6:9, 6:9] = body_rates(q[3:6]), body_rates(q[6:9])
        return s

    for q, v in require_items(zip(states.q, states.v, strict=True)):
        turns = [
            Rotation.from_euler("ZYX", each).as_quat(scalar_first=True) for each in (q[3:6], q[6:9])
        ]
        s = rates(q)
        data.qpos[:], data.qvel[:] = np.concatenate([q[:3], *turns, q[9:]]), s @ v
        full = mass_matrix(model, data)
        mass = analytic.mass_matrix(q[None])[0]
        # MuJoCo's principal axes are right to some 1e-6 of an inertia.
        assert np.abs(mass - s.T @ full @ s).max() < 1e-5
        force = s.T @ (data.qfrc_bias + full @ slope(rates, q, v) @ v)
        own_force = analytic.inverse_dynamics(q[None], v[None], 0 * v[None])[0]
        assert own_force == pytest.approx(force, rel=1e-5, abs=1e-3)
    assert own.motors == [9]


def test_ranges_and_dynamics_of_a_ball_are_named(tmp_path):
    file = tmp_path / "ball.xml"
    file.write_text(
        '<mujoco><worldbody><body><joint name="b" type="ball" range="0 1" armature=".1"/>'
        '<geom size="1"/></body></worldbody></mujoco>'
    )
    notes = load_robot(str(file)).notes
    assert "range of ball b is not used" in notes
    assert "dynamics of joint b, which is ball, are not used" in notes
    assert not ElementTree.fromstring(load_robot(str(file)).urdf).findall("joint/dynamics")


def test_conserved_directions_are_those_in_which_the_ground_leaves_free():
    """All six of what floats; two and one in a plane; about a ball's centre; none with friction."""
    counts = {"floating": 6, "planar": 3, "ball": 3}
    for kind, count in require_items(counts.items()):
        place = '<origin xyz="1 2 3"/><axis xyz="0 0 1"/>'
        directions = find_conserved_directions(free_robot(kind, place))
        assert directions.shape == (count, 6)
    centre = np.array([1, 2, 3])
    for linear, angular in zip(directions[:, :3], directions[:, 3:], strict=True):
        assert linear == pytest.approx(np.cross(centre, angular), abs=1e-12)
    # An axis that a printed angle turns by 1e-9 out of the plane of two slides is not along it.
    axes = (1, 0, 0), (0, np.cos(1e-9), np.sin(1e-9)), (0, 0, 1)
    kinds = ("x", "prismatic"), ("y", "prismatic"), ("turn", "continuous")
    names = ["inertial", "u", "w", "sat"]
    ends = zip(names, names[1:], axes, kinds, strict=False)
    steps = [joint(name, *pair, kind, axis) for *pair, axis, (name, kind) in ends]
    passive = [f'<passive_joint name="{name}"/>' for name, _ in kinds]
    tilted = robot(urdf(*map(link, names[:3]), *ARM, *steps, *passive), GEARS, **WEIGHTLESS)
    assert len(find_conserved_directions(tilted)) == 2
    rubbing = GEARS | {"base_x": {"kind": "direct", "friction_N_m_s_per_rad": 1.0}}
    assert not find_conserved_directions(free_robot(gears=rubbing)).size
    heavy = robot(urdf(link("inertial"), *ARM, moved("floating")))
    assert not find_conserved_directions(heavy).size


def test_cost_is_of_motors_and_says_how_the_base_moves():
    """In a motion that begins without momentum, in which nothing but the arm moves the base."""
    own = free_robot()
    few = replace(QUICK, states=2, instants=100, runs=1, steps=20, most_steps=0)
    costs = compute_costs(own, 0, few, lambda *progress: None)
    assert costs.names == ("j1", "j2")
    assert costs.torques.shape == (few.instants, 2)
    state = costs.motion.at(costs.time[1:-1])
    model = build_robot_model("pinocchio", own, "coupled")
    forces = np.abs(model.inverse_dynamics(*state)).max(axis=0)
    assert forces[:6].max() < 1e-4 * forces[6:].min()
    momenta = np.abs(model.momentum(*state[:2])).max()
    assert momenta < 1e-5 * np.abs(model.momentum(state[0], state[1] * ([0] * 6 + [1] * 2))).max()
    words = " ".join(describe_result(costs))
    assert "moving freely: base_x by" in words
    assert "without gears: base" not in words


def test_compare_needs_a_motor_at_each_joint():
    with pytest.raises(InputError, match=r"base_x, .*base_roll.*no motor drives these"):
        SpatialRobot(free_robot())


def test_equations_in_a_twist_of_the_base_are_carried_to_its_euler_rates():
    """All of Pinocchio's free flyer; with two of its angular velocities swapped it is wrong."""
    own, (tree, twists) = free_robot(gears={}), free_flyer()
    data, still = tree.createData(), np.zeros(8)
    equations = Equations(
        mass_matrix=lambda q: symmetric(pin.crba(tree, data, place(q))),
        bias=lambda q, v: pin.rnea(tree, data, place(q), v, still),
        inverse_dynamics=lambda q, v, a: pin.rnea(tree, data, place(q), v, a),
        acceleration=lambda q, v, torque: pin.aba(tree, data, place(q), v, np.pad(torque, (6, 0))),
        coordinates=Coordinates(velocities=twists),
        level="links",
    )
    assert run_robot_trial(equations, own, quick=True).agrees
    swapped = Coordinates(velocities=lambda q: twists(q)[[0, 1, 2, 3, 5, 4, 6, 7]])
    assert not run_robot_trial(replace(equations, coordinates=swapped), own, quick=True).agrees
