"""Trials of arms and of robots name the line, at no cost where all is right, and change nothing."""

import importlib
import json
import linecache
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from crosscheck.cli.files.robot_files import export_as_robot
from crosscheck.cli.files.template import make_plain_arm
from crosscheck.models.arm.arm import Arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.provenance import ROOT
from crosscheck.testing import Equations, assert_agrees, try_equations
from crosscheck.trial.source import worker
from crosscheck.trial.tables.folder import format_arm_toml
from tests.robots import chains, two_link
from tests.schemas import assert_follows
from tests.trial import robot_errors
from tests.trial.test_dependence import arm_of

LITERAL = """
import numpy as np
from crosscheck import Equations

l1, c1, c2 = 0.6, 0.25, 0.2
m1, m2, J1, J2 = 4.0, 2.5, 0.1, 0.06

def mass_matrix(q):
    m22 = J2 + m2 * c2**2
    m12 = m22 + m2 * c2 * l1 * np.cos(q[1])
    m11 = J1 + m1 * c1**2 + m2 * l1**2 + 2 * m12 - m22
    return np.array([[m11, m12], [m12, m22]])

def bias(q, v):
    h = m2 * c2 * l1 * np.sin(q[1])
    return np.array([-h * (2 * v[0] * v[1] + v[1] ** 2), h * v[0] ** 2])

model = Equations(mass_matrix=mass_matrix, bias=bias)
"""
BY_FILE = (
    LITERAL[: LITERAL.index("l1,")]
    + """
def model(arm):
    a, b = arm.links
    l1, c1, c2 = a.length_m, a.com_m, b.com_m
    m1, m2, J1, J2 = a.mass, b.mass, a.inertia, b.inertia
"""
    + textwrap.indent(LITERAL[LITERAL.index("def mass") :].replace("model = ", "return "), "    ")
)
ABSOLUTE = """
import numpy as np
from crosscheck import Equations

l1, c1, c2 = 0.6, 0.25, 0.2
m1, m2, J1, J2 = 4.0, 2.5, 0.1, 0.06

def mass_matrix(q):
    m12 = m2 * c2 * l1 * np.cos(q[0] - q[1])
    return np.array([[J1 + m1 * c1**2 + m2 * l1**2, m12], [m12, J2 + m2 * c2**2]])

def bias(q, v):
    h = m2 * c2 * l1 * np.sin(q[0] - q[1])
    return np.array([h * v[1] ** 2, -h * v[0] ** 2])

model = Equations(mass_matrix=mass_matrix, bias=bias)
"""
GRAVITY = """
import numpy as np
from crosscheck import Equations

g1, g2 = (4.0 * 0.25 + 2.5 * 0.6) * 9.81, 2.5 * 0.2 * 9.81

def gravity(q):
    outer = g2 * np.sin(q[0] + q[1])
    return np.array([g1 * np.sin(q[0]) + outer, outer])

model = Equations(gravity=gravity)
"""
MADE_AT_TOP = """multiply = lambda a, b: a * b
moment = multiply(m2, c2) * l1

class Chain:
    def bias(self, q, v):
        return bias(q, v)

def bias("""
SQUARE = "v[1] ** 2)", "v[1])"


@pytest.fixture
def arm() -> Arm:
    return arm_of((4.0, 0.6, 0.25, 0.1), (2.5, 0.45, 0.2, 0.06))


def write_model(folder: Path, text: str, *replaced: tuple[str, str]) -> str:
    for right, wrong in replaced:
        assert right in text
        text = text.replace(right, wrong, 1)
    (folder / "mine.py").write_text(text, encoding="utf-8")
    return f"{folder / 'mine.py'}:model"


def find_line(text: str, piece: str) -> int:
    return text[: text.index(piece)].count("\n") + 1


def test_a_number_of_ones_own_in_the_place_of_the_files_is_its_name(tmp_path, arm):
    model = write_model(tmp_path, BY_FILE, ("a.mass, b.mass", "a.mass, 2.9"))
    (edit,) = try_equations(model, arm).change.edits
    assert (edit.line, edit.new) == (find_line(BY_FILE, "m1, m2,"), "b.mass")


