"""What a user's equations may do wrong: one clear line and exit code 2, or a failed check."""

from __future__ import annotations

import json
import os

import pytest

from crosscheck.runner import patience
from tests.tool.handed import model_file
from tests.tool.test_bad_input import assert_one_line

# What follows `two_link` in the file, the name that is handed over, and what the line must say.
UNUSABLE = {
    "a syntax error": ("def f(:", "f", "is not Python", "mine.py, line"),
    "a file that raises": ("1 / 0", "two_link", "raises ZeroDivisionError", "line 28"),
    "a file that exits": ("sys.exit(0)", "two_link", "raises SystemExit: 0", "line 28"),
    "a file whose import fails": ("import nonesuch", "two_link", "No module named 'nonesuch'"),
    "another name": ("", "two_lnk", "no two_lnk in", "there is two_link"),
    "a number": ("five = 5", "five", "is a int; must be Equations"),
    "nothing": ("none = Equations()", "none", "hands nothing over", "mass_matrix, bias"),
    "a factory of nothing": ("def f(arm): pass", "f", "returned None; must be Equations"),
    "a factory of a class": ("def f(arm): return Equations", "f", "returned a type"),
    "a factory that raises": (
        "def f(arm): return arm.limbs",
        "f",
        "raises AttributeError",
        "limbs",
        "mine.py, line 28",
    ),
    "a factory that exits": ("def f(arm): sys.exit()", "f", "raises SystemExit (mine.py, line 28)"),
    "a factory of other arguments": ("def f(m, l, w): pass", "f", "takes w; may take arm"),
    "a factory for three joints": (
        "def f(arm): a, b, c = arm.links",
        "f",
        "raises ValueError: not enough values to unpack (expected 3, got 2)",
    ),
    "a function in a factory's place": ("def M(q): return q", "M", "takes q, no arm; hand"),
    "an array for a function": (
        "e = Equations(mass_matrix=np.eye(2))",
        "e",
        "mass_matrix: is a ndarray; must be a function of x",
    ),
    "a function of something else": (
        "e = Equations(bias=lambda q, speed: q)",
        "e",
        "bias: takes speed, which is none of",
    ),
    "a mass matrix by the rates": (
        "e = Equations(mass_matrix=lambda q, v: np.eye(2))",
        "e",
        "mass_matrix: takes v, which is none of x or q",
    ),
    "bias twice": (
        "e = Equations(bias=lambda q, v: v, coriolis=lambda q, v: np.eye(2))",
        "e",
        "coriolis: give either bias or coriolis",
    ),
    "a level that is none": (
        "def f(arm): return replace(two_link(arm), level='gears')",
        "f",
        "level = 'gears': must be one of links, carriers, armature, coupled",
    ),
    "a level of geared equations": (
        "e = Equations(mass_matrix=lambda q: np.eye(6), level='links',"
        " coordinates=Coordinates(gearing='lumped'))",
        "e",
        "level = 'links': is of rigid models; coordinates.gearing is lumped",
    ),
    "switches that are none": (
        "def f(arm): return replace(two_link(arm), switches='omega_t')",
        "f",
        "switches: is a str; must be",
    ),
    "coordinates that are none": (
        "def f(arm): return replace(two_link(arm), coordinates='absolute')",
        "f",
        "coordinates: is a str; must be Coordinates",
    ),
}
MAPS = {
    "a gearing that is none": ("gearing='geared'", "gearing = 'geared'", "rigid, lumped, free"),
    "links that are none": ("links='mixed'", "links = 'mixed'", "relative, absolute"),
    "a matrix that does not fit": (
        "matrix=np.eye(3)",
        "matrix: has shape (3, 3), must be (2, 2), for the 2 rigid coordinates",
    ),
    "a ragged matrix": ("matrix=[[1, 0], [1]]", "matrix: has rows of unequal length"),
    "a matrix with NaN": ("matrix=[[1, np.nan], [0, 1]]", "matrix: has NaN at [0, 1]"),
    "a complex matrix": ("matrix=1j * np.eye(2)", "matrix: is complex, must be real"),
    "a singular matrix": ("matrix=[[1, 1], [2, 2]]", "matrix: is singular"),
    "an order without a name": ("order=('theta_1',)", "order: is without theta_2"),
    "an order of other names": ("order=('a', 'b')", "order: is without", "has unknown a, b"),
    "too many names": ("names=('a', 'b', 'c')", "names", "must be 2", "are 3"),
    "a matrix and a function": (
        "matrix=np.eye(2), function=lambda x: x",
        "give either matrix or function",
    ),
    "a function that does not fit": ("function=lambda x: x[:1]", "has shape (1,), must be (2,)"),
    "a function that raises": ("function=lambda x: x.y", "function: raises AttributeError"),
    "a function that exits": ("function=lambda x: sys.exit(0)", "function: raises SystemExit"),
    "a function of no state": (
        "function=lambda x: [x[0], 0 * x[1]]",
        "is singular at x = [",
        "other x give the same q",
    ),
    "a Jacobian that is not its own": (
        "function=lambda x: x, jacobian=lambda x: 2 * np.eye(2)",
        "is 2; differences of function give 1",
    ),
    "a Jacobian that does not fit": (
        "function=lambda x: x, jacobian=lambda x: np.eye(3)",
        "jacobian, for the 2 rigid coordinates of paper-labelled, 2 joints: has shape (3, 3)",
    ),
    "a Jacobian without a function": ("jacobian=lambda x: np.eye(2)", "needs function beside"),
}
# What the first call of a function shows: it can be no equation of this arm.
ANSWERS = {
    "a wrong shape": ("mass_matrix=lambda q: np.eye(3)", "mass_matrix has shape (3, 3)", "(2, 2)"),
    "a matrix for a vector": ("bias=lambda q, v: np.eye(2)", "bias has shape (2, 2)", "(2,)"),
    "a bias of geared equations": ("bias=lambda q, v: np.zeros(6)", "bias has shape (6,)"),
    "NaN": ("force=lambda torque: [np.nan, 0]", "force has NaN at [0], must be finite"),
    "infinity": ("force=lambda torque: [0, np.inf]", "force has an infinite number at [1]"),
    "complex numbers": ("bias=lambda q, v: 1j * q", "bias is complex, must be real"),
    "text": ("bias=lambda q, v: 'ab'", "bias is of type <U2, must be numbers"),
    "nothing": ("mass_matrix=lambda q: None", "mass_matrix is None, must be numbers"),
    "rows of unequal length": ("mass_matrix=lambda q: [[1], [1, 2]]", "rows of unequal length"),
    "symbols": (
        "mass_matrix=lambda q: __import__('sympy').Matrix([['m', 0], [0, 1]])",
        "mass_matrix is a",
        "must be numbers",
    ),
}


