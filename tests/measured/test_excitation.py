"""Motions that show too little: the suggested one is within limits, and its record does tell."""

import io
import json

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.cost.motion import find_exceeded_limits
from crosscheck.identification import excitation
from crosscheck.identification.compare import EXCITED, STEPS, SideResult
from crosscheck.identification.excitation import PERIODS, TABLE_ROWS, Excitation, format_excitation
from crosscheck.identification.structure import draw_samples, find_basis
from crosscheck.identification.terms import build_columns
from crosscheck.models.robot.robot import JointLimits, Robot
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured import robots
from tests.measured.records import name_columns, write_table
from tests.robots import chains

SHARED = np.zeros((0, 3))


@pytest.fixture(scope="module")
def robot() -> Robot:
    """The arm with limits, of which those of effort are felt."""
    limit, usual = '<limit lower="-1" upper="1.5" velocity="2" effort="150"', chains.LIMIT[:-2]
    limited = robots.arm(robots.arm().urdf.replace(usual, limit))
    assert {each.limits for each in limited.joints} == {JointLimits(-1.0, 1.5, 2.0, 150.0)}
    return limited


def follow(robot: Robot, time: np.ndarray, position: np.ndarray) -> Record:
    """A recording of the positions with torques of coupled rotors, friction and noise."""
    step = time[1] - time[0]
    rate = np.gradient(position, step, axis=0, edge_order=2)
    more = np.gradient(rate, step, axis=0, edge_order=2)
    rng = np.random.default_rng(1)
    torque = build_robot_model("exudyn", robot, "coupled").inverse_dynamics(position, rate, more)
    torque = torque + robots.VISCOUS * rate + robots.COULOMB * np.sign(rate)
    torque = torque + robots.TORQUE_NOISE * rng.normal(size=torque.shape)
    position = position + robots.POSITION_NOISE * rng.normal(size=torque.shape)
    return Record("a recording", time, position, torque, None)


def read_table(excitation: Excitation) -> np.ndarray:
    """The numbers (rows, 1 + 2 n) of the file that is written."""
    text = io.StringIO(format_excitation(excitation, ()))
    assert text.readline().strip().endswith("theta_2_rad,theta_3_rad," + RATES)
    return np.loadtxt(text, delimiter=",")


RATES = "theta_dot_1_rad_per_s,theta_dot_2_rad_per_s,theta_dot_3_rad_per_s"


@pytest.fixture(scope="module")
def poor(robot) -> SideResult:
    """What a record says in which all joints move alike."""
    time = np.arange(0.0, 20.0, 2e-3)
    wave = 0.3 * np.sin(2 * np.pi * 0.4 * time)
    return robots.first_side(robot, follow(robot, time, np.column_stack([wave, wave, wave])))


def test_a_poor_motion_asks_for_another(poor):
    assert not poor.is_excited
    assert poor.excitation is not None
    assert poor.excitation.condition < EXCITED
    assert poor.fit.condition > 10 * poor.excitation.condition


def test_the_condition_number_is_that_of_the_written_file(robot, poor):
    """By Pinocchio and a transform's derivatives of the file; which columns is the product's.

    1e-6: the file has nine digits.
    """
    table = read_table(poor.excitation)
    start = 3 * TABLE_ROWS // 2  # where a period of the motion begins
    chosen = slice(start, start + TABLE_ROWS)
    time, q = table[chosen, 0], table[chosen, 1:4]
    step = time[1] - time[0]
    turned = 2j * np.pi * np.fft.rfftfreq(TABLE_ROWS, step)[:, None]
    spectrum = np.fft.rfft(q, axis=0)
    spectrum[20:] = 0.0  # a sum of five sines has no more
    q, v, a = (np.fft.irfft(spectrum * turned**order, axis=0) for order in range(3))
    assert np.abs(v - table[chosen, 4:]).max() < 1e-6
    rows = slice(0, TABLE_ROWS, 10)
    q, v, a = q[rows], v[rows], a[rows]
    model = pin.buildModelFromXML(robot.urdf)
    data = model.createData()
    links = [
        pin.computeJointTorqueRegressor(model, data, *x).copy() for x in zip(q, v, a, strict=True)
    ]
    torque = build_robot_model("pinocchio", robot, "coupled").inverse_dynamics(q, v, a)
    ahead, back = np.vstack([torque[1:], torque[:1]]), np.vstack([torque[-1:], torque[:-1]])
    slope = (ahead - back) / (20 * step)
    signs = np.minimum(1, np.maximum(-1, v / (0.01 * np.abs(v).max(axis=0))))
    each = np.eye(3)
    joints = [signal[:, :, None] * each for signal in (1 + 0 * v, v, signs, a)]
    names = [
        f"{kind} of j{n}"
        for kind in ("offset", "viscous", "coulomb", "armature")
        for n in (1, 2, 3)
    ]
    every = np.concatenate([np.array(links), *joints, -slope[:, :, None]], axis=2)
    random = build_columns(robot, SHARED, draw_samples(robot, SHARED))
    kinds = ("links", *(kind for _, added in STEPS for kind in added))
    terms = [random.terms[n].name for n in find_basis(random, kinds).chosen]
    order = [*(term.name for term in random.terms[:30]), *names, "delay of all torques"]
    every = every[:, :, [order.index(name) for name in terms]]
    sigma = np.sqrt((poor.fit.residual**2).sum(axis=0) / poor.fit.shown.sum(axis=0))
    size = np.sqrt((every**2).sum(axis=(0, 1)))
    singular = np.linalg.svd((every / size / sigma[:, None]).reshape(-1, len(terms)))[1]
    assert poor.excitation.condition == pytest.approx(singular[0] / singular[-1], rel=1e-6)


