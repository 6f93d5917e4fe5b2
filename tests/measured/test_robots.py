"""Recordings of robots: What their torques distinguish, against a second program and identities."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.identification import compare, output, sampling
from crosscheck.identification.compare import RecordComparison
from crosscheck.identification.description import load_description, read_recordings
from crosscheck.identification.engines import compare_engines
from crosscheck.identification.gravity import GravityEstimate
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.identification.messages import format_estimate
from crosscheck.identification.sampling import lowest_bandwidth
from crosscheck.identification.structure import _rank, compare_levels, draw_samples
from crosscheck.identification.terms import RotorRegressor, _armatures, build_columns, shared_motors
from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings import csv_table
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured.robots import (
    COULOMB,
    RATIO,
    ROTOR,
    SOLIDS,
    STEP,
    VISCOUS,
    arm,
    behind,
    compared,
    compared_arm,
    first_side,
    motion,
    recording,
)
from tests.measured.second_robot import estimate
from tests.measured.statements import KINDS, judge
from tests.robots import chains


@pytest.fixture(scope="module")
def robot() -> Robot:
    return arm()


@pytest.fixture(scope="module")
def coupled() -> tuple[Record, RecordComparison]:
    """A recording of coupled rotors, and what it says of the robot."""
    return compared_arm("coupled")


def test_a_second_program_estimates_the_same(robot, coupled):
    """1e-8 is rounding times condition numbers, with room: 1e-12 and more is measured."""
    given, found = coupled
    side = found.sides[0]
    second = estimate(robot.urdf, given.time, given.position, given.motor_torque, side.bandwidth)
    assert {each.term.name for each in side.estimates} == set(second.values)
    for each in side.estimates:
        name = each.term.name
        scale = max(abs(each.value), each.error)
        assert second.values[name] == pytest.approx(each.value, rel=1e-8, abs=1e-8 * scale)
        assert second.errors[name] == pytest.approx(each.error, rel=1e-8)
    rms = np.sqrt((side.fit.residual**2).sum(axis=0) / side.fit.shown.sum(axis=0))
    assert rms == pytest.approx(second.rms, rel=1e-8)
    # Torques were made with a rotor and without a delay, whose step comes before.
    left = {step.name: step.weighted for step in side.steps}
    assert left["delay"] > 10 * left["armature"]


def test_what_does_not_move_is_no_link_of_a_recording():
    solid, turn = chains.Solid(2.0, (0.1, 0, 0)), chains.joint("turn", "ground", "arm")
    empty = chains.link("frame", chains.Solid(0.0, inertia=(0.0,) * 6))
    links, fixed = (chains.link("ground", solid), chains.link("arm", solid), empty), "fixed"
    text = chains.urdf(*links, turn, chains.joint("frame", "arm", "frame", fixed))
    paths = [each.path.split(".") for each in SpatialRobot(chains.robot(text)).parameters]
    assert {name for _, table, name, *_ in paths if table == "links"} == {"arm"}


def test_friction_of_a_joint_that_never_turns_back_is_no_number(robot):
    """Its Coulomb friction and offset are one column; those of other joints are two."""
    given = recording(robot, "links")
    position = given.position.copy()
    position[:, 0] += 6.0 * given.time
    model = build_robot_model("exudyn", robot, "links")
    rate, more = motion(given.time, 3, 0)[1:]
    rate[:, 0] += 6.0
    torque = model.inverse_dynamics(position, rate, more) + VISCOUS * rate + COULOMB * np.sign(rate)
    noise = 0.2 * np.random.default_rng(1).normal(size=torque.shape)
    side = first_side(robot, replace(given, position=position, motor_torque=torque + noise))
    names = [[each.name for each in pair] for pair in side.alike]
    assert names == [["offset of j1", "coulomb of j1"]]
    named = {each.term.name for each in side.estimates}
    assert not named & set(names[0])
    assert {"offset of j2", "coulomb of j2"} <= named
    assert side.is_excited
    still = replace(given, position=position * [1, 1, 0], motor_torque=torque + noise)
    assert [len(pair) for pair in first_side(robot, still).alike] == [2]  # j1's again


def test_of_a_joint_whose_torque_is_not_measured_the_motion_alone_counts(robot):
    """Its friction is in no torque; that of the others is estimated as without it."""
    given = recording(robot, "links", seconds=6.0)
    torque = given.motor_torque.copy()
    torque[:, 1] = np.nan
    side = first_side(robot, replace(given, motor_torque=torque))
    named = {each.term.name: each for each in side.estimates}
    assert not {f"{kind} of j2" for kind in ("offset", "coulomb", "viscous")} & named.keys()
    for number in (1, 3):
        found = named[f"coulomb of j{number}"]
        assert abs(found.value - COULOMB[number - 1]) < 2 * found.half_width
    assert side.fit.shown.shape[1] == side.fit.residual.shape[1] == 2
    assert (side.names, side.measured) == (("j1", "j2", "j3"), ("j1", "j3"))


@pytest.mark.parametrize(("level", "times"), [("armature", 1.0), ("coupled", (RATIO - 1) / RATIO)])
def test_a_coupled_rotor_is_armature_less_one_share_of_its_ratio(level, times):
    """By the identity a coupled rotor adds N (N - 1) J: intervals of 95 % cover these."""
    found = compared_arm(level)[1]
    side = found.sides[0]
    (rotor,) = side.seen
    assert rotor.term.name == "armature of j3"
    assert [each.name for each in side.contained] == ["armature of j1", "armature of j2"]
    assert abs(rotor.value - times * RATIO**2 * ROTOR) < 1.5 * rotor.half_width
    assert rotor.half_width < RATIO**2 * ROTOR / 100  # enough to tell the two values
    by_name = {each.term.name: each for each in side.estimates}
    for number, (coulomb, viscous) in enumerate(zip(COULOMB, VISCOUS, strict=True), 1):
        for kind, value in (("coulomb", coulomb), ("viscous", viscous)):
            each = by_name[f"{kind} of j{number}"]
            assert abs(each.value - value) < 2 * each.half_width
    assert found.ranks.are_equal
    assert found.is_decided


def test_levels_differ_where_a_stator_is_elsewhere(robot):
    assert compare_levels(robot, np.zeros((0, 3))).are_equal
    moved = chains.robot(
        robot.urdf,
        {"j3": chains.geared(RATIO, ROTOR) | {"stator": "a", "rotor_axis": [0.0, 0.0, 1.0]}},
    )
    ranks = compare_levels(moved, np.zeros((0, 3)))
    assert not ranks.are_equal
    assert (ranks.both, ranks.armature) == (ranks.links + 2, ranks.links + 1)


@pytest.mark.parametrize("size", [1.0, 1e-9])
def test_a_rank_does_not_depend_on_the_units_of_columns(size):
    columns = np.random.default_rng(3).normal(size=(20, 2, 5)) * [1.0, 1.0, size, size, 1.0]
    assert _rank(columns) == 5
    columns[..., 4] = columns[..., 0] + columns[..., 2] / size
    assert _rank(columns) == 4


def test_torques_behind_the_gears_show_no_rotor(robot, coupled):
    """Of one motion: with the rotors before the gears, without them behind."""
    motors, sensors = coupled[0], recording(robot, "links")
    assert first_side(robot, behind(sensors)).seen == ()
    both = type(motors)(
        "both", motors.time, motors.position, motors.motor_torque, sensors.motor_torque
    )
    sides = {(each.side, each.links): each for each in compared(robot, both).sides}
    between, before = sides["between", "none"], sides["motor", "identified"]
    after = sides["joint", "identified"]
    assert {each.term.name for each in between.seen} == {f"armature of j{n}" for n in (1, 2, 3)}
    assert [each.term.name for each in before.seen] == ["armature of j3"]
    assert after.seen == ()


def test_a_motor_that_two_joints_turn_adds_what_they_share(robot):
    """Of T = J (N q2' + N q3')^2 / 2, torques are J N^2 (q2'' + q3'') at both."""
    shared = shared_motors(np.array([[RATIO, 0, 0], [0, RATIO, 0], [0, RATIO, RATIO]]))
    assert shared == pytest.approx(np.array([[0.0, 1.0, 1.0]]))
    assert not shared_motors(np.array([[0.0, 1, 1], [1, 0, 0], [0, 0, 1]])).size  # none of its own
    samples = draw_samples(robot, shared)
    columns = build_columns(robot, shared, samples)
    by_name = {term.name: columns.values[:, :, n] for n, term in enumerate(columns.terms)}
    whole = sum(
        by_name[name]
        for name in ("armature of j2", "armature of j3", "armature that j2 and j3 share")
    )
    both = samples.a[:, 1] + samples.a[:, 2]
    assert whole == pytest.approx(np.column_stack([0 * both, both, both]))


def test_rotors_of_the_robots_file_are_columns_of_their_own_size(robot):
    samples = draw_samples(robot, np.zeros((0, 3)))
    rotors = RotorRegressor(robot, robot.rotors).compute(samples)
    state = samples.q, samples.v, samples.a
    apart = [
        build_robot_model("pinocchio", robot, level).inverse_dynamics(*state)
        for level in ("coupled", "links")
    ]
    values = np.array([term.value for term in rotors.terms])
    assert rotors.values @ values == pytest.approx(apart[0] - apart[1], abs=1e-9)


def test_armature_of_a_file_is_the_reflected_inertia_of_all_rotors_of_a_joint(robot):
    samples = draw_samples(robot, np.zeros((0, 3)))
    pairs = zip(robot.rotors, (60, -50), strict=False)
    geared = [replace(rotor, ratio=ratio) for rotor, ratio in pairs]
    harmed = replace(robot, rotors=(*geared, replace(geared[0], ratio=20)))
    terms = build_columns(harmed, np.zeros((0, 3)), samples).terms
    named = [term.value for term in terms if term.kind == "armature"]
    assert named == [pytest.approx(0.36 + 0.04), pytest.approx(0.25), None]  # N^2 J, kg m^2
    follower = replace(harmed, rotors=(replace(geared[0], joint=7),))  # of no coordinate
    assert _armatures(follower) == [None] * 3


DESCRIPTION = """
schema_version = 1
time = "seconds"
transmission = [[60, 0, 0], [0, 60, 0], [0, 60, 60]]
recordings = [{ position = "turns.csv", torque = "amps.csv" }]

