"""Every check of a trial differs just above its tolerance and agrees just below, for one number.

The judges are called on answers in which a single number is wrong by a known share of its natural
size. Sizes and tolerances are worked out here once more, from the right answers alone.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.registry import MODELS, reference_model, register
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import Evaluation, Simulation
from crosscheck.trial.arms import questions, suite
from crosscheck.trial.arms.model import make_registry_entry
from crosscheck.trial.arms.questions import (
    TransformedModel,
    VerificationProblem,
    skip_dependent_tasks,
    transform_model,
)
from crosscheck.trial.arms.subject import build_problem
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.judge.checks import find_idle_motors, judge_answers
from crosscheck.trial.request import TrialRequest
from tests.loops import require_items
from tests.mixed_arms import arm_of, direct
from tests.trial.test_trial import equations_of, in_frame

COUNT = 12
SPOT = 5  # the one state whose answer is wrong
ABOVE, BELOW = 1.05, 0.95  # of a tolerance
TOLERANCE = 1e-10  # of an entry's natural size, in coordinates that need no map
NAME = "yours"
RUN = load_scenario("pd").model_copy(update={"duration_s": 2e-5, "step_s": 1e-6})


def two_link() -> Arm:
    """A rigid arm of unlike numbers, with weight."""
    motors = (direct(motor_mass_kg=mass, rotor_inertia_kg_m2=0.02) for mass in (0.4, 0.2))
    links = (
        {"length_m": 0.5, "com_m": 0.23, "mass_kg": 1.3, "inertia_kg_m2": 0.03},
        {"length_m": 0.4, "com_m": 0.17, "mass_kg": 0.9, "inertia_kg_m2": 0.012},
    )
    return arm_of(*motors, links=links, payload_kg=0.3, gravity=(9.81, 0.0), name="two-link")


Findings = dict[tuple[str, str, str], Finding]


class Bench(NamedTuple):
    """Right equations of every part, each planned run and balance, right answers to all tasks."""

    problem: VerificationProblem
    comparisons: dict[tuple[str, str, str], Comparison]
    outcomes: dict[Any, Any]

    def key(self, part: str) -> Any:
        """The key of a question to the equations."""
        return self.problem.ask_equations(part).key

    def right(self, part: str) -> np.ndarray:
        """The right answers to a question, state by state."""
        return np.array(self.outcomes[self.key(part)])

    def findings(self, changed: dict[Any, Any]) -> Findings:
        """The findings on answers at states, some of them changed, by kind, quantity and engine."""
        results, level = Results({**self.outcomes, **changed}), self.problem.levels[0]
        answers = suite.collect_answers(self.problem, results)
        found = [check.finding for check in judge_answers(answers)]
        found += suite.judge_engines(self.problem, answers, level)
        return {(f.about.key.family, f.quantity, f.about.key.right): f for f in found}

    def finding(self, name: tuple[str, str, str], changed: dict[Any, Any]) -> Finding:
        """The finding of a comparison with some answers changed."""
        with registered(self.problem):
            if name in self.comparisons:
                return self.comparisons[name].finding(Results({**self.outcomes, **changed}))
            return self.findings(changed)[name]


@contextmanager
def registered(problem: VerificationProblem) -> Iterator[None]:
    with register(problem.name, make_registry_entry(problem.name, problem.equations, problem.has)):
        yield


@lru_cache
def bench(gearing: str) -> Bench:
    """The bench of a rigid or a geared arm."""
    arm = two_link() if gearing == "rigid" else load_arm("probe")
    level, model = ("links", "analytic:links") if gearing == "rigid" else ("", "analytic:physical")
    moved = in_frame(model, Coordinates(gearing), arm, load_scenario("pd"))

    def factory(arm: Arm, scenario: Any) -> Equations:
        moved = in_frame(model, Coordinates(gearing), arm, scenario)
        made = equations_of(moved)
        return replace(
            made,
            coordinates=Coordinates(gearing),
            level=level,
            inverse_dynamics=lambda x, v, a: moved.mass_matrix(x) @ a + moved.bias(x, v),
            acceleration=lambda t, x, v, torque: moved.model.acceleration(t, x, v),
        )

    own = replace(factory(arm, load_scenario("pd")), rebuild=factory)
    problem = replace(build_problem(TrialRequest(NAME, own, arm, quick=True)), count=COUNT)
    assert moved.frame.matrix is not None
    planned = [
        *suite.plan_run_comparisons(problem, RUN, level),
        *suite.plan_balance_checks(problem),
    ]
    comparisons = {
        (each.about.key.family, each.about.key.quantity, each.about.key.right): each
        for each in planned
    }
    with registered(problem):
        tasks = dict.fromkeys(task for each in planned for task in each.needs)
        tasks |= dict.fromkeys(map(problem.ask_equations, suite.list_quantities(problem)))
        outcomes = {task.key: task.perform() for task in tasks}
    return Bench(problem, comparisons, outcomes)


class Sizes(NamedTuple):
    """Natural sizes in joint angles, by the right answers: of M, terms of the bias, and rows."""

    mass: np.ndarray
    terms: np.ndarray
    bias: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray


@lru_cache
def sizes() -> Sizes:
    """The sizes of the rigid arm's entries."""
    made = bench("rigid")
    mass, rates = made.right("mass_matrix"), np.array([state.u for state in made.problem.states])
    root = np.sqrt(mass[:, [0, 1], [0, 1]].max(axis=0))
    energy = np.mean([u @ M @ u for M, u in zip(mass, rates, strict=True)])
    lively, rms = math.sqrt(energy * (rates**2).mean()), np.sqrt((rates**2).mean(axis=0))
    pairs = np.outer(root, root)
    one = np.ones(2)
    summed = np.maximum.reduce(
        [
            np.einsum("ij,k->ijk", pairs, one),
            np.einsum("ik,j->ijk", pairs, one),
            np.einsum("jk,i->ijk", pairs, one),
        ]
    )
    return Sizes(
        mass=pairs,
        terms=np.maximum((root * lively)[:, None, None] / np.outer(rms, rms), summed),
        bias=np.maximum(root * lively, np.einsum("ijk,j,k->i", summed, rms, rms)),
        force=np.sqrt((made.right("force") ** 2).mean(axis=0)),
        acceleration=np.sqrt((made.right("acceleration") ** 2).mean(axis=0)),
    )


