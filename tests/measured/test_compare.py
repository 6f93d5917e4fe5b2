"""Recorded motions of arms and robots: the true level is named, and a number that is wrong."""

import json
import re
import runpy
import sys
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.cli.files.robot_files import export_as_robot
from crosscheck.cli.files.template import make_plain_arm
from crosscheck.file_types import MEASURED, MEASURED_PAGE, is_file_of_type
from crosscheck.identification import compare
from crosscheck.identification.forward import run_windows
from crosscheck.identification.mechanism import ComparedMechanism, PlanarArm, SpatialRobot
from crosscheck.identification.messages import describe_answers
from crosscheck.identification.output import comparison_page, describe_comparison
from crosscheck.identification.restrictions import FileFits, compute_chance
from crosscheck.identification.sampling import sample, space_signals
from crosscheck.identification.terms import TorqueTerm
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.provenance import ROOT
from crosscheck.recordings.record import Record, read_record
from crosscheck.recordings.smoothing import check_rates
from crosscheck.registry import RIGID_LEVELS
from tests.arms import arm_of
from tests.loops import require_items
from tests.measured import robots
from tests.measured.records import (
    compared,
    first_problem,
    judged,
    level,
    list_explanations,
    motion,
    name_columns,
    record_of,
    write_table,
)
from tests.schemas import assert_follows
from tests.tool.test_bad_input import assert_one_line

PAYLOAD = "arm.payload_mass_kg"
SHIPPED = ROOT / "examples" / "recordings" / "payload.csv"


@pytest.fixture(scope="module")
def doors(tmp_path_factory) -> dict[str, ComparedMechanism]:
    """The same arm as its file and as the robot that is exported of it."""
    out = tmp_path_factory.mktemp("door") / "arm.urdf"
    export_as_robot("paper-labelled", [], out)
    exported = SpatialRobot(load_robot(str(out.with_suffix(".toml"))))
    return {"arm": PlanarArm(load_arm("paper-labelled")), "robot": exported}


@pytest.mark.parametrize("true", RIGID_LEVELS)
def test_the_true_level_is_named(labelled, true):
    comparison = compared(record_of(level(labelled, true)), labelled)
    judgement = comparison.sides[0].judgement
    assert list_explanations(judgement) == [(true, "")]
    assert judgement.changes == ()
    assert comparison.is_decided
    (first, second) = describe_answers(comparison)[:2]
    assert f"({true})" in first
    assert "next best" in second


@pytest.mark.parametrize(
    ("door", "path"), [("arm", PAYLOAD), ("robot", "robot.links.payload.mass_kg")]
)
def test_the_payload_is_named_through_both_doors(doors, door, path):
    comparison = compared(read_record(SHIPPED, 2), doors[door])
    judgement = comparison.sides[0].judgement
    assert list_explanations(judgement) == [("coupled", path)]
    estimate = judgement.best.estimate
    assert abs(estimate.value - 10.2) < estimate.half_width < 0.001
    assert not comparison.is_decided
    assert "payload (file: 10 kg) is 10.20033 ± 0.00058 kg." in describe_answers(comparison)[0]
    assert all(window.within > 0.9 for window in require_items(comparison.windows))


NUMBERS = {
    "robot.links.c.com_m.x": 0.13,
    "robot.links.c.inertia_kg_m2.yy": 0.05,
    "robot.joints.j3.rotor_inertia_kg_m2": 1.3e-4,
}


@pytest.mark.parametrize("path", NUMBERS)
def test_a_number_of_a_robot_is_named(path):
    """Centre, moment or rotor, in space and with friction; the moment is that of no other number
    but by what a motion of three joints shows."""
    own = SpatialRobot(robots.arm())
    changed = own.change({path: NUMBERS[path]})
    judgement = judged(robots.recording(changed.robot, "coupled"), own)
    paths = [each.parameter.path for each in judgement.explanations]
    assert path in paths
    estimate = judgement.explanations[paths.index(path)].estimate
    assert abs(estimate.value - NUMBERS[path]) < 2 * estimate.half_width


def test_numbers_of_a_robot_are_changed_as_they_say():
    """Torques of a body are linear in its mass and moments; nothing else changes."""
    own = SpatialRobot(robots.arm())
    before = {each.path: each.value for each in own.parameters}
    for parameter in require_items(own.parameters):
        changed = own.change({parameter.path: parameter.value + parameter.step})
        after = {each.path: each.value for each in changed.parameters}
        moved = {path for path in before if before[path] != after[path]}
        assert moved == {parameter.path}
        assert after[parameter.path] == pytest.approx(parameter.value + parameter.step)
    assert before["robot.links.b.mass_kg"] == 5.0