[position]
columns = ["m1", "m2", "m3"]
shaft = "motor"

[motor_torque]
columns = ["a", "b", "c"]
gain = [0.5, 0.5, 0.5]
shaft = "motor"
"""
TURNS = np.array([[60.0, 0, 0], [0, 60.0, 0], [0, 60.0, 60.0]])


@pytest.fixture(scope="module")
def record_folder(robot, tmp_path_factory):
    """Motors' angles and currents of a recording, with semicolons and decimal commas."""
    folder = tmp_path_factory.mktemp("record")
    given = recording(robot, "coupled", seconds=8.0)
    motors = given.position @ TURNS.T
    currents = np.linalg.solve(TURNS.T, given.motor_torque.T).T / 0.5
    for name, head, table in (
        ("turns.csv", "seconds;m1;m2;m3", np.column_stack([given.time, motors])),
        ("amps.csv", "a;b;c", currents),
    ):
        rows = "\n".join(
            ";".join(f"{value:.10g}".replace(".", ",") for value in row) for row in table
        )
        (folder / name).write_text(f"{head}\n{rows}\n")
    (folder / "record.toml").write_text(DESCRIPTION)
    (folder / "robot.urdf").write_text(robot.urdf)
    return folder


def test_the_command_reads_what_motors_measured(crosscheck, record_folder, tmp_path, caplog):
    command = ("compare", record_folder / "record.toml", record_folder / "robot.urdf")
    answer = crosscheck(*command, "--json", tmp_path / "found.json", "--out", tmp_path)
    assert answer.code == 1, answer.err  # the URDF has no rotors
    assert not [each for each in caplog.messages if "in degrees?" in each]  # of many turns
    (line,) = (each for each in answer.out.splitlines() if "do not explain" in each)
    assert "armature of j3" in line
    assert "that j2 and j3 share" not in line  # the torques were made without such a motor
    content = json.loads((tmp_path / "found.json").read_text())
    (rotor,) = (
        each for each in content["sides"][0]["estimates"] if each["name"] == "armature of j3"
    )
    assert rotor["estimate"] == pytest.approx(0.354, abs=0.004)  # N (N - 1) J
    text = answer.out.removeprefix("Robot robot: ")
    assert content["answer"] == text.partition("\n\n")[0].splitlines()
    assert "<svg" in (tmp_path / "compare.html").read_text()