@pytest.mark.parametrize("gearing", ["rigid", "free"])
def test_a_run_is_compared_with_engines_that_integrate_as_the_reference_does(gearing):
    """Others differ by what their own integrators leave."""
    made = bench(gearing)
    level = made.problem.equations.level
    planned = suite.plan_run_comparisons(made.problem, RUN, level)
    for engine in require_items({each.about.key.right for each in planned}):
        assert MODELS[engine].order == MODELS[reference_model()].order
        assert engine.endswith(f":{level}" if level else (":physical", ":tree"))


class Row(NamedTuple):
    """The one number that is wrong: in which answers, where, and its natural size.

    place: the entry as findings name it; tolerance: relative to that size.
    """

    part: str
    entry: tuple[int, ...]
    size: Callable[[], float]
    place: str
    tolerance: float = TOLERANCE


def _inverse_dynamics_size() -> float:
    a = np.abs(bench("rigid").right("inverse_dynamics")[:, 2]).max(axis=0)
    return float(sizes().bias[0] + sizes().mass[0] @ a)


ENTRIES = {
    "mass_matrix": Row(
        "mass_matrix", (0, 1), lambda: float(sizes().mass[0, 1]), "M[theta_1, theta_2]"
    ),
    "bias": Row("bias", (0,), lambda: float(sizes().bias[0]), "bias[theta_1]"),
    "force": Row("force", (0,), lambda: float(sizes().force[0]), "force[theta_1]"),
    "acceleration": Row(
        "acceleration", (0,), lambda: float(sizes().acceleration[0]), "acceleration[theta_1]"
    ),
}
OWN = {
    **{f"repeatable-{part}": row._replace(part=f"{part}_again") for part, row in ENTRIES.items()},
    "symmetric": ENTRIES["mass_matrix"]._replace(tolerance=1e-12),
    "bias-quadratic": ENTRIES["bias"]._replace(part="other_speeds", entry=(0, 0)),
    "bias-from-inertia": Row(
        "christoffel",
        (0, 0, 1),
        lambda: float(sizes().terms[0, 0, 1]),
        "bias[theta_1] of theta_1' theta_2'",
    ),
    "inverse-dynamics": Row(
        "inverse_dynamics", (0, 0), _inverse_dynamics_size, "inverse_dynamics[theta_1]"
    ),
    # The answer at twice the first torque, after those at no torque and at each.
    "linear-in-torques": ENTRIES["force"]._replace(part="by_torques", entry=(3, 0)),
    "second-law": ENTRIES["force"],
}
OTHERWISE = {"positive-definite"}
ENGINES = ("analytic:links", "pinocchio:links")
TABLE = {
    **{("trial-own", name, ""): row for name, row in OWN.items()},
    **{("trial-states", part, e): row for part, row in ENTRIES.items() for e in ENGINES},
}
BALANCES = {"power", "angular-momentum-rate"}
MESH_RUNS = {"x_sp", "x_pr"}