@pytest.fixture
def refused(crosscheck, tmp_path):
    """``refused(more, name, *fragments)``: exit code 2, one line, nothing written."""

    def refusal(more: str, name: str, *fragments: str) -> None:
        file = model_file(tmp_path, more)
        outputs = ["--json", tmp_path / "t.json", "--junit", tmp_path / "t.xml"]
        before = sorted(os.listdir(tmp_path))
        answer = crosscheck("trial", f"{file}:{name}", "--quick", "--jobs", 1, *outputs)
        assert_one_line(answer, *fragments)
        assert sorted({*os.listdir(tmp_path)} - {"__pycache__"}) == before

    return refusal


@pytest.mark.parametrize("case", UNUSABLE)
def test_unusable_equations_are_one_line(refused, case):
    more, name, *fragments = UNUSABLE[case]
    refused(more, name, "mine.py", *fragments)


@pytest.mark.parametrize("case", MAPS)
def test_unusable_coordinates_are_one_line(refused, case):
    given, *fragments = MAPS[case]
    more = f"def f(arm): return replace(two_link(arm), coordinates=Coordinates({given}))"
    refused(more, "f", "coordinates", *fragments)


@pytest.mark.parametrize("case", ANSWERS)
def test_answers_that_are_no_equations_are_one_line(refused, case):
    given, *fragments = ANSWERS[case]
    more = f"def f(arm): return replace(two_link(arm), {given})"
    refused(more, "f", "mine.py:f: ", " at ", *fragments)


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("mine", ["mine: must be file.py:name or package.module:name"]),
        ("mine.py", ["must be file.py:name"]),
        (":two_link", ["must be file.py:name"]),
        ("nonesuch.py:two_link", ["nonesuch.py:two_link: no such file"]),
        ("nonesuch.module:two_link", ["No module named 'nonesuch'"]),
        ("./:two_link", ["no such file"]),
        ("README.md:two_link", ["No module named"]),
        ("analytic:physical", ["no physical in analytic"]),
        ("x\ny.py:\x1b[31m", ["\\n", "\\x1b"]),
    ],
)
def test_names_of_nothing_are_one_line(crosscheck, text, fragments):
    assert_one_line(crosscheck("trial", text, "--quick"), *fragments)