BAD = tomllib.loads(Path(__file__).with_name("bad_descriptions.toml").read_text())


@pytest.mark.parametrize("case", BAD)
def test_a_wrong_description_is_one_line(refuse, record_folder, case, snapshot: SnapshotAssertion):
    """By what becomes of the files: the line names file, field and what is allowed."""
    files = {file.name: file.read_text() for file in record_folder.iterdir()}
    file, old, new = BAD[case]
    assert old in files[file]
    files[file] = files[file].replace(old, new, 1)
    assert refuse("compare record.toml robot.urdf", files) == snapshot


def test_rows_are_counted_over_all_pieces_of_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_table, "PIECE", 3)
    (tmp_path / "long.csv").write_text("a,b,frame\n" + 7 * "1,2,x\n" + "3,,\n" + 4 * "1,2,x\n")
    with pytest.raises(InputError, match="b, data row 8: must be a number"):
        list(csv_table.open_table(tmp_path / "long.csv").select_pieces(("", "b")))


def test_torques_of_a_long_recording_are_read_as_they_are(tmp_path):
    """Were friction's steps rounded, they would differ from its direction in 600,000 rows."""
    (tmp_path / "long.csv").write_text("q,torque\n" + 60_000 * (5 * "0.1,2\n" + 5 * "0.2,-2\n"))
    (tmp_path / "record.toml").write_text(
        'schema_version = 1\nstep_s = 1e-3\nposition = { columns = ["q"] }\n'
        'recordings = [{ position = "long.csv" }]\nmotor_torque = { columns = ["torque"] }\n'
    )
    description = load_description(tmp_path / "record.toml")
    (found,) = read_recordings(description, chains.robot(chains.BOB), tmp_path / "record.toml")
    assert found.time[-1] == pytest.approx(599.999)
    assert len(found.time) == 600_000
    assert set(np.unique(found.motor_torque)) == {-2.0, 2.0}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"position": np.full((4000, 3), 0.3)}, "position: is the same in every row"),
        ({"motor_torque": np.zeros((4000, 3))}, "motor_torque: is 0 in every row: not measured"),
        ({"motor_torque": np.full((4000, 3), np.nan)}, "motor_torque: is 0 in every row"),
    ],
)
def test_a_recording_of_nothing_is_refused(robot, given, words):
    with pytest.raises(InputError, match=words):
        replace(recording(robot, "links", seconds=8.0), **given)