def planted(row: Row, by: float) -> dict[Any, Any]:
    """The answers with one number wrong by a share of its size, at one state."""
    made = bench("rigid")
    answers = made.right(row.part)
    answers[(SPOT, *row.entry)] += by * row.size()
    return {made.key(row.part): answers}


def test_the_tables_have_every_check_of_a_trial():
    """A new check needs a row here."""
    rigid, geared = bench("rigid").comparisons, bench("lumped").comparisons
    assert {name[1] for name in rigid} == set(suite.RIGID)
    assert {name[0] for name in rigid} == {suite.RUN}
    own = {*TABLE, *(("trial-own", name, "") for name in OTHERWISE)}
    assert set(bench("rigid").findings({})) == own
    other = {name[1] for name in geared} - {name[1] for name in rigid}
    assert other == BALANCES | MESH_RUNS


@pytest.mark.parametrize("name", TABLE, ids="-".join)
def test_a_number_is_judged_by_its_share_of_its_size(name):
    """Just below its tolerance, just above, and however large: no size has the user's numbers.

    An entry just beyond its tolerance is also named beside another that is a million sizes off.
    """
    row, made = TABLE[name], bench("rigid")
    for by, verdict in (
        (BELOW * row.tolerance, "agree"),
        (ABOVE * row.tolerance, "differ"),
        (1e6, "differ"),
    ):
        found = made.finding(name, planted(row, by))
        assert found.verdict == verdict
        assert found.measured == pytest.approx(by, rel=1e-3)
    ((key, answers),) = planted(row, ABOVE * row.tolerance).items()
    *before, last = row.entry
    answers[(SPOT, *before, 1 - last)] += 1e6 * row.size()
    assert row.place in made.finding(name, {key: answers}).note


@pytest.mark.parametrize(("part", "verdict"), [(ABOVE, "unresolved"), (BELOW, "agree")])
def test_engines_that_differ_by_more_than_an_error_would_judge_nobody(part, verdict):
    made, name, row = bench("rigid"), ("trial-states", "bias", ENGINES[1]), ENTRIES["bias"]
    bias = made.problem.evaluate(ENGINES[1], "bias")
    assert isinstance(bias, np.ndarray)
    before = float(bias[(SPOT, *row.entry)])
    bias[(SPOT, *row.entry)] += part * 1e-4 * row.size()
    try:
        assert made.finding(name, {}).verdict == verdict
    finally:
        bias[(SPOT, *row.entry)] = before


def test_an_engine_that_raises_fails_its_own_checks_alone(monkeypatch):
    def transform(name: str, *given: Any) -> TransformedModel:
        if name == ENGINES[1]:
            raise ArithmeticError("no answer")
        return transform_model(name, *given)

    monkeypatch.setattr(questions, "transform_model", transform)
    made = bench("rigid")
    found = made._replace(problem=replace(made.problem)).findings({})
    failed = {name[2] for name, each in found.items() if each.verdict == "failed"}
    assert failed == {ENGINES[1]}


@pytest.mark.parametrize(("below_0", "verdict"), [(1e-9, "failed"), (-1e-9, "agree")])
def test_a_mass_matrix_just_not_positive_definite_fails(below_0, verdict):
    made = bench("rigid")
    mass = made.right("mass_matrix")
    off = math.sqrt(mass[SPOT, 0, 0] * mass[SPOT, 1, 1]) * (1 + below_0)
    mass[SPOT, 0, 1] = mass[SPOT, 1, 0] = off
    name = ("trial-own", "positive-definite", "")
    found = made.finding(name, {made.key("mass_matrix"): mass})
    assert found.verdict == verdict
    where = f"at 1 of {COUNT} states: "
    assert found.note.startswith(where if verdict == "failed" else "")


