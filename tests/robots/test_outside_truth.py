"""Robots whose equations are known: closed forms, another program, laws of conservation."""

from itertools import product
from math import cos, pi, sin

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.checks.robot_states import sample_states
from crosscheck.models.files import read_raw_robot
from crosscheck.models.loading import validate_record
from crosscheck.models.robot.file import Geared, RobotFile, load_robot
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import RIGID
from crosscheck.planning.robots import add_mesh_states
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from tests.loops import require_items
from tests.robots.chains import (
    BOB,
    ENGINES,
    INERTIA,
    LENGTH,
    LIMIT,
    MASS,
    Solid,
    geared,
    joint,
    link,
    random_chain,
    robot,
    stepped,
    urdf,
)

STATE = np.array([[0.4, -0.7]]), np.array([[1.3, 0.8]])


@pytest.mark.parametrize("engine", ENGINES)
def test_a_pendulum_with_a_rotor(engine):
    """M = I + m l^2 + J N^2 about y, and the weight's moment m g l sin(q) from the vertical."""
    ratio, spin = -40.0, 2e-4
    q, v = np.array([[0.9]]), np.array([[2.0]])
    own = INERTIA + MASS * LENGTH**2
    for level, added in (("links", 0.0), ("armature", spin * ratio**2), ("coupled", None)):
        model = build_robot_model(engine, robot(BOB, {"swing": geared(ratio, spin)}), level)
        expected = own + (spin * ratio**2 if added is None else added)
        assert model.mass_matrix(q)[0, 0, 0] == pytest.approx(expected, rel=1e-14)
        assert model.bias(q, v)[0, 0] == pytest.approx(0.0, abs=1e-13)
        weight = MASS * 9.81 * LENGTH * sin(0.9)
        assert model.gravity(q)[0, 0] == pytest.approx(weight, rel=1e-13)
        fallen = model.forward_dynamics(q, v, np.array([[0.0]]))[0, 0]
        assert fallen == pytest.approx(-weight / expected, rel=1e-13)


@pytest.mark.parametrize("engine", ENGINES)
def test_friction_slows_what_turns_and_slides_exponentially(engine):
    """v = v0 exp(-c t / I), I with the rotor's J N^2; a mimic of factor m has m^2 c in its leader.

    The run leaves (c h / I)^4 / 120 = 4e-11 of its rates.
    """
    solid, spin, ratio = Solid(MASS, inertia=(0, 0, 0, 0, 0, INERTIA)), 2e-4, 30.0
    follows = LIMIT + '<mimic joint="turn" multiplier="-2"/>'
    text = urdf(
        *(link(name, each) for name, each in zip("gabc", (None, solid, solid, solid), strict=True)),
        joint("turn", "g", "a", more=LIMIT + '<dynamics damping="0.3"/>'),
        joint("slide", "g", "b", "prismatic"),
        joint("follow", "g", "c", more=follows),
    )
    given = {
        "turn": geared(ratio, spin),
        "slide": {"kind": "direct", "friction_N_m_s_per_rad": 4.0},
        "follow": {"kind": "direct", "friction_N_m_s_per_rad": 0.2},
    }
    own = robot(text, given, friction="from-urdf", gravity_m_per_s2=[0.0, 0.0, 0.0])
    model, v = build_robot_model(engine, own, "coupled"), np.array([[1.3, -0.8]])
    decay = np.array([(0.3 + 4 * 0.2) / (5 * INERTIA + spin * ratio**2), 4.0 / MASS])
    slowed = v * np.exp(-0.2 * decay)
    _, ends = stepped(lambda _, q, v: model.forward_dynamics(q, v, 0 * v), 0 * v, v, 20, 0.2)
    assert ends == pytest.approx(slowed, rel=1e-8)
    held = model.inverse_dynamics(0 * v, v, 0 * v)
    assert held == pytest.approx(v * [1.1, 4.0], rel=1e-14)
    assert model.bias(0 * v, v) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_a_urdf_leaves_out(engine):
    """An axis is x, a mimic turns as its leader does: V = -m g l (cos(q) + cos(2 q)).

    Two bobs hang in one place, the second joint stands on the first.
    """
    solid = Solid(MASS, (0, 0, -LENGTH), (INERTIA, 0, 0, 0.02, 0, 0.01))
    first = '<parent link="ground"/><child link="a"/>'
    second = '<parent link="a"/><child link="b"/><mimic joint="one"/>'
    text = urdf(
        *(link("ground"), link("a", solid), link("b", solid)),
        f'<joint name="one" type="continuous">{first}</joint>',
        f'<joint name="two" type="continuous">{second}</joint>',
    )
    model, q = build_robot_model(engine, robot(text), "links"), np.array([[0.9]])
    inertia = (INERTIA + MASS * LENGTH**2) * (1 + 2**2)
    assert model.mass_matrix(q)[0, 0, 0] == pytest.approx(inertia, rel=1e-13)
    weight = MASS * 9.81 * LENGTH * (sin(0.9) + 2 * sin(1.8))
    assert model.gravity(q)[0, 0] == pytest.approx(weight, rel=1e-13)