def test_a_link_alike_all_around_its_axis_is_no_disagreement():
    """Its joint has no torque: what engines have there is rounding of what cancels."""
    bob, turned = chains.Solid(0.2, (0, 0, 0.042), (0.0,) * 6), (1.57079632679, 3.14159265359, 0)
    links = [chains.link("base"), *map(chains.link, "ab", SOLIDS[:2]), chains.link("c", bob)]
    joints = [
        chains.joint("j1", "base", "a"),
        chains.joint("j2", "a", "b", axis=(0, 1, 0), at=(0.2, 0, 0.3)),
        chains.joint("j3", "b", "c", rpy=turned),
    ]
    robot = chains.robot(chains.urdf(*links, *joints))
    q, v, a = np.random.default_rng(0).uniform(-2, 2, (3, 50, 3))
    findings = compare_engines(SpatialRobot(robot), (q, v, a))
    exact = build_robot_model("analytic", robot, "links").inverse_dynamics(q, v, a)
    assert 0 < np.abs(exact[:, 2]).max() < 1e-15
    assert {each.verdict for each in findings} == {"agree"}


def test_rows_left_out_move_no_estimate(robot, coupled, monkeypatch):
    """Of the transform's rows a few are taken, and not every one that was recorded."""
    given, _ = coupled
    monkeypatch.setattr(compare, "choose_bandwidth", lambda *given: 1.9)
    few = first_side(robot, given).estimates
    monkeypatch.setattr(sampling, "RESOLVED", 1e9)
    every = first_side(robot, given).estimates
    assert [each.term for each in few] == [each.term for each in every]
    pairs = zip(few, every, strict=True)
    moved = np.array([(one.value - other.value) / other.error for one, other in pairs])
    assert 0 < np.sqrt((moved**2).mean()) < 0.2


def test_no_band_is_estimated_that_rows_do_not_resolve(robot):
    """Four rows in its shortest period are the least, and errors fall up to nearly that."""
    given, every = recording(robot, "links"), slice(None, None, 16)
    rows = (each[every] for each in (given.time, given.position, given.motor_torque))
    coarse = Record("coarse", *rows, None)
    side = first_side(robot, coarse)
    assert [band.bandwidth for band in side.bands] == [side.bandwidth / 2]
    assert side.bandwidth <= 1 / (8 * coarse.step) < 2 * side.bandwidth