def test_the_friction_that_a_row_of_the_bias_lacks_is_a_term_and_a_line(tmp_path, arm):
    rubs = [
        joint.model_copy(update={"friction_N_m_s_per_rad": c})
        for joint, c in zip(arm.joints, (0.35, 0.22), strict=True)
    ]
    numbers = "    k1, k2 = (joint.friction_N_m_s_per_rad for joint in arm.joints)\n\n    def bias"
    row = "h * v[0] ** 2 + k2 * v[1]"
    text = BY_FILE.replace("    def bias", numbers).replace("h * v[0] ** 2", row)
    text = text.replace("([-h * (", "([k1 * v[0] - h * (")
    damped = arm.model_copy(update={"joints": tuple(rubs), "gravity_m_per_s2": (0.0, 0.0)})
    assert try_equations(write_model(tmp_path, text), damped).exit_code == 0
    # The file that was tried has changed.
    trial = try_equations(write_model(tmp_path, text, (" + k2 * v[1]", "")), damped)
    (edit,) = trial.change.edits
    assert (edit.line, edit.new) == (find_line(text, row), "+ k2 * v[1]")
    assert any("missing term: -c2 theta_2'" in each for each in trial.causes)


NUMBER, CALL = ("4.0, 2.5,", "4.0, 2.6,"), ("multiply(m2, c2)", "multiply(m2, c1)")


@pytest.mark.parametrize(
    ("give", "wrong"),
    [
        (lambda mine: mine.model, CALL),
        (lambda mine: mine, NUMBER),
        (lambda mine: mine.chain, CALL),
        (lambda mine: Equations(bias=mine.chain.bias), NUMBER),
        (lambda mine: Equations(bias=mine.turn), CALL),
    ],
    ids=["equations", "module", "object", "method", "lambda"],
)
def test_what_stands_at_the_top_of_a_module_is_edited_too(give, wrong, tmp_path, arm, monkeypatch):
    text = LITERAL.replace("def bias(", MADE_AT_TOP, 1).replace("m2 * c2 * l1 * np", "moment * np")
    text += "turn = lambda q, v: bias(q, v)\nchain = Chain()\n"
    write_model(tmp_path, text, wrong)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    (edit,) = try_equations(give(importlib.import_module("mine")), arm).change.edits
    assert edit.line == find_line(text, wrong[0])


def test_the_line_is_named_and_nothing_is_written(tmp_path, arm):
    model = write_model(tmp_path, BY_FILE, SQUARE)
    before = {each: each.read_bytes() for each in tmp_path.iterdir()}
    trial = try_equations(model, arm)
    answer = trial.change
    assert [each.place for each in answer.edits] == [f"mine.py:{find_line(BY_FILE, 'v[1] ** 2)')}"]
    assert "v[1] ** 2" in answer.edits[0].new
    assert answer.is_unequal
    assert {each: each.read_bytes() for each in tmp_path.iterdir()} == before


def test_the_line_is_named_where_other_coordinates_explain_all_too(tmp_path, arm):
    """One line turns all angles into degrees; an edit that mends one part alone is not offered."""
    text = BY_FILE.replace("(q[1])", "(bend(q))")
    text = text.replace("    def mass", "    def bend(q):\n        return q[1]\n\n    def mass")
    wrong = "return q[1]", "return np.radians(q[1])"
    trial = try_equations(write_model(tmp_path, text, wrong), arm)
    assert any("degrees" in each for each in trial.diagnosis.readings)
    assert [each.line for each in trial.change.edits] == [find_line(text, "return q[1]")]
    absolute = BY_FILE.replace("q[1])", "q[1] - q[0])")
    trial = try_equations(write_model(tmp_path, absolute), arm)
    assert trial.change is None or trial.change.is_whole


