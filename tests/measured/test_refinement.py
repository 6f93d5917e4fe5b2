"""Links known by their file, gains of drives and encoders' zeros, against identities and truth."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crosscheck.identification.refinement import Knowledge
from crosscheck.models.robot.robot import Robot
from tests.loops import require_items
from tests.measured.robots import RATIO, ROTOR, arm, recording
from tests.measured.second_refinement import refine_again
from tests.measured.unknowns import SECONDS, ask, estimate_unknowns, refinement


@pytest.fixture(scope="module")
def robot() -> Robot:
    return arm()


@pytest.mark.parametrize("level", ["armature", "coupled"])
def test_links_known_to_less_than_the_identity_moves_decide(robot, level):
    """J N is 0.006 kg m^2, some 2 % of the links' moments."""
    given = recording(robot, level, seconds=SECONDS)
    tight = ask(robot, given, Knowledge(0.002))
    found = tight.sides[0].refinement
    assert found.level == level
    assert tight.is_decided
    for each in found.best.estimates:
        if each.term.kind in ("armature", "rotors"):
            assert abs(each.value - RATIO**2 * ROTOR) < 1.5 * each.half_width
    loose = ask(robot, given, Knowledge(0.2))
    assert loose.sides[0].refinement.level is None
    assert not loose.is_decided


def test_links_that_are_not_as_known_name_no_level(robot):
    heavier = arm(robot.urdf.replace('mass value="5.0"', 'mass value="5.5"'))
    found = refinement(heavier, recording(robot, "coupled", seconds=SECONDS), Knowledge(0.002))
    assert found.is_surprising
    assert found.level is None
    assert not found.is_decided


@pytest.mark.parametrize(
    ("level", "knowledge"),
    [
        ("armature", Knowledge(0.01)),
        ("coupled", Knowledge(0.01)),
        ("armature", Knowledge(0.05, frozenset({"gains", "zeros"}))),
        ("armature", Knowledge(None, frozenset({"zeros"}))),
    ],
)
def test_a_second_program_refines_the_same(robot, level, knowledge):
    """1e-8 of standard errors or values: slopes in positions differ by their steps, 1e-10."""
    given = recording(robot, level, seconds=SECONDS)
    stated = robot if level == "coupled" else replace(robot, rotors=())
    side = ask(stated, given, knowledge).sides[0]
    (fit,) = (each for each in side.refinement.fits if each.level == level)
    own = {each.term.name: (each.value, each.error) for each in fit.estimates}
    ratios = [RATIO] * 3 if level == "coupled" else None
    second = refine_again(robot.urdf, given, side.bandwidth, knowledge, ratios)
    assert set(own) == set(second)
    for name, (value, error) in own.items():
        other, spread = second[name]
        assert abs(value - other) < 1e-8 * max(abs(value), error)
        assert spread == pytest.approx(error, rel=1e-6)


def test_gains_and_zeros_are_found():
    """Twice the 95 % intervals hold what is true, but for one of 15,000.

    How often the intervals do is counted by benchmarks/bench_refinement.py.
    """
    for each, value in require_items(estimate_unknowns(seed=0)):
        assert abs(each.value - value) < 2 * each.half_width
        assert each.half_width < 0.1


def test_zeros_that_links_make_up_are_not_told(robot):
    """An encoder before all links, or at the last: a body that stands otherwise is the same."""
    given = recording(robot, "armature", seconds=SECONDS)
    given = replace(given, position=given.position - np.array([0.0, 0.03, 0.0]))
    found = refinement(robot, given, Knowledge(None, frozenset({"zeros"})))
    assert found.best.contained == ("j1", "j3")
    (zero,) = (each for each in found.best.estimates if each.term.kind == "zero")
    assert abs(zero.value - 0.03) < 1.5 * zero.half_width
    assert zero.half_width < 0.03


def test_gains_without_anything_of_known_size_are_not_told(crosscheck, robot, tmp_path):
    answer = run(crosscheck, robot, tmp_path, 'estimate = ["gains"]\n', "")
    assert answer.code == 1
    assert "Gains of drives cannot be told" in answer.out


def test_the_command_takes_a_prior(crosscheck, robot, tmp_path):
    answer = run(crosscheck, robot, tmp_path, "", "\n[prior]\nlinks = 0.05\n")
    assert answer.code == 0, answer.out + answer.err
    assert "With the file's links known to 5 %: armature of j1" in answer.out
    for text, part in (("links = 0", "prior.links"), ("links = true", "prior.links")):
        answer = run(crosscheck, robot, tmp_path, "", f"\n[prior]\n{text}\n")
        assert (answer.code, len(answer.err.splitlines()), part in answer.err) == (2, 1, True)
    answer = run(crosscheck, robot, tmp_path, 'estimate = ["mass"]\n', "")
    assert (answer.code, len(answer.err.splitlines()), "estimate" in answer.err) == (2, 1, True)


def run(crosscheck, robot: Robot, folder: Path, top: str, bottom: str):
    """The answer to a record of armature's torques; top, bottom: more of its description."""
    given = recording(robot, "armature", seconds=SECONDS)
    names = ["t", "q1", "q2", "q3", "i1", "i2", "i3"]
    rows = np.column_stack([given.time, given.position, given.motor_torque])
    np.savetxt(folder / "r.csv", rows, delimiter=",", header=",".join(names), comments="")
    (folder / "robot.urdf").write_text(robot.urdf)
    (folder / "record.toml").write_text(
        f'schema_version = 1\ntime = "t"\n{top}recordings = [{{ position = "r.csv" }}]\n'
        '[position]\ncolumns = ["q1", "q2", "q3"]\n'
        f'[motor_torque]\ncolumns = ["i1", "i2", "i3"]\n{bottom}'
    )
    return crosscheck("compare", folder / "record.toml", folder / "robot.urdf")