def test_what_adds_to_the_links_asks_for_more_than_one_level():
    """Rotors, or armatures whose rotors no file describes; a robot of links alone has one level."""
    own = robots.arm()
    bare = replace(own, rotors=())
    armoured = replace(bare, joints=(replace(own.joints[0], armature=0.3), *own.joints[1:]))
    counts = [len(SpatialRobot(each).levels) for each in (own, bare, armoured)]
    assert counts == [3, 1, 3]


def test_an_arm_without_gears_has_one_level_and_one_answer():
    """A wrong payload is one explanation, not one of each level that is the same there."""
    arm = arm_of(2, direct=[0, 1])
    motors = PlanarArm(arm)
    assert motors.levels[1:]
    assert not any("gear" in motors.describe_level(each.name) for each in motors.levels)
    bare = {"motor_mass_kg": 0.0, "rotor_inertia_kg_m2": 0.0}
    joints = tuple(joint.model_copy(update=bare) for joint in arm.joints)
    own = PlanarArm(arm.model_copy(update={"joints": joints}))
    comparison = compared(record_of(level(own.arm, "links"), rows=3000), own)
    assert [each.name for each in own.levels] == ["links"]
    assert comparison.is_decided
    heavier = own.change({PAYLOAD: 1.1 * own.arm.payload_mass_kg})
    changed = compared(record_of(level(heavier.arm, "links"), rows=3000), own)
    assert list_explanations(changed.sides[0].judgement) == [("links", PAYLOAD)]
    lines = [*describe_comparison(changed), *describe_answers(comparison)]
    assert not any(name in line for line in lines for name in ("(carriers)", "(coupled)"))
    assert "Eq. 1" not in comparison_page(changed)


@pytest.fixture(scope="module")
def short() -> tuple[Arm, Record]:
    """A plain arm and a record of 0.3 s."""
    arm = make_plain_arm("plain", 2)
    return arm, record_of(level(arm, "links"), rows=300)


def test_a_short_record_does_not_decide(short, snapshot):
    """Any links are small where accelerations are noise, and leave far less."""
    comparison = compared(short[1], short[0])
    assert comparison.is_fitting
    assert not comparison.has_explanation
    assert not comparison.is_decided
    assert (lines := describe_answers(comparison))[:2] == snapshot
    beginnings = ("The motion hardly shows", "The best of 100 sums of sines")
    assert all(line.startswith(each) for line, each in zip(lines[2:], beginnings, strict=True))
    printed = list(describe_comparison(comparison))
    for step in require_items(comparison.sides[0].steps):
        began = f"  {step.name}: {step.parameters} parameters, residual"
        assert sum(line.startswith(began) for line in printed) == 1
    away = [replace(each, error=1.0 + each.error) for each in comparison.windows]
    assert describe_answers(replace(comparison, windows=tuple(away)))[:2] == snapshot
    fits = [replace(each.fit, sigma=0 * each.fit.sigma + 40.0) for each in comparison.sides]
    sides = map(lambda side, fit: replace(side, fit=fit), comparison.sides, fits)
    assert describe_answers(replace(comparison, sides=tuple(sides)))[:1] == snapshot


def test_what_a_motion_hardly_shows_is_named_largest_part_first():
    """Of either sign; first of all a term that is in no column."""
    terms = [TorqueTerm("link", f"term {number}", "kg m^2") for number in range(5)]
    columns = SimpleNamespace(terms=terms[:4], alike=[])
    fit = SimpleNamespace(condition=1e5, weakest=np.array([0.4, 0.05, -0.9, 0.1]))
    named = compare._find_concerned(terms, columns, fit)
    assert named == tuple(terms[place].name for place in (4, 2, 0))
    fit.condition = 10.0
    assert compare._find_concerned(terms, columns, fit) == (terms[4].name,)


def test_a_right_file_fits_a_short_record_by_the_noise_of_accelerations(short, monkeypatch):
    arm, record = short
    assert judged(record, arm).explained
    monkeypatch.setattr(FileFits, "_compute_noise", lambda *given: np.zeros(2))
    assert not judged(record, arm).explained


def test_the_noise_of_accelerations_is_what_is_left_of_positions():
    """Of a joint that stands: 1e-4 rad, filtered twice."""
    noise = 1e-4 * np.random.default_rng(0).normal(size=(8000, 1))
    record = Record("made", 1e-3 * np.arange(8000), noise)
    rows = sample([space_signals(record, noise)], np.zeros((0, 1)), 20.0)
    assert rows.a.std(axis=0) == pytest.approx(rows.acceleration_noise, rel=0.1)