@pytest.mark.parametrize("factor", [1e6, 1e-3, 4.45, 1e-12])
def test_what_equations_owe_to_themselves_they_owe_in_any_unit(factor):
    """M, bias and force of one consistent model, times a unit; an error of its size is seen."""
    made = bench("rigid")
    parts = ("mass_matrix", "bias", "force", "rate_terms", "christoffel", "by_torques")
    more = ("other_speeds", "mass_matrix_again", "bias_again", "force_again")
    scaled = {made.key(part): factor * made.right(part) for part in (*parts, *more)}
    for quantity in require_items(
        set(OWN) - {"inverse-dynamics", "second-law", "repeatable-acceleration"}
    ):
        name = ("trial-own", quantity, "")
        assert made.finding(name, scaled).verdict == "agree", quantity
        row = OWN[quantity]
        wrong = np.array(scaled[made.key(row.part)])
        wrong[(SPOT, *row.entry)] += 10 * factor * row.tolerance * row.size()
        changed = {**scaled, made.key(row.part): wrong}
        assert made.finding(name, changed).verdict == "differ", quantity


@pytest.mark.parametrize("gearing", ["rigid", "lumped"])
def test_a_run_just_beyond_what_rounding_explains_differs(gearing):
    made = bench(gearing)
    runs = {name: each for name, each in made.comparisons.items() if name[0] == suite.RUN}
    for name, comparison in require_items(runs.items()):
        yours, theirs, nudged = comparison.needs
        _, run, moved = (made.outcomes[task.key] for task in (yours, theirs, nudged))
        quantity, steps = name[1], RUN.duration_s / RUN.step_s
        grown = float(np.nanmax(np.abs(run[quantity].values - moved[quantity].values)))
        rounding = np.finfo(float).eps * float(np.nanmax(np.abs(run[quantity].values)))
        limit = 10 * math.sqrt(steps) * (grown + rounding)
        found = []
        for by in (2 * ABOVE, BELOW / 2):
            answer = run.copy(deep=True)
            answer[quantity].values[(1, *[0] * (answer[quantity].ndim - 1))] += by * limit
            found.append(made.finding(name, {yours.key: answer}).verdict)
        assert found == ["differ", "agree"], name


def test_a_function_that_does_not_come_back_costs_what_calls_it_alone():
    made = bench("rigid")
    tasks = [task for each in made.comparisons.values() for task in each.needs]
    tasks += map(made.problem.ask_equations, suite.list_quantities(made.problem))
    why = Failure("TooSlow", "stopped")
    skipped = skip_dependent_tasks(made.problem, tasks, {"bias": why})
    assert {task.model for task in skipped} == {NAME}
    assert set(skipped.values()) == {why}
    asked = {task.quantity for task in skipped if not isinstance(task, Simulation)}
    callers = {"bias", "bias_again", "rate_terms", "other_speeds", "inverse_dynamics"}
    assert asked == callers
    assert skip_dependent_tasks(made.problem, tasks, {}) == {}


def test_a_run_that_outgrows_all_numbers_has_diverged():
    problem = bench("rigid").problem
    huge = replace(
        problem.equations, acceleration=lambda t, x, v, torque: np.full(2, 1e308), rebuild=None
    )
    model = make_registry_entry(NAME, huge, problem.has).made
    with np.errstate(all="ignore"), pytest.raises(Diverged, match="yours: diverged at t = 1e-05"):
        model(problem.case.arm, RUN).simulate()


def test_a_motor_is_idle_if_its_torque_changes_no_part_at_no_state():
    """At no torque, of each motor alone, twice that, of all; of the coordinates 0, 2 and 3."""
    force, acceleration = np.zeros((2, 5, 8, 4))
    force[:, 1, 0], acceleration[3, 2, 1] = 1.0, 1e-9
    answers: Any = SimpleNamespace(by_torques={"force": force, "acceleration": acceleration})
    assert find_idle_motors(answers, (0, 2, 3)) == (3,)


@pytest.mark.parametrize("name", sorted(BALANCES))
def test_a_balance_just_open_differs(name):
    """A moment on a link that nobody exerts, at one state; its power is that times the rate."""
    made = bench("lumped")
    (key,) = (each for each in made.comparisons if each[1] == name)
    asked = (each for each in made.comparisons[key].needs if isinstance(each, Evaluation))
    (task,) = (each for each in asked if each.quantity == "acceleration")
    right = np.array(made.outcomes[task.key])
    plain = made.finding(key, {})
    large = right.copy()
    large[SPOT, -1] += 1e-3
    slope = made.finding(key, {task.key: large}).measured / 1e-3
    found = []
    for by in (ABOVE, BELOW):
        answers = right.copy()
        answers[SPOT, -1] += by * plain.tolerance / slope
        found.append(made.finding(key, {task.key: answers}).verdict)
    assert found == ["differ", "agree"]
