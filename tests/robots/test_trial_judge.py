"""The judge of a robot's equations: each check sees what is just beyond its tolerance alone."""

import os
import re
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Robot
from crosscheck.report.trials.output import render_trial_page
from crosscheck.runner import cpu_limit
from crosscheck.trial.coordinates.robots import build_robot_frame, place_states
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.loading import extract_equations, load_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.robots.answers import draw_states
from tests.loops import require_items
from tests.robots import two_link
from tests.robots.trials import run_robot_trial

TOLERANCE = 1e-10  # of an entry's size, as the docs say
ABOVE, BELOW = 1.02, 0.98
ZERO = np.zeros(2)


@pytest.fixture(scope="module")
def two() -> Robot:
    return two_link.robot()


def verdicts(trial: Trial) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for finding in trial.agreement.findings:
        found.setdefault(finding.quantity, set()).add(finding.verdict)
    return found


def planted(part: str, by: float) -> Equations:
    """Equations with a part of which one entry is off by so many tolerances, at every state."""
    place = (0, 1) if part == "mass_matrix" else (1,)
    own = getattr(two_link, part)

    def wrong(q=ZERO, v=ZERO, a=ZERO, torque=ZERO):
        given = {"q": q, "v": v, "a": a, "torque": torque}
        names = own.__code__.co_varnames[: own.__code__.co_argcount]
        found = own(*(given[name] for name in names if name in given))
        found[place] += by * TOLERANCE * two_link.sizes(part, q, v, a, torque)[place]
        if part == "mass_matrix":
            found[1, 0] = found[0, 1]
        return found

    return Equations(**{part: wrong}, level="armature")


PARTS = ("mass_matrix", "bias", "gravity", "force", "inverse_dynamics", "acceleration")


@pytest.mark.parametrize("part", PARTS)
def test_an_entry_differs_just_beyond_its_tolerance(two, part):
    above = run_robot_trial(planted(part, ABOVE), two)
    assert verdicts(above)[part] == {"differ"}
    found = [f for f in above.agreement.findings if f.quantity == part]
    beside = [f for f in found if f.about.key.family == "trial-states"]
    assert [f.right for f in beside] == ["analytic", "pinocchio", "exudyn"]
    for finding in require_items(beside):
        assert finding.measured == pytest.approx(ABOVE * TOLERANCE, rel=1e-4)
        assert finding.tolerance == TOLERANCE
    place = "M[j1, j2]" if part == "mass_matrix" else f"{part}[j2]"
    shares = {entry.name: entry.share for entry in above.diagnosis.entries}
    assert shares[place] == pytest.approx(ABOVE * TOLERANCE, rel=1e-4)
    assert above.distances[0].largest == pytest.approx(ABOVE * TOLERANCE, rel=1e-4)
    below = run_robot_trial(planted(part, BELOW), two)
    assert below.exit_code == 0
    assert below.diagnosis.entries == ()


BETWEEN: dict[str, dict[str, object]] = {
    "inverse-dynamics": {
        "inverse_dynamics": lambda q, v, a: two_link.inverse_dynamics(q, v, a) + 1e-6 * a * v
    },
    "second-law": {"force": lambda q, torque: two_link.force(q, torque) + 1e-6},
    "acceleration-linear-in-torques": {
        "acceleration": lambda q, v, torque: two_link.acceleration(q, v, torque) + 1e-6 * torque**2
    },
}


@pytest.mark.parametrize("check", BETWEEN)
def test_what_parts_owe_to_each_other_is_judged(two, check):
    wrong = {part: getattr(two_link, part) for part in PARTS} | BETWEEN[check]
    trial = run_robot_trial(Equations(**wrong), two)
    assert check in {finding.quantity for finding in trial.agreement.disagreeing}


DIFFERENCES = 200 / 3  # times the tolerance, of what differences of answers leave
BY_DIFFERENCES = "bias-from-inertia", "gravity-is-a-gradient"


def by_differences(biased: float, turned: float) -> Equations:
    """A bias that is not M's, and weights that no energy has, off by so many tolerances.

    Of the larger sizes of two weights that of the shoulder over a bent elbow is the smallest.
    """
    bent = two_link.sizes("gravity", np.array([0.0, np.pi]), ZERO, ZERO, ZERO)[0]

    def bias(q, v):
        off = biased * DIFFERENCES * TOLERANCE * two_link.sizes("bias", q, v, ZERO, ZERO)
        return two_link.bias(q, v) + off

    def gravity(q):
        return two_link.gravity(q) + turned * DIFFERENCES * TOLERANCE * bent * np.array([0, q[0]])

    return two_link.right(bias=bias, gravity=gravity)