def test_the_suggestion_is_a_run_from_rest_to_rest_within_the_limits(robot, poor):
    """Torques are another engine's, since efforts are what the suggestion took them for."""
    time, state = poor.excitation.tabulate()
    torque = build_robot_model("exudyn", robot, "coupled").inverse_dynamics(*state)
    assert find_exceeded_limits(robot, state, torque) == []
    q, v, a = state
    assert np.abs(v[[0, -1]]).max() < 1e-12
    step = time[1] - time[0]
    assert np.abs(np.gradient(q, step, axis=0)[1:-1] - v[1:-1]).max() < 1e-4 * np.abs(v).max()
    assert np.abs(np.gradient(v, step, axis=0)[1:-1] - a[1:-1]).max() < 1e-3 * np.abs(a).max()
    assert len(time) == (PERIODS + 2) * TABLE_ROWS + 1
    assert poor.excitation.motion.limited_by or np.abs(torque).max() < 150


def test_limits_hold_the_record_and_what_the_file_allows(robot):
    positions = np.array([[-0.5, -2.0, 0.0], [0.5, 0.5, 3.0]])
    limits = [each.limits for each in excitation._widen_limits(robot, positions).joints]
    assert [each.lower for each in limits] == [-1.0, -2.0, -1.0]
    assert [each.upper for each in limits] == [1.5, 1.5, 3.0]


def test_a_record_of_the_suggested_motion_tells(robot, poor):
    table = read_table(poor.excitation)
    side = robots.first_side(robot, follow(robot, table[:, 0], table[:, 1:4]))
    assert side.is_excited
    assert side.excitation is None
    (rotor,) = side.seen
    assert rotor.term.name == "armature of j3"
    assert (
        abs(rotor.value - robots.RATIO * (robots.RATIO - 1) * robots.ROTOR) < 1.5 * rotor.half_width
    )


def test_the_command_writes_the_motion(crosscheck, robot, tmp_path, monkeypatch):
    monkeypatch.setattr(excitation, "DRAWN", 1)
    time = np.arange(0.0, 20.0, 2e-2)
    wave = 0.3 * np.sin(2 * np.pi * 0.4 * time)
    given = follow(robot, time, np.column_stack([wave, wave, wave]))
    write_table(tmp_path / "poor.csv", name_columns(given))
    (tmp_path / "robot.urdf").write_text(robot.urdf)
    command = ("compare", tmp_path / "poor.csv", tmp_path / "robot.urdf", "--out", tmp_path)
    answer = crosscheck(*command, "--json", tmp_path / "found.json")
    assert answer.code == 1, answer.err
    assert "cannot distinguish rotors from links" in answer.out
    assert "record that one" in answer.out
    (side, _) = json.loads((tmp_path / "found.json").read_text())["sides"]
    assert side["suggested_motion"]["condition_number"] < side["condition_number"]
    assert (tmp_path / "excitation.csv").read_text().startswith("t_s,theta_1_rad,")
    command = ("cost", tmp_path / "robot.urdf", "--motion", tmp_path / "excitation.csv")
    answer = crosscheck(*command, "--ratio", 101, "--rotor-inertia", 1e-4, "--quick")
    assert answer.code == 0, answer.err


def test_of_more_motions_the_best_is_no_worse(robot, monkeypatch):
    """Seed 5 stands for 0, which is good: among ever more the condition number never rises."""
    first = excitation.make_excitation
    monkeypatch.setattr(
        excitation, "make_excitation", lambda model, seed, *grid: first(model, seed or 5, *grid)
    )
    samples = draw_samples(robot, SHARED)
    columns = build_columns(robot, SHARED, samples)
    chosen = find_basis(columns, ("links", "offset", "viscous", "coulomb")).chosen
    found = []
    for drawn in (1, 3, 8):
        monkeypatch.setattr(excitation, "DRAWN", drawn)
        found.append(
            excitation.suggest_excitation(
                robot, samples.q, SHARED, chosen, np.ones(3, dtype=bool), np.ones(3)
            )
        )
    conditions = [each.condition for each in found]
    assert conditions == sorted(conditions, reverse=True)
    assert conditions[-1] < conditions[0]