def test_constant_equations_of_another_number_of_joints_name_both(crosscheck, tmp_path):
    more = "e = Equations(mass_matrix=lambda q: np.eye(2))"
    answer = crosscheck("trial", f"{model_file(tmp_path, more)}:e", "three-unlike", "--quick")
    assert_one_line(
        answer, "mass_matrix has shape (2, 2), must be (3, 3)", "three-unlike, 3 joints"
    )


@pytest.mark.parametrize(
    ("more", "fragments"),
    [
        (["--scenario", "nonesuch"], ["nonesuch: no such file"]),
        (["--scenario", "pd", "--scenario", "pd"], ["scenario: name = 'pd'", "no other"]),
        (["--set", "arm.payload=1"], ["payload", "payload_mass_kg"]),
        (["--json", "t", "--junit", "t"], ["is in use for two things"]),
    ],
)
def test_what_is_asked_beside_is_checked_first(crosscheck, tmp_path, monkeypatch, more, fragments):
    monkeypatch.chdir(tmp_path)
    answer = crosscheck("trial", f"{model_file(tmp_path)}:two_link", "--quick", *more)
    assert_one_line(answer, *fragments)


def test_runs_of_equations_without_forces_are_refused(crosscheck, tmp_path):
    more = "def f(arm): return replace(two_link(arm), force=None)"
    file = model_file(tmp_path, more)
    answer = crosscheck("trial", f"{file}:f", "--quick", "--scenario", "pd")
    assert_one_line(answer, "--scenario = 'pd': needs force, which the equations have not")


# What a part does instead of answering, and what its failed checks say.
MISBEHAVING = {
    "raises": ("def bad(*a): raise ValueError('what a\\nmess')", "ValueError: what a mess (bias"),
    "exits": ("def bad(*a): sys.exit(0)", "SystemExit: 0 (bias at x = ["),
    "interrupts": ("def bad(*a): raise KeyboardInterrupt", "KeyboardInterrupt"),
    "ends its process": ("def bad(*a): os._exit(0)", "Died: bias: the process of the model ended"),
    "crashes": ("def bad(*a): ctypes.string_at(0)", "Died: bias: the process of the model was"),
    "kills itself": ("def bad(*a): os.kill(os.getpid(), 9)", "was ended by SIGKILL"),
    "recurses": ("def bad(*a): return bad(*a)", "RecursionError"),
    "is NaN at some states": (
        "def bad(q, v): return [np.nan * (q[0] < -2), 0] if q[0] < -2 else 0 * v",
        "BadAnswer: bias has NaN at",
    ),
    "changes its shape": (
        "calls = []\ndef bad(q, v):\n    calls.append(1)\n    return np.zeros(1 + len(calls))",
        "BadAnswer: bias has shape (",
    ),
    "divides by zero": ("def bad(q, v): return [1 / 0, 0]", "ZeroDivisionError: division by zero"),
}


