"""Own equations of a robot: the wrong number is named, and right equations are never blamed."""

import html
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import RIGID, Robot
from crosscheck.trial.changes.mistakes import (
    RobotMistake,
    list_frame_mistakes,
    list_part_mistakes,
    list_whole_bodies,
)
from crosscheck.trial.changes.numbers import RobotNumber, list_numbers, put_value
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import Trial, TrialDiagnosis
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.robots import chains
from tests.robots.trials import robot_equations, run_robot_trial
from tests.tool.test_bad_input import assert_one_line

PLANTED = 2 if DRAWS == SAMPLE else DRAWS
PRODUCT = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0]])
Change = Callable[[Robot], Robot]


@pytest.fixture(scope="module")
def sliding() -> Robot:
    return load_robot("sliding")


@pytest.mark.parametrize("level", RIGID)
@pytest.mark.parametrize("engine", chains.ENGINES)
def test_right_equations_are_never_blamed(engine, level):
    """One robot each, in turn: every engine and every level meets every one of them."""
    robots = load_robot("six-joint"), chains.random_chain(3), chains.random_chain(10)
    own = robots[(chains.ENGINES.index(engine) + RIGID.index(level)) % 3]
    trial = run_robot_trial(robot_equations(own, level, engine), own)
    assert trial.agrees
    assert trial.diagnosis == TrialDiagnosis(trial.diagnosis.level)


def planted(own: Robot, seed: int) -> RobotMistake:
    """A number of it that is another, or one thing taken for another."""
    rng, among = np.random.default_rng(seed), list[RobotNumber | RobotMistake](list_numbers(own))
    among += list_frame_mistakes(own, "coupled")
    for part in list_whole_bodies(own):
        for words, other in list_part_mistakes(own, part).items():
            robot = put_value(own, ("bodies", part.number), other)
            among.append(RobotMistake(f"{part.name}: {words}", robot))
    chosen = among[rng.integers(len(among))]
    if isinstance(chosen, RobotMistake):
        return chosen
    by = chosen.step * rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 0)
    return RobotMistake(chosen.name, chosen.put(chosen.value + by))


def is_named(error: RobotMistake, trial: Trial) -> bool:
    """Whether an explanation says the words of an error.

    One of every part, of which it changes one alone, is named as one of that.
    """
    words = error.words.partition(": ")[2] if error.several else error.words
    lump = ", with what is fixed to it"  # it is planted into whole bodies
    return any(words in each.replace(lump, "") for each in trial.diagnosis.explanations)


@pytest.mark.campaign
def test_planted_errors_are_named_up_to_what_makes_the_same_equations():
    """Of numbers and confusions of any chain that change anything: 95 in a hundred at least."""
    first, named, asked = fresh_seed(), 0, 0
    for seed in range(first, first + PLANTED):
        own = chains.random_chain(seed)
        error = planted(own, seed)
        trial = run_robot_trial(robot_equations(error.robot), own, seed=seed)
        if not trial.agrees:
            asked += 1
            named += is_named(error, trial)
    assert asked
    assert named >= 0.95 * asked


@pytest.mark.usefixtures("workers")
def test_threads_are_judged_by_their_own_equations(sliding):
    right = robot_equations(sliding)
    wrong = replace(right, gravity=lambda q: 2 * right.gravity(q))
    with ThreadPoolExecutor(3) as pool:
        trials = list(pool.map(run_robot_trial, (right, wrong, right), 3 * (sliding,)))
    assert [trial.agrees for trial in trials] == [True, False, True]


UNUSABLE = {
    "mass_matrix has shape (2, 2), must be (3, 3)": ("mass_matrix", lambda q: np.eye(2)),
    "gravity is larger than 1e+50": ("gravity", lambda q: np.full(3, 1.02e50)),
    "holds an integer too large for a float": ("gravity", lambda q: [10**400, 0, 0]),
}