# On what a chain of mass points needs, which is right and in another file.
MOMENTS = """
import numpy as np
from chain_of_points import Chain as ChainOfPoints

class Chain(ChainOfPoints):
    def inverse_dynamics(self, q, v, a):
        torques = super().inverse_dynamics(q, v, a)
        omega, alpha, poses, bodies = np.zeros(3), np.zeros(3), self.poses(q), self.robot.bodies
        for k, (Rot, org, axis) in enumerate(poses):
            alpha = alpha + axis * a[k] + np.cross(omega, axis * v[k])
            omega = omega + axis * v[k]
            inertia = Rot @ bodies[k].inertia @ Rot.T
            twist = inertia @ alpha + np.cross(omega, inertia @ omega)
            torques[: k + 1] += [pose[2] @ twist for pose in poses[: k + 1]]
        return torques
"""


def test_two_errors_of_inverse_dynamics_are_one_answer(tmp_path):
    """The first is mended at zero rates, where the second has no effect."""
    recursion = ROOT / "benchmarks" / "source_edits" / "recursion.py"
    points = recursion.read_text(encoding="utf-8")
    twist = "twist = inertia @ alpha + np.cross(omega, inertia @ omega)"
    assert points.count(twist) == 1
    points = points.replace(twist, "twist = np.zeros(3)")
    (tmp_path / "chain_of_points.py").write_text(points, encoding="utf-8")
    errors = (
        ("Rot @ bodies[k].inertia @ Rot.T", "Rot.T @ bodies[k].inertia @ Rot"),
        ("np.cross(omega, inertia @ omega)", "np.cross(inertia @ omega, omega)"),
    )
    model = write_model(tmp_path, MOMENTS, *errors)
    robot = chains.robot(robot_errors.TURNED.urdf, {f"j{n}": chains.geared(3.0) for n in (1, 2)})
    answer = try_equations(model.replace(":model", ":Chain"), robot).change
    assert answer.wrong == ()
    assert answer.level == "links"  # not the one that two errors are nearest to
    assert [each.line for each in answer.edits] == [find_line(MOMENTS, old) for old, _ in errors]


def test_a_stated_level_may_be_one_with_another(tmp_path, arm):
    """Without rotors all are the rigid arm."""
    stated = LITERAL.replace("bias=bias)", 'bias=bias, level="coupled")')
    assert try_equations(write_model(tmp_path, stated), arm).exit_code == 0


def test_right_equations_are_not_searched(tmp_path, arm, monkeypatch):
    monkeypatch.setattr(worker, "RankTask", None)
    trial = try_equations(write_model(tmp_path, BY_FILE), arm)
    assert trial.exit_code == 0
    assert trial.change is None


@pytest.mark.parametrize(
    ("text", "slip"),
    [
        (LITERAL, ("2 * m12", "m12")),
        (ABSOLUTE, ("J2 + m2 * c2**2", "J2 + m2 * c2")),
        (GRAVITY, ("sin(q[0] + q[1])", "sin(q[1])")),
    ],
    ids=["relative angles", "absolute angles that are not stated", "one edit in either"],
)
def test_an_arm_and_a_robot_have_the_same_answer(text, slip, tmp_path, arm, snapshot):
    model = write_model(tmp_path, text, slip)
    trials = [try_equations(model, machine) for machine in (arm, make_robot(arm, tmp_path))]
    of_arm, of_robot = (
        [(each.line, each.old, each.new) for each in trial.change.edits] for trial in trials
    )
    assert of_arm == of_robot
    assert [line for line, *_ in of_arm] == [find_line(text, slip[0])]
    assert [trial.notes for trial in trials] == snapshot


def test_absolute_angles_that_are_not_stated_are_judged_on_other_arms_too(tmp_path, arm):
    """A term as large as m2 c2 by chance is none: numbers of other arms are unequal."""
    body = ABSOLUTE[ABSOLUTE.index("def mass") :].replace("model = ", "return ")
    head = BY_FILE[: BY_FILE.index("    def mass")]
    by_file = head + textwrap.indent(body, "    ")
    model = write_model(tmp_path, by_file, ("J2 + m2 * c2**2", "J2 + m2 * c2 * l1"))
    trial = try_equations(model, arm)
    assert "judged in absolute angles" in "".join(trial.notes)
    assert trial.change.is_unequal
    assert [each.line for each in trial.change.edits] == [find_line(by_file, "J2 + m2 * c2**2")]