@pytest.mark.parametrize("off", [(ABOVE, BELOW), (BELOW, ABOVE)])
def test_what_parts_owe_to_each_other_is_judged_by_differences_of_answers(two, off):
    findings = run_robot_trial(by_differences(*off), two).agreement.findings
    own = {finding.quantity: finding for finding in findings}
    judged = [own[check].verdict for check in BY_DIFFERENCES]
    assert judged == ["differ" if by > 1 else "agree" for by in off]
    for check, by in zip(BY_DIFFERENCES, off, strict=True):
        assert own[check].tolerance == pytest.approx(DIFFERENCES * TOLERANCE, rel=1e-9)
        assert own[check].measured == pytest.approx(by * own[check].tolerance, rel=0.01)


def test_findings_say_what_is_compared_with_what(two, snapshot: SnapshotAssertion):
    trial = run_robot_trial(Equations(**{part: getattr(two_link, part) for part in PARTS}), two)
    findings = trial.agreement.findings
    assert {(each.verdict, each.unit) for each in findings} == {("agree", "1")}
    assert len({each.about.metric for each in findings}) == 1
    said = [f"{f.id}, {f.right}: {f.tolerance:.3g}, {f.basis}" for f in findings]
    assert [findings[0].about.metric, *sorted(said)] == snapshot


# Right parts of every kind; forms of numbers and of arguments are those of tests/trial/test_calls.
FORMS: dict[str, dict[str, object]] = {
    "names of the user's own": {
        "mass_matrix": lambda theta: two_link.mass_matrix(theta),
        "bias": lambda theta, omega: two_link.bias(theta, omega),
    },
    "by coriolis": {
        "mass_matrix": two_link.mass_matrix,
        "coriolis": two_link.coriolis,
        "gravity": two_link.gravity,
    },
    "inverse dynamics": {"inverse_dynamics": two_link.inverse_dynamics},
    "inverse dynamics without weights": {
        "inverse_dynamics": lambda q, v, a: two_link.inverse_dynamics(q, v, a) - two_link.gravity(q)
    },
    "acceleration": {"acceleration": two_link.acceleration},
    "everything": {part: getattr(two_link, part) for part in PARTS},
}


@pytest.mark.parametrize("form", FORMS)
def test_right_parts_in_any_form_are_never_blamed(two, form):
    trial = run_robot_trial(Equations(**FORMS[form]), two)
    assert trial.exit_code == 0, [finding.id for finding in trial.agreement.disagreeing]
    wanted = set(FORMS[form]) - {"coriolis"}
    assert set(trial.relative_errors) >= wanted


def position(x: np.ndarray, bend: float) -> np.ndarray:
    """The joints' q of other coordinates, on a curve unless bend is 0."""
    first = x[0] + 0.5 * x[1] + bend * (x[0] ** 3 / 1.5 + np.sin(x[1]))
    return np.array([first, 2.0 * x[1] + bend * np.sin(x[0])])


def slopes(x: np.ndarray, v: np.ndarray, bend: float) -> tuple[np.ndarray, np.ndarray]:
    """J of q' = J v, and its own rate."""
    first = [1.0 + 2.0 * bend * x[0] ** 2, 0.5 + bend * np.cos(x[1])]
    rates = [4.0 * bend * x[0] * v[0], -bend * np.sin(x[1]) * v[1]]
    J = np.array([first, [bend * np.cos(x[0]), 2.0]])
    return J, np.array([rates, [-bend * np.sin(x[0]) * v[0], 0.0]])


def carried(bend: float) -> dict[str, Callable[..., np.ndarray]]:
    """The parts in coordinates of q(x): J' M J, J' (h + M J. v) and so on, C J' (C J + M J.)."""

    def at(x, v=(0.0, 0.0)):
        J, J_dot = slopes(x, v, bend)
        return position(x, bend), J @ v, J, J_dot

    def mass_matrix(x):
        q, _, J, _ = at(x)
        return J.T @ two_link.mass_matrix(q) @ J

    def bias(x, v):
        q, rates, J, J_dot = at(x, v)
        return J.T @ (two_link.bias(q, rates) + two_link.mass_matrix(q) @ J_dot @ v)

    def coriolis(x, v):
        q, rates, J, J_dot = at(x, v)
        return J.T @ (two_link.coriolis(q, rates) @ J + two_link.mass_matrix(q) @ J_dot)

    def gravity(x):
        q, _, J, _ = at(x)
        return J.T @ two_link.gravity(q)

    def force(x, torque):
        return at(x)[2].T @ torque - gravity(x)

    def inverse_dynamics(x, v, a):
        return mass_matrix(x) @ a + bias(x, v) + gravity(x)

    def acceleration(x, v, torque):
        rest = at(x)[2].T @ torque - bias(x, v) - gravity(x)
        return np.linalg.solve(mass_matrix(x), rest)

    parts = mass_matrix, bias, coriolis, gravity, force, inverse_dynamics, acceleration
    return {each.__name__: each for each in parts}