def test_the_least_bandwidth_holds_the_motion():
    """Sines of 0.5 Hz, and a joint that trembles: of a long record, 20 periods are far less."""
    time = np.arange(0.0, 400.0, 0.01)
    turned = np.sin(np.pi * time)
    position = np.column_stack([turned, turned, 1e-4 * np.random.default_rng(0).normal(size=40000)])
    given = Record("long", time, position, position, None)
    assert lowest_bandwidth([given]) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("name", KINDS)
def test_recordings_that_are_wrong_in_a_way_are_said_to_be_so(name):
    """One of the hundred of each kind that benchmarks/bench_measured.py asks."""
    true, false, _ = judge(KINDS[name], 0)
    assert (true, false) == (True, False)


def test_no_other_gravity_is_named_where_it_is_right():
    found = compared_arm("armature")[1]
    assert found.tilt is None
    gravity = [each for each in found.gravities[0].estimates if each.term.kind == "gravity"]
    assert len(gravity) == 3
    assert all(abs(each.value) < 2 * each.half_width for each in gravity)


ONE_DEGREE = (9.81 * np.tan(np.radians(1.0)), 0.0, 0.0)  # of a component across gravity


@pytest.mark.parametrize(
    ("degrees", "more", "half_width", "is_tilted"),
    [
        *((0.9, 0.0, ONE_DEGREE, False), (1.1, 0.0, ONE_DEGREE, True)),
        *((-1.1, 0.0, ONE_DEGREE, True), (6.0, 0.098, (1e-9,) * 3, True)),
        *((6.0, -0.098, (1e-9,) * 3, True), (6.0, 0.099, (1e-9,) * 3, False)),
    ],
)
def test_a_tilt_is_beyond_its_interval_and_of_the_files_size(degrees, more, half_width, is_tilted):
    """More than the angle's interval, and less than a hundredth of gravity longer or shorter."""
    angle = np.radians(degrees)
    turned = (9.81 + more) * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    estimate = GravityEstimate(turned, np.array(half_width), np.array([0.0, 0.0, -9.81]))
    assert estimate.is_tilted == is_tilted


def test_of_gravity_that_the_file_has_not_a_question_is_asked():
    """There is no angle to nothing; the plane of a planar arm may have any tilt."""
    value, half_width, none = np.array([0.0, -9.8, 0.0]), np.array([0.02, 0.03, 0.0]), np.zeros(3)
    whole = GravityEstimate(value, half_width, none)
    assert (whole.angle_deg, whole.is_tilted) == (None, True)
    assert whole.describe() == (
        "Is the base tilted? With the file's links gravity (0.000, -9.800, 0.000) ± 0.030 m/s^2"
        " in the base's frame (the file says (0, 0, 0)) alone explains the torques."
    )
    assert GravityEstimate(0.4 * value, half_width, none, (0, 1)).is_tilted
    assert not GravityEstimate(0.4 * value, half_width, none).is_tilted
    assert not GravityEstimate(1.2 * value, half_width, none, (0, 1)).is_tilted


@pytest.mark.parametrize("lag_hz", [None, 6.0])
def test_what_a_lag_of_one_drive_makes_of_a_delay_depends_on_the_band(robot, lag_hz):
    """The last motor's torque follows through a low-pass of first order, which no term is."""
    found = compared_arm("armature")[1]
    if lag_hz:
        given = recording(robot, "armature", seconds=20.0)
        torque, kept = given.motor_torque.copy(), np.exp(-2 * np.pi * lag_hz * STEP)
        for row in range(1, len(torque)):
            torque[row, 2] = kept * torque[row - 1, 2] + (1 - kept) * torque[row, 2]
        found = compared(robot, replace(given, motor_torque=torque))
    side = found.sides[0]
    flagged = [each for each in side.estimates if each.doubled is not None]
    assert [each.term.kind for each in flagged] == (["delay"] if lag_hz else [])
    for each in flagged:
        (wide,) = (band for band in side.bands if band.bandwidth > side.bandwidth)
        (there,) = (other for other in wide.estimates if other.term == each.term)
        assert each.doubled == there.value
        assert any(other.doubled is not None for other in side.judgement.levels[0].friction)
        text = format_estimate(each)
        assert "depends on the band" in text
        assert "+-" not in text
        assert output._estimate_content(each)["half_of_95_percent_interval"] is None