def test_functions_of_a_file_are_equations_without_a_name(tmp_path, arm):
    model = write_model(tmp_path, LITERAL, SQUARE)
    whole, named = (try_equations(each, arm).change for each in (model.partition(":")[0], model))
    assert whole == named
    assert whole.is_whole


def test_numbers_that_are_in_the_code_are_said_to_be(tmp_path, arm):
    answer = try_equations(write_model(tmp_path, LITERAL, SQUARE), arm).change
    assert not answer.is_unequal
    assert any("with these numbers" in each for each in answer.sentences)


@pytest.mark.parametrize("is_robot", [False, True])
def test_what_fits_by_chance_is_no_remedy_of_code_with_the_files_numbers(tmp_path, is_robot):
    """m r is 1: r alone would do as well as m r^2."""
    arm = arm_of((2.5, 0.9, 0.4, 0.07))
    mechanism = make_robot(arm, tmp_path) if is_robot else arm
    text = """
import numpy as np

m, r, J = 2.5, 0.4, 0.07

def mass_matrix(q):
    return [[J + m * r**2]]

def gravity(q):
    return [m * 9.81 * r * np.sin(q[0])]
"""
    model = write_model(tmp_path, text, ("r**2", "r")).partition(":")[0]
    answer = try_equations(model, mechanism).change
    assert answer.is_unequal
    assert [each.new for each in answer.edits] in (["r ** 2"], ["m * r ** 2"])
    assert not answer.alternatives


def make_robot(arm: Arm, folder: Path) -> Robot:
    """The arm as a robot, by its files."""
    file = folder / "arm.toml"
    file.write_text(format_arm_toml(arm), encoding="utf-8")
    export_as_robot(str(file), [], folder / "robot.urdf")
    return load_robot(str(folder / "robot.toml"))


def forgetful(robot):
    """M of the pendulum, its rotors forgotten once."""

    def mass_matrix(q):
        wave = two_link.COUPLED * np.cos(q[1])
        first = two_link.SHOULDER + two_link.ELBOW + 2 * wave + two_link.REFLECTED
        other = two_link.ELBOW - wave
        return np.array([[first, other], [other, two_link.ELBOW + two_link.REFLECTED]])

    return Equations(mass_matrix=mass_matrix, bias=two_link.bias)


def test_the_message_of_a_test_names_the_line():
    line = forgetful.__code__.co_firstlineno + 6
    with pytest.raises(AssertionError, match=rf"test_trials.py:{line}: .*; then.* all parts agree"):
        assert_agrees(forgetful, two_link.robot())


def test_functions_inside_a_function_are_edited():
    sign = 1.0

    def bias(q, v):
        squares = np.array([-2 * v[0] * v[1] - v[1] ** 2, v[0]])
        return sign * two_link.COUPLED * np.sin(q[1]) * squares

    given = Equations(mass_matrix=two_link.mass_matrix, bias=bias)
    assert try_equations(given, two_link.robot()).change is None  # of two files
    answer = try_equations(Equations(bias=bias), two_link.robot()).change
    assert answer.edits[0].line == bias.__code__.co_firstlineno + 1


WEIGHTS = """
import numpy as np
from crosscheck import Equations

def model(arm):
    one, two = arm.links
    m1, m2, mp, g = one.mass, two.mass, arm.payload_mass_kg, 9.81
    d1, d2, L1, L2 = one.com_m, two.com_m, one.length_m, two.length_m
    def bias(q, v):
        h = (m2 * d2 + mp * L2) * L1 * np.sin(q[1])
        return [-h * (2 * v[0] * v[1] + v[1] ** 2), h * v[0] ** 2]
    def gravity(q):
        g2 = m2 * d2 * g * np.cos(q[0] + q[1])
        return [(m1 * d1 + (m2 + mp) * L1) * g * np.cos(q[0]) + g2, g2]
    return Equations(bias=bias, gravity=gravity)
"""