BEND = 0.3
CURVED = Coordinates(function=partial(position, bend=BEND))
A, B = sp.symbols("a b")
SYMBOLIC = [A + B / 2 + BEND * (A**3 / 1.5 + sp.sin(B)), 2 * B + BEND * sp.sin(A)]
FRAMES = {
    "a matrix": (0.0, Coordinates(matrix=[[1.0, 0.5], [0.0, 2.0]])),
    "a function": (BEND, CURVED),
    "sympy": (BEND, Coordinates(function=sp.Matrix(SYMBOLIC), symbols=(A, B))),
}


@pytest.mark.parametrize("form", ["by coriolis", "inverse dynamics", "acceleration", "everything"])
@pytest.mark.parametrize("by", FRAMES)
def test_right_parts_in_other_coordinates_are_never_blamed(two, form, by):
    bend, frame = FRAMES[by]
    parts = carried(bend)
    own = Equations(**{part: parts[part] for part in FORMS[form]}, coordinates=frame)
    trial = run_robot_trial(own, two)
    assert trial.exit_code == 0, [finding.id for finding in trial.agreement.disagreeing]
    assert set(trial.relative_errors) >= set(FORMS[form]) - {"coriolis"}


def test_a_place_that_no_x_gives_is_shifted_to_one_that_some_x_gives(two):
    bounded = Coordinates(function=lambda x: np.array([1.2 * np.sin(x[0]), x[1]]))
    states = draw_states(two, 7, 0, (0, 1))
    drawn = np.column_stack([np.linspace(-2.0, 2.0, 7), states.q[:, 1]])
    placed = place_states(states._replace(q=drawn), build_robot_frame(bounded, two)).q
    assert (np.abs(placed[:, 0]) <= 1.2).all()
    assert placed[2:5] == pytest.approx(drawn[2:5])


def test_a_wrong_bias_of_curved_coordinates_is_reported(two):
    mass, bias = (carried(BEND)[part] for part in ("mass_matrix", "bias"))
    own = Equations(mass, lambda x, v: -bias(x, v), coordinates=CURVED)
    assert "bias[j1]" in {entry.name for entry in run_robot_trial(own, two).diagnosis.entries}
    with pytest.raises(InputError, match="bias: needs mass_matrix beside it"):
        run_robot_trial(Equations(bias=bias, coordinates=CURVED), two)


def test_what_inverse_dynamics_leaves_out_is_said(two):
    trial = run_robot_trial(Equations(**FORMS["inverse dynamics without weights"]), two)
    assert "inverse_dynamics leaves the weights out" in trial.scope
    assert len(run_robot_trial(Equations(**FORMS["inverse dynamics"]), two).scope) == 1


def test_of_as_many_wrong_entries_no_large_one_chooses_the_level(two):
    """Coupled has J and N J more in M[j1, j1] and M[j1, j2]: here 0.55 of the latter are there."""
    coupling = two_link.N * two_link.ROTOR * np.array([[0.0, 0.55], [0.55, 0.0]])
    wrong = coupling - np.diag([0.8, 0.0])
    own = Equations(mass_matrix=lambda q: two_link.mass_matrix(q) + wrong)
    first, second, *_ = run_robot_trial(own, two).distances
    assert (first.level, second.level) == ("coupled", "armature")
    assert first.entries == second.entries
    assert first.largest > second.largest


def test_a_stated_level_that_is_theirs_is_right(two):
    assert run_robot_trial(replace(two_link.right(), level="armature"), two).exit_code == 0


CANNOT = {
    "level = 'carriers': must be one of links, armature, coupled, elastic, or left out": {
        "level": "carriers"
    },
    "coordinates: of a robot's may have matrix": {"coordinates": Coordinates(gearing="free")},
    "coordinates.matrix: has shape": {"coordinates": Coordinates(matrix=np.eye(3))},
    "coriolis: give either bias or coriolis": {"coriolis": two_link.coriolis},
}