@pytest.mark.usefixtures("workers")
@pytest.mark.parametrize("words", UNUSABLE)
def test_answers_that_are_no_part_are_refused_with_what_came(sliding, words):
    part, answer = UNUSABLE[words]
    with pytest.raises(InputError) as caught:
        run_robot_trial(Equations(**{part: answer}), sliding)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    if "shape" in words:
        assert str(caught.value).endswith("; there are 3 coordinates")


CODE = """\
from types import SimpleNamespace
from dataclasses import replace
from numpy import sin
from crosscheck.analytic.robot.model import AnalyticRobot

def made(robot):
    heavier = replace(robot.bodies[1], mass=7.5)
    robot = replace(robot, bodies=(robot.bodies[0], heavier, robot.bodies[2]))
    model = AnalyticRobot(robot, "coupled")
    return SimpleNamespace(
        mass_matrix=lambda q: model.mass_matrix(q[None])[0],
        gravity=lambda q: model.gravity(q[None])[0],
    )

def raising(robot):
    return SimpleNamespace(gravity=lambda q: 1 / 0)

class Wordless(Exception):
    def __str__(self):
        raise RuntimeError

def wordless(robot):
    raise Wordless

class Torn:
    @property
    def gravity(self):
        raise RuntimeError("torn")

def torn(robot):
    return Torn()

def armlike(robot):
    robot.links

empty, numbers = SimpleNamespace(), SimpleNamespace(bias=3.0)
"""


def test_what_of_a_robots_files_is_not_used_is_reported(crosscheck, tmp_path):
    (tmp_path / "mine.py").write_text(CODE)
    urdf = load_robot("sliding").urdf.replace("</robot>", '<transmission name="t"/></robot>')
    (tmp_path / "r.urdf").write_text(urdf)
    (note,) = load_robot(str(tmp_path / "r.urdf")).notes
    words = ("trial", f"{tmp_path / 'mine.py'}:made", tmp_path / "r.urdf")
    answer = crosscheck(*words, "--json", tmp_path / "a.json", "--out", tmp_path)
    assert f"\nnote: {note}\n" in answer.out
    assert note in json.loads((tmp_path / "a.json").read_text())["notes"]
    assert f"Note: {note}" in html.unescape((tmp_path / "trial.html").read_text())


@pytest.mark.parametrize("name", ["wordless", "torn", "armlike", "empty", "numbers", "nobody"])
def test_code_that_cannot_be_used_is_one_line(refuse, name, snapshot: SnapshotAssertion):
    assert refuse(f"trial mine.py:{name} sliding", {"mine.py": CODE}) == snapshot


def test_options_of_both_are_taken(crosscheck, tmp_path):
    """A setting changes the robot that the equations are compared with; --quick changes nothing."""
    (tmp_path / "mine.py").write_text(CODE)
    words = "trial", f"{tmp_path / 'mine.py'}:made", "sliding", "--quick"
    plain, quick = crosscheck(*words[:-1]), crosscheck(*words)
    assert (quick.code, quick.out) == (plain.code, plain.out)
    answer = crosscheck(*words, "--set", "robot.gravity_m_per_s2=[0.0, 0.0, 0.0]")
    assert answer.out != quick.out
    wrong = crosscheck(*words, "--set", "arm.payload_mass_kg=1.0")
    assert_one_line(wrong, "path beginning with robot")


def test_a_urdf_alone_is_a_robot_without_rotors(crosscheck, tmp_path):
    (tmp_path / "mine.py").write_text(CODE.replace('"coupled"', '"links"'))
    (tmp_path / "r.urdf").write_text(load_robot("sliding").urdf)
    answer = crosscheck("trial", f"{tmp_path / 'mine.py'}:made", tmp_path / "r.urdf")
    assert (answer.code, answer.err) == (1, "")
    named = "boom: mass = 7.5 kg (file: 7.2 kg)"
    assert f"yours are the equations of the rigid robot with {named}\n" in answer.out
    missing = crosscheck("trial", f"{tmp_path / 'mine.py'}:made", tmp_path / "no.urdf")
    assert_one_line(missing, "no.urdf", "cannot be read")