def test_a_forgotten_product_of_another_function_is_offered_and_nothing_that_fits_by_chance(
    tmp_path,
):
    """With a payload of 1 kg ``+ L2`` mends all here, but not on an arm of unequal numbers."""
    model = write_model(tmp_path, WEIGHTS)
    arm = make_plain_arm("mine", 2)
    assert arm.payload_mass_kg == 1.0
    answer = try_equations(model, arm).change
    assert [(each.line, each.new) for each in answer.edits] == [(13, "m2 * d2 + mp * L2")]
    assert answer.is_unequal
    assert not answer.alternatives


def test_a_cell_of_a_notebook_is_edited(arm):
    text = textwrap.dedent("""
        def model(arm):
            a, b = arm.links
            def mass_matrix(q):
                m22 = b.inertia + b.mass * b.com_m**2
                m12 = m22 + b.mass * b.com_m * a.length_m * cos(q[0])
                m11 = a.inertia + a.mass * a.com_m**2 + b.mass * a.length_m**2
                return [[m11 + 2 * m12 - m22, m12], [m12, m22]]
            return Equations(mass_matrix=mass_matrix)
        """)
    linecache.cache["<cell 3>"] = len(text), None, text.splitlines(keepends=True), "<cell 3>"
    names = {"Equations": Equations, "cos": np.cos}
    exec(compile(text, "<cell 3>", "exec"), names)
    answer = try_equations(names["model"], arm).change
    assert answer.edits[0].place == "<cell 3>:6"


def test_what_has_no_source_is_left_out():
    names = {"np": np}
    exec("def bias(q, v):\n    return np.array([q[0], q[1]])", names)
    assert try_equations(Equations(bias=names["bias"]), two_link.robot()).change is None
    assert try_equations(Equations(bias=lambda q, v: q), two_link.robot()).change is None


def test_a_robot_that_edits_would_change_stays_as_it_is():
    robot = chains.robot(two_link.URDF)
    places = [joint.placement.position.copy() for joint in robot.joints]

    def model(robot):
        def gravity(q):
            p = robot.joints[1].placement.position
            lever = p + robot.bodies[1].com
            return np.array([lever[0] * q[0], q[1]])

        return Equations(gravity=gravity)

    try_equations(model, robot)
    positions = [joint.placement.position for joint in robot.joints]
    assert np.array_equal(positions, places)
    assert all(position.flags.writeable for position in positions)


def test_an_edit_that_does_not_end_costs_little(tmp_path, arm, monkeypatch):
    loop = "    h = 0.0\n        k = 0\n        while k < 4:\n            k += 1\n            h = "
    text = BY_FILE.replace("    h = ", loop).replace("2 * v[0]", "v[0]")
    answer = try_equations(write_model(tmp_path, text), arm).change
    assert [each.line for each in answer.edits] == [find_line(text, "v[0] * v[1]")]


def test_an_edit_that_would_write_a_file_writes_none(tmp_path, arm):
    (tmp_path / "kept.txt").write_text("kept", encoding="utf-8")
    careful = f"""
    names = ["{tmp_path}/kept.txt", "/dev/null"]
    modes = ["w", "r"]
    def bias(q, v):
        i = 1
        with open(names[i - 1], modes[i]):
            pass
"""
    text = BY_FILE.replace("\n    def bias(q, v):\n", careful)
    assert try_equations(write_model(tmp_path, text, SQUARE), arm).change is not None
    assert (tmp_path / "kept.txt").read_text(encoding="utf-8") == "kept"


def test_the_views_show_the_line(tmp_path, arm):
    trial = try_equations(write_model(tmp_path, BY_FILE, SQUARE), arm)
    assert "mine.py:" in repr(trial)
    trial.write_report(tmp_path / "report")
    page = (tmp_path / "report" / "trial.html").read_text(encoding="utf-8")
    assert "<del>v[1]</del> <ins>v[1] ** 2</ins>" in page
    content = json.loads((tmp_path / "report" / "trial.json").read_text(encoding="utf-8"))
    assert_follows(content, "trial")
    (edit,) = content["change"]["edits"]
    assert edit["file"] == "mine.py"