@pytest.fixture
def judged(crosscheck, tmp_path):
    """``judged(more, *options)``: exit code, JSON and what was printed of the trial of ``f``."""

    def judgement(more: str, *options: object):
        target = tmp_path / "trial.json"
        given = f"{model_file(tmp_path, more)}:f", "--quick", "--jobs", 1, "--json", target
        answer = crosscheck("trial", *given, *options)
        return answer, json.loads(target.read_text())

    return judgement


def verdicts(trial, part: str) -> set[str]:
    """Of the checks of a part against engines."""
    found = [f for f in trial["agreement"]["findings"] if f["family"] == "trial-states"]
    return {f["verdict"] for f in found if f["quantity"] == part and f["kind"] == "check"}


@pytest.mark.parametrize("case", MISBEHAVING)
def test_a_part_that_fails_costs_itself_alone(judged, case):
    source, said = MISBEHAVING[case]
    answer, trial = judged(f"{source}\ndef f(arm): return replace(two_link(arm), bias=bad)")
    assert answer.code == 1
    assert answer.err == ""
    assert said in answer.out
    assert verdicts(trial, "bias") == {"failed"}
    assert verdicts(trial, "mass_matrix") == verdicts(trial, "force") == {"agree"}
    assert trial["level"] == "links"


def test_traceback_has_the_users_lines_alone_in_every_view(judged, tmp_path):
    more = "def inner(q):\n    raise ValueError('here')\n\ndef bad(q, v): return inner(q)\n"
    answer, trial = judged(
        f"{more}def f(arm): return replace(two_link(arm), bias=bad)",
        *("--junit", tmp_path / "t.xml", "--out", tmp_path / "page"),
    )
    assert list(trial["tracebacks"]) == ["bias"]
    trace = trial["tracebacks"]["bias"]
    assert "crosscheck/trial" not in trace
    assert trace.count("  File ") == 2
    assert "in inner" in trace
    assert "bias raised:\nTraceback (most recent call last):" in answer.out
    assert trace in answer.out
    page = (tmp_path / "page" / "trial.html").read_text()
    assert "ValueError: here" in page
    assert "in inner" in page
    assert "ValueError: here" in (tmp_path / "t.xml").read_text()


def test_a_part_that_hangs_is_waited_for_once(judged, monkeypatch):
    monkeypatch.setattr(patience, "IDLE_S", 3.0)
    monkeypatch.setattr(patience, "LEAST_S", 0.01)
    answer, trial = judged(
        "def bad(q, v):\n    while True: time.sleep(1)\n"
        "def f(arm): return replace(two_link(arm), bias=bad)"
    )
    assert answer.code == 3
    assert "TooSlow: bias: stopped after" in answer.out
    assert "unfinished, not judged" in answer.out
    assert verdicts(trial, "mass_matrix") == {"agree"}


def test_answers_that_differ_from_call_to_call_are_named_so(judged):
    answer, _ = judged(
        "def f(arm):\n    own = two_link(arm)\n"
        "    return replace(own, mass_matrix=lambda q:"
        " np.array(own.mass_matrix(q)) * (1 + 1e-6 * random.random()))"
    )
    assert answer.code == 1
    assert "differ trial-own/paper-labelled/repeatable-mass_matrix/" in answer.out


@pytest.mark.parametrize(
    "source",
    [
        "def f(arm):\n    own = two_link(arm)\n    def M(q):\n        found = own.mass_matrix(q)\n"
        "        q[:] = 0\n        return found\n    return replace(own, mass_matrix=M)",
        "def f(arm):\n    own = two_link(arm)\n    def M(q):\n        print('x' * 10**6)\n"
        "        return own.mass_matrix(q)\n    return replace(own, mass_matrix=M)",
        "def f(arm):\n    own, kept = two_link(arm), np.zeros((2, 2))\n    def M(q):\n"
        "        kept[:] = own.mass_matrix(q)\n        return kept\n"
        "    return replace(own, mass_matrix=M)",
    ],
    ids=["changes its arguments", "prints a lot", "returns one array of its own every time"],
)
def test_habits_that_harm_nobody_are_no_slips(judged, source):
    answer, trial = judged(source)
    assert answer.code == 0
    assert "xx" not in answer.out
    assert trial["wrong"] == []