def test_links_fixed_to_fixed_links_stand_where_another_reader_has_them():
    """Pinocchio's own reader merges them too; turns about three axes do not commute."""
    solid = Solid(1.3, (0.1, -0.2, 0.05), (0.03, 0.002, -0.001, 0.04, 0.003, 0.05))
    text = urdf(
        link("ground"),
        *(link(name, solid) for name in ("arm", "flange", "tool", "hand")),
        joint("turn", "ground", "arm", axis=(0, 1, 0), at=(0.1, 0.2, 0.3), rpy=(0.4, 0.5, 0.6)),
        joint("first", "arm", "flange", "fixed", at=(0.3, -0.1, 0.2), rpy=(0.7, -0.4, 0.3)),
        joint("second", "flange", "tool", "fixed", at=(-0.2, 0.5, 0.1), rpy=(-0.9, 0.8, 0.2)),
        joint("bend", "tool", "hand", axis=(1, 0, 0), at=(0.2, 0.1, -0.3), rpy=(0.1, 1.1, -0.5)),
    )
    model = pin.buildModelFromXML(text)
    q = STATE[0]
    expected = pin.crba(model, model.createData(), q[0])
    torques = pin.computeGeneralizedGravity(model, model.createData(), q[0])
    for engine in require_items(ENGINES):
        own = build_robot_model(engine, robot(text), "links")
        assert own.mass_matrix(q)[0] == pytest.approx(expected, rel=1e-12, abs=1e-13)
        assert own.gravity(q)[0] == pytest.approx(torques, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_rotor_on_a_gimbal(engine):
    """T = J (sin(q2) q1' + N q2')^2 / 2 more than the links': by Lagrange's equations.

    The rotor of the second joint lies along y of the second link, its stator: that axis has the
    component sin(q2) along the first axis, and none along the second.
    """
    spin, ratio = 3e-3, 25.0
    text = urdf(
        link("ground"),
        link("ring", Solid()),
        link("disc", Solid()),
        joint("yaw", "ground", "ring", axis=(0, 0, 1)),
        joint("roll", "ring", "disc", axis=(1, 0, 0)),
    )
    given = geared(ratio, spin, stator="disc", rotor_axis=[0.0, 2.0, 0.0])
    own = robot(text, {"roll": given})
    (q, v), (s, c) = STATE, (sin(-0.7), cos(-0.7))
    v1, v2 = v[0]
    rate = s * v1 + ratio * v2
    mass = spin * np.array([[s**2, s * ratio], [s * ratio, ratio**2]])
    bias = spin * np.array([c * v2 * rate + s * c * v1 * v2, ratio * c * v1 * v2 - c * v1 * rate])
    exact, plain = (
        build_robot_model(engine, own, "coupled"),
        build_robot_model(engine, own, "links"),
    )
    assert exact.mass_matrix(q)[0] - plain.mass_matrix(q)[0] == pytest.approx(mass, abs=1e-14)
    assert exact.bias(q, v)[0] - plain.bias(q, v)[0] == pytest.approx(bias, abs=1e-13)
    assert exact.gravity(q) == pytest.approx(plain.gravity(q), abs=1e-13)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_screw_turns_its_rotor(engine):
    """A slide of mass m on a screw whose rotor turns N rad a metre, on a base that turns along."""
    text = urdf(
        link("ground"),
        link("column", Solid(inertia=(1, 0, 0, 1, 0, 1))),
        link("slide", Solid(mass=3.0, inertia=(1, 0, 0, 1, 0, 1))),
        joint("turn", "ground", "column"),
        joint("lift", "column", "slide", "prismatic"),
    )
    model = build_robot_model(engine, robot(text, {"lift": geared(600.0, 1e-5)}), "coupled")
    expected = [[2 + 1e-5, 600e-5], [600e-5, 3 + 600**2 * 1e-5]]
    assert model.mass_matrix(STATE[0])[0] == pytest.approx(np.array(expected), rel=1e-13)
    assert model.gravity(STATE[0])[0] == pytest.approx([0, 3 * 9.81], abs=1e-13)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_puma_560_has_its_published_mass_matrix(engine):
    """P. Corke, Robotics, Vision and Control, Springer 2011, chapter 9: elbow up, four decimals."""
    q = np.array([[0, pi / 4, pi, 0, pi / 4, 0]])
    mass = np.diag([3.6594, 4.4137, 0.9378, 0.1925, 0.1713, 0.1941])
    mass[0, 1:4] = mass[1:4, 0] = -0.4044, 0.1006, -0.0025
    mass[1, 2] = mass[2, 1] = 0.3509
    mass[1:3, 4] = mass[4, 1:3] = 0.0024, 0.0015
    model = build_robot_model(engine, load_robot("puma560"), "armature")
    assert model.mass_matrix(q)[0] == pytest.approx(mass, abs=0.5001e-4)
    weight = [0, 31.6399, 6.0351, 0, 0.0283, 0]
    assert model.gravity(q)[0] == pytest.approx(weight, abs=0.5001e-4)


def slopes(function, q: np.ndarray) -> np.ndarray:
    """Of a function of one state by its coordinates, last axis, by sixth-order differences."""
    step, weights = 1e-2, {1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
    return np.stack(
        [
            sum(
                w * (function(q + k * step * e) - function(q - k * step * e))
                for k, w in weights.items()
            )
            / step
            for e in np.eye(q.shape[1])[:, None]
        ],
        axis=-1,
    )


WITH_MESHES = 0, 3, 7, 9, 10, 12  # chains some of whose rotors are on meshes


@pytest.mark.parametrize(
    ("level", "seed"),
    [*product(RIGID, (*range(6), 8, 10)), *(("geared", seed) for seed in WITH_MESHES)],
)
def test_bias_follows_from_the_mass_matrix_and_weight_from_a_potential(level, seed):
    """bias = M' v - d(v' M v / 2) / dq: then energy is conserved, and momentum where it must be.

    Where teeth give way, x is among q.
    """
    own = random_chain(seed)
    model: RobotModel = build_robot_model("analytic", own, level)
    states = sample_states(own, 1, seed)
    q, v, _, _ = add_mesh_states(own, states) if level == "geared" else states
    by = slopes(model.mass_matrix, q)[0]
    expected = np.einsum("ijk,j,k->i", by, v[0], v[0]) - np.einsum("jki,j,k->i", by, v[0], v[0]) / 2
    size = np.abs(model.mass_matrix(q)).max() * (1 + np.abs(v).max()) ** 2
    assert model.bias(q, v)[0] == pytest.approx(expected, abs=1e-9 * size)
    stiffness = slopes(model.gravity, q)[0]
    assert stiffness == pytest.approx(stiffness.T, abs=1e-9 * (1 + np.abs(stiffness).max()))


REFLECTED = {  # [kg m^2], as the sources that the files name state them
    "iiwa14": [*[160**2 * 1.321e-4] * 4, 100**2 * 1.321e-4, *[160**2 * 4.54e-5] * 2],
    "panda": [*[0.605721456] * 2, *[0.462474144] * 2, *[0.205544064] * 3],
}


@pytest.mark.parametrize("name", REFLECTED)
def test_files_of_real_robots_have_the_published_reflected_inertias(name):
    path = str(ROOT / "examples" / "robots" / f"{name}.toml")
    file = validate_record(RobotFile, read_raw_robot(path), path)
    geared = [own for own in file.joints.values() if isinstance(own, Geared)]
    found = [own.rotor_inertia_kg_m2 * own.ratio**2 for own in geared]
    assert found == pytest.approx(REFLECTED[name], rel=1e-12)