def test_where_a_joint_stands_friction_may_hold_any_torque(labelled):
    """So that coupled is not distinguished from armature; an encoder's steps are no noise."""
    model, time = level(labelled, "armature"), np.arange(4000) * 1e-3
    moved = motion(2, time, 0.3)
    for signal, value in zip(moved, (0.4, 0.0, 0.0), strict=True):
        signal[:, 1] = value
    torques = model.inverse_dynamics(*moved)
    torques += 0.1 * np.random.default_rng(0).normal(size=torques.shape)
    noisy = np.column_stack([np.round(moved[0][:, 0], 4), moved[0][:, 1]])
    explanations = list_explanations(judged(Record("a record", time, noisy, torques), labelled))
    assert sorted(explanations) == [("armature", ""), ("coupled", "")]


@pytest.mark.parametrize("true", ["carriers", "armature"])
def test_steps_of_an_encoder_hide_no_level(labelled, true):
    """Errors of steps are no white noise; what they hide is not distinguished, never wrong."""
    judgement = judged(record_of(level(labelled, true), encoder=4e-4), labelled)
    assert (true, "") in list_explanations(judgement)
    assert ("links", "") not in list_explanations(judgement)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_record_without_noise_fits_its_own_level(labelled, noise):
    """What filters leave of it is not what links of any kind would have to explain."""
    judgement = judged(record_of(level(labelled, "coupled"), noise=noise), labelled)
    assert list_explanations(judgement) == [("coupled", "")]


def test_a_number_that_no_file_may_hold_is_impossible(labelled):
    """Of a record with less inertia than the gears alone have."""
    lighter = record_of(level(labelled, "coupled"))
    less = motion(2, lighter.time, 0.3)[2] * [0.0, 5.0]
    judgement = judged(replace(lighter, motor_torque=lighter.motor_torque - less), labelled)
    impossible = [each for each in judgement.changes if each.mechanism is None]
    assert all(each.estimate.value + each.estimate.half_width < 0 for each in impossible)
    assert not any(each.explains for each in impossible)


def test_chances_of_joints_that_leave_less_or_far_more():
    """Beside those that a second program has, of ratios near 1 (guards.wrong_chances)."""
    further, left = np.full(4, 3.0), np.full(4, 40.0)
    assert compute_chance(np.full(4, 0.9), further, left) == 1.0
    assert compute_chance(np.array([1.0, 50.0, 1.0, 1.0]), further, left) < 1e-20


def test_rates_in_another_unit_are_refused(labelled):
    record = record_of(level(labelled, "links"), rows=500)
    rates = motion(2, record.time, 0.3)[1]
    check_rates(replace(record, rates=rates))
    for factor, text in ((180 / np.pi, "rates are in degrees"), (1e3, "times are in milliseconds")):
        with pytest.raises(InputError, match=text):
            check_rates(replace(record, rates=factor * rates))


def test_the_shipped_recording_is_what_its_script_makes(tmp_path):
    folder = ROOT / "examples" / "recordings"
    with patch.object(sys, "argv", ["", str(tmp_path / "again.csv")]):
        runpy.run_path(str(folder / "recorded_motion.py"))
    shipped, again = (read_record(path, 2) for path in (SHIPPED, tmp_path / "again.csv"))
    for one, other in (
        (shipped.position, again.position),
        (shipped.motor_torque, again.motor_torque),
    ):
        assert one == pytest.approx(other, abs=1.1e-3)  # rounding may turn a last digit
    assert SHIPPED.stat().st_size < 300_000


@pytest.mark.slow
def test_the_command_of_the_readme_answers_as_the_docs_say(crosscheck, monkeypatch):
    monkeypatch.chdir(ROOT)
    (command,) = re.findall(
        r"\.venv/bin/crosscheck (compare \S+ \S+)", (ROOT / "README.md").read_text()
    )
    answer = crosscheck(*command.split())
    assert answer.code == 1
    text, _, _ = answer.out.partition("\n\n")
    page = (ROOT / "docs" / "how-to" / "compare-a-recording.md").read_text()
    assert " ".join(text.split()) in " ".join(page.split())


def make_tilted(sort: str, degrees: float) -> tuple[ComparedMechanism, Record, np.ndarray]:
    """An arm or a robot, its record on a base that is turned, and gravity there."""
    if sort == "arm":
        arm = load_arm("three-unlike")
        gravity = complex(*arm.gravity_m_per_s2) * np.exp(1j * np.radians(degrees))
        there = gravity.real, gravity.imag
        tilted = arm.model_copy(update={"gravity_m_per_s2": there})
        record = record_of(level(tilted, "coupled"), rows=6000)
        return PlanarArm(arm), record, np.array([*there, 0.0])
    robot = robots.arm()
    there = pin.exp3(np.radians(degrees) * AXES["robot"]).T @ robot.gravity
    return SpatialRobot(robot), robots.recording(replace(robot, gravity=there), "armature"), there