@pytest.mark.parametrize("line", CANNOT)
def test_what_cannot_be_judged_is_refused(two, line):
    with pytest.raises(InputError) as caught:
        run_robot_trial(replace(two_link.right(), **CANNOT[line]), two)
    assert line in str(caught.value)


def ends(q: np.ndarray) -> np.ndarray:
    os._exit(0)


def raises(q: np.ndarray) -> np.ndarray:
    raise SystemExit(0)


def hangs(q: np.ndarray) -> np.ndarray:
    while True:
        time.perf_counter()


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cpu_limit, "BASE_LIMIT_S", 0.2)
    monkeypatch.setattr(cpu_limit, "COST_FACTOR", 0.1)
    monkeypatch.setattr(cpu_limit, "LOOK_S", 0.1)


BROKEN = {
    "ends": (ends, "failed", "Died: the process of the model ended with exit code 0"),
    "raises": (raises, "failed", "SystemExit: 0 (gravity at q = ["),
    "hangs": (hangs, "unfinished", "TooSlow: stopped after"),
}


@pytest.mark.usefixtures("workers")
@pytest.mark.parametrize("case", BROKEN)
def test_a_part_that_does_not_answer_costs_that_part_alone(two, impatient, case):
    function, verdict, words = BROKEN[case]
    trial = run_robot_trial(two_link.right(gravity=function), two)
    (lost,) = trial.agreement.disagreeing
    assert (lost.verdict, lost.quantity) == (verdict, "answers-gravity")
    assert words in lost.note
    assert set(trial.relative_errors) == {"mass_matrix", "bias"}
    assert trial.exit_code == (3 if verdict == "unfinished" else 1)
    assert trial.scope[-1].startswith("not judged: gravity (")
    alone = run_robot_trial(Equations(gravity=function, level="coupled"), two)
    assert alone.diagnosis.level == "coupled"


NAMES = {
    "gravitiy": "is not a part of equations (did you mean gravity?); parts are mass_matrix,",
    "coriolis_matrix": "is not a part of equations (did you mean coriolis?)",
    "inertia_force": "is not a part of equations (did you mean force?)",
    "jacobian": "is not a part of equations; parts are mass_matrix,",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_is_no_part_is_refused_with_what_is_allowed(name):
    mine = SimpleNamespace(mass_matrix=two_link.mass_matrix, **{name: two_link.gravity})
    with pytest.raises(InputError, match=re.escape(f"mine: {name}: {NAMES[name]}")):
        extract_equations(mine, "mine")


def test_other_functions_of_a_model_are_named_as_not_judged(two):
    class Mine:
        mass_matrix = staticmethod(two_link.mass_matrix)

        def jacobian(self, q):
            return q

        def force_to_parent(self, R, f):  # takes what no force of equations takes
            return R @ f

    trial = run_robot_trial(extract_equations(Mine(), "mine", "is"), two)
    assert trial.scope[1:] == (
        "force_to_parent, jacobian: no part of equations, so not judged",
        "not judged: bias (not supplied), gravity (not supplied)",
    )


FILE = """
from numpy import eye, sin
def mass_matrix(q): return scale(eye(2))
def scale(M): return M
NAME = lambda q: q
def test_it(): NAME(0)
def main(): NAME(0)
"""


def test_functions_of_a_file_that_nothing_reads_are_as_those_of_an_object(two, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FILE.replace("NAME", "jacobian"), "utf-8")
    assert load_equations(str(file), two).unused == ("jacobian",)
    file.write_text(FILE.replace("NAME", "gravitiy"), "utf-8")
    with pytest.raises(InputError, match=re.escape(f"gravitiy: {NAMES['gravitiy']}")):
        load_equations(str(file), two)


def test_the_page_lists_as_many_entries_as_are_said_to_be_wrong(two):
    """What M makes wrong in other parts is neither counted nor listed."""

    def wrong(q, v, a):
        return two_link.inverse_dynamics(q, v, a) + np.array([a.sum(), 0])

    trial = run_robot_trial(Equations(inverse_dynamics=wrong), two)
    assert "inverse_dynamics" in {each.part for each in trial.wrong}
    (table,) = re.findall(
        "How far is each entry off.*?</table>", render_trial_page(trial), flags=re.S
    )
    (others,) = re.findall("and (\\d+) more", trial.headline)
    assert table.count("<tr><td>") == 1 + int(others)