AXES = {"arm": np.array([0.0, 0.0, -1.0]), "robot": np.array([0.6, -0.8, 0.0])}


@pytest.mark.parametrize(("sort", "degrees"), [("arm", -0.5), ("robot", 12.0)])
def test_gravity_is_asked_before_numbers_and_links_where_the_base_is_tilted(sort, degrees):
    own, record, gravity = make_tilted(sort, degrees)
    comparison = compared(record, own)
    tilt = comparison.tilt
    assert tilt is not None
    np.testing.assert_allclose(tilt.value, gravity, atol=2 * tilt.half_width.max())
    angle, half_width = tilt.angle_deg
    assert abs(angle - abs(degrees)) < 1.5 * half_width < 0.15
    across, axis = np.cross(tilt.value, own.robot.gravity), np.sign(degrees) * AXES[sort]
    assert axis @ across > 0.99 * np.linalg.norm(across)
    first = describe_answers(comparison)[0]
    assert any(f"is tilted by {angle:.{digits}f} ± " in first for digits in (2, 3, 4))
    assert f"the file says ({', '.join(f'{each:g}' for each in own.robot.gravity)})" in first
    if sort == "arm":
        assert f"degrees about (0, 0, {axis[2]:g}): " in first
    true = "coupled" if sort == "arm" else "armature"
    assert (true, "") in list_explanations(comparison.sides[0].judgement)
    assert not comparison.is_explained  # by the file's gravity
    identified = [side for side in comparison.sides if side.links == "identified"]
    assert sort == "arm" or all(side.seen for side in identified)
    assert len(comparison.gravities) == 1


@pytest.mark.parametrize("path", [PAYLOAD, "robot.links.b.mass_kg"])
def test_masses_and_a_right_gravity_are_no_tilt(path):
    is_arm = path == PAYLOAD
    own = PlanarArm(load_arm("three-unlike")) if is_arm else SpatialRobot(robots.arm())
    (value,) = (each.value for each in own.parameters if each.path == path)
    heavier = own.change({path: 1.1 * value})
    record = robots.recording(heavier.robot, "coupled")
    if is_arm:
        record = record_of(level(heavier.arm, "coupled"), rows=6000)
    problem = first_problem(own.robot, record)
    given = [record.motor_torque], problem.choose_bandwidth()
    _, tilt = compare._judge_gravity(problem, *given)
    assert tilt is None
    assert ("coupled", path) in list_explanations(judged(record, own))


def test_torques_of_a_scenarios_drive_are_those_of_its_law(crosscheck, labelled, tmp_path):
    """A run's motion without its torques, which the drive gives again; files may be replaced."""
    run = tmp_path / "run.nc"
    given = ("--scenario", "pd", "--t-end", "0.5")
    model = ("--model", "analytic:coupled")
    assert crosscheck("simulate", "paper-labelled", *model, *given, "--out", run).code == 0
    record = read_record(run, 2)
    assert record.motor_torque.shape == record.rates.shape == record.position.shape
    columns = name_columns(record)
    angles = {name: columns[name] for name in ("t_s", "theta_1_rad", "theta_2_rad")}
    bare = write_table(tmp_path / "bare.csv", angles)
    files = ("--json", tmp_path / "c.json", "--out", tmp_path)
    answer = crosscheck("compare", bare, "paper-labelled", "--scenario", "pd", *files)
    data = json.loads((tmp_path / "c.json").read_text())
    assert_follows(data, "measured")
    assert data["sides"][0]["with_the_files_numbers"]["levels"][0]["level"] == "coupled"
    assert is_file_of_type(tmp_path / "c.json", MEASURED)
    assert is_file_of_type(tmp_path / "compare.html", MEASURED_PAGE)
    assert "rigid gears (coupled) with the file's numbers" in answer.out.splitlines()[0]
    assert answer.code == 0
    assert_one_line(crosscheck("compare", bare, "paper-labelled"), "has no torques")


def test_noisy_angles_of_a_motion_that_swings_through_do_not_call_the_right_arm_off():
    """The start's errors grow a thousandfold, and by more in one sense than in the other."""
    arm = make_plain_arm("plain", 2)
    time = np.arange(2500) * 4e-3
    clean = record_of(level(arm, "links"), time=time, amplitude=0.8, noise=0.0)
    for seed in range(3):
        noise = 1e-3 * np.random.default_rng(seed).normal(size=clean.position.shape)
        record = replace(clean, position=clean.position + noise)
        windows = run_windows([(record, record.motor_torque)], PlanarArm(arm), "links", {})
        for window in require_items(windows):
            assert window.stays_s == window.time[-1] - window.time[0]
