"""Every comparison of a trial: what the equations owe to themselves, then to the engines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.inertia import SYMMETRY
from crosscheck.checks.invariants import plan_balances
from crosscheck.checks.scales import acceptance_limit
from crosscheck.checks.states import LOOSEST, is_usable, scale_mass_matrix
from crosscheck.checks.trajectories import UNITS, Pair, check_same_step, size
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
)
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.planning.arms import sample_model
from crosscheck.planning.comparison import Comparison, Results, make_comparison
from crosscheck.planning.plan import perturb_start_by_one_ulp
from crosscheck.registry import MODELS, find_same_integrator_models
from crosscheck.runner.tasks import Evaluation, RunKey, Simulation
from crosscheck.trial.judge import entries
from crosscheck.trial.judge.entries import EntryPlace, NaturalSizes
from crosscheck.trial.judge.questions import AGAIN, StateQuestion, VerificationProblem

MEANINGFUL = 1e-4  # engines further apart, at the end of what numbers can do, judge nobody
COMPARED = ("mass_matrix", "bias", "gravity", "force", "acceleration")
WHOLE = frozenset(COMPARED) - {"gravity"}  # parts without which equations are not complete
RUN = "trial-run"
RIGID = ("theta", "theta_dot", "kinetic_energy")
MESH = ("x_sp", "x_pr")
NO_DIAGONAL = "the diagonal is not positive at every state"
CheckResult = tuple[Finding, list[EntryPlace]]
Check = Callable[..., CheckResult]  # of About, sizes, and the answers to what is asked


class TrustedAnswers(NamedTuple):
    """The reference's M (count, n, n) and vectors (count, n), state by state.

    gravity: None of equations that count the weights in force.
    """

    mass: np.ndarray
    force: np.ndarray | None
    acceleration: np.ndarray | None
    gravity: np.ndarray | None


def make_size_questions(problem: VerificationProblem, level: str) -> list[StateQuestion]:
    """The questions whose answers give the sizes, of the reference: M first."""
    parts = ("mass_matrix", "force", "acceleration", "gravity")
    return [
        problem.ask(problem.reference(level), part)
        for part in (parts if problem.has_gravity else parts[:-1])
    ]


def get_trusted_answers(
    problem: VerificationProblem, results: Results, level: str
) -> TrustedAnswers:
    """The reference's answers that give the sizes. Raises MissingResult without M."""
    mass, *others = make_size_questions(problem, level)
    force, acceleration, *gravity = map(results.get_if_finished, others)
    return TrustedAnswers(results.need(mass), force, acceleration, *(gravity or (None,)))


def compute_natural_sizes(
    problem: VerificationProblem, results: Results, level: str
) -> NaturalSizes:
    """Natural sizes by the reference's answers. Raises MissingResult."""
    return results.derive(problem, level, partial(_compute_sizes, problem, results, level))


def _compute_sizes(problem: VerificationProblem, results: Results, level: str) -> NaturalSizes:
    precision = problem.equations.table.precision if problem.equations.table else 0.0
    answers = get_trusted_answers(problem, results, level)
    return entries.compute_sizes(problem.frame, problem.states, *answers, precision)


def plan_self_checks(problem: VerificationProblem) -> Iterator[Comparison]:
    """Engine-free checks of the parts that are there; the reference lends its sizes alone."""
    has, equations = problem.has, problem.equations
    for part in COMPARED:
        worked_out = part in ("force", "acceleration") and getattr(equations, part) is None
        if part in has and not worked_out:
            again = _entry_check(part, partial(_relative_errors, part))
            yield _self_check(problem, f"repeatable-{part}", again, part, part, f"{part}{AGAIN}")
    if "mass_matrix" in has:
        yield _self_check(problem, "symmetric", _check_symmetry, "mass_matrix", "mass_matrix")
        yield _self_check(
            problem, "positive-definite", _check_positive, "mass_matrix", "mass_matrix"
        )
    if "bias" in has:
        quadratic = _entry_check("bias", _quadratic_errors)
        yield _self_check(problem, "bias-quadratic", quadratic, "bias", "bias", "other_speeds")
    if {"mass_matrix", "bias"} <= has:
        demanded, terms = (
            _entry_check("rate_terms", partial(_relative_errors, "rate_terms")),
            "rate_terms",
        )
        yield _self_check(
            problem, "bias-from-inertia", demanded, "mass_matrix", terms, "christoffel"
        )
    if equations.inverse_dynamics is not None:
        whole = _entry_check("bias", _inverse_dynamics_errors)
        yield _self_check(problem, "inverse-dynamics", whole, "mass_matrix", "inverse_dynamics")
    if equations.force is not None and problem.motors:
        linear = _entry_check("force", _torque_linearity_errors)
        yield _self_check(problem, "linear-in-torques", linear, "force", "by_torques")
    if equations.acceleration is not None and has >= WHOLE:
        parts = [part for part in COMPARED if part in has]
        yield _self_check(
            problem, "second-law", _entry_check("force", _second_law_errors), "force", *parts
        )


def _self_check(
    problem: VerificationProblem, quantity: str, check: Check, unit_part: str, *parts: str
) -> Comparison:
    """A check of equations against themselves.

    Args:
        problem: The equations.
        quantity: The name of the check.
        check: Judges the answers to ``parts``.
        unit_part: The part whose numbers show the unit of what is judged.
        parts: The questions whose answers are judged.
    """
    questions = tuple(map(problem.ask_equations, parts))
    key = ComparisonKey("trial-own", problem.case.arm.name, quantity, problem.name)
    metric = f"largest relative deviation of an entry over {problem.states_in_words}"

    def judge(about: Subject, results: Results) -> Finding:
        answers = [results.need(question) for question in questions]
        finding, places = check(about, _sizes_in_user_unit(problem, results, unit_part), *answers)
        return replace(
            finding, note=finding.note or entries.format_wrong_entries(places, problem.frame.names)
        )

    about = Subject(key, "1", metric, "first principles")
    right = (problem.ask(problem.reference(level), unit_part) for level in problem.levels)
    sizes = (
        question for level in problem.levels for question in make_size_questions(problem, level)
    )
    needs = dict.fromkeys((*questions, problem.ask_equations(unit_part), *right, *sizes))
    return Comparison(about, tuple(needs), judge)


def _sizes_in_user_unit(
    problem: VerificationProblem, results: Results, unit_part: str
) -> NaturalSizes:
    """Natural sizes by the level that is nearest, in the unit of the equations' own numbers.

    They size the self-consistency checks: only the power of ten of the user's unit enters them.
    Raises MissingResult.
    """
    user_values, ratios = results.need(problem.ask_equations(unit_part)), dict[str, float]()
    for level in problem.levels:
        reference_values = results.get_if_finished(problem.ask(problem.reference(level), unit_part))
        ratios[level] = (
            1.0 if reference_values is None else entries.unit_ratio(user_values, reference_values)
        )
    nearest = min(problem.levels, key=lambda level: abs(math.log(ratios[level])))
    sizes = compute_natural_sizes(problem, results, nearest)
    return sizes.scale_by(entries.power_of_ten(ratios[nearest]))


def _entry_check(quantity: str, relative_errors_of: Callable[..., np.ndarray]) -> Check:
    """A check of every entry; relative_errors_of: how far it is off, by sizes and answers, over its
    size.
    """

    def check(about: Subject, sizes: NaturalSizes, *answers: np.ndarray) -> CheckResult:
        relative_errors, tolerance = relative_errors_of(sizes, *answers), sizes.tolerance(quantity)
        beyond = np.argwhere(~(relative_errors <= tolerance))
        wrong = [entries.entry_place(quantity, tuple(index)) for index in beyond.tolist()]
        basis = sizes.basis(quantity)
        return make_check(
            about, measured=float(relative_errors.max()), tolerance=tolerance, basis=basis
        ), wrong

    return check


def _relative_errors(
    quantity: str, sizes: NaturalSizes, values: np.ndarray, expected: np.ndarray
) -> np.ndarray:
    """Deviations of two answers: to a question asked twice, or of bias terms and what M demands."""
    return entries.deviations(values, expected, sizes.entry_sizes(quantity))


def _check_symmetry(about: Subject, sizes: NaturalSizes, mass: np.ndarray) -> CheckResult:
    """Check that M (count, n, n) equals its transpose at every state."""
    if not all(map(is_usable, mass)):
        lowest = np.einsum("kii->ki", mass).min(axis=0)
        bad = np.flatnonzero(~(lowest > 0)).tolist()
        return make_failed_check(about, NO_DIAGONAL), [EntryPlace("mass_matrix", i, i) for i in bad]
    relative_errors = entries.deviations(mass, mass.swapaxes(1, 2), sizes.mass)
    tolerance = SYMMETRY + sizes.file_rounding("mass_matrix")
    wrong = [EntryPlace("mass_matrix", i, j) for i, j in np.argwhere(relative_errors > tolerance)]
    basis = "rounding of the entries' natural sizes"
    return make_check(
        about, measured=float(relative_errors.max()), tolerance=tolerance, basis=basis
    ), wrong


def _check_positive(about: Subject, sizes: NaturalSizes, mass: np.ndarray) -> CheckResult:
    """Check that the scaled M (count, n, n) has positive eigenvalues at every state."""
    if not all(map(is_usable, mass)):
        return make_failed_check(about, NO_DIAGONAL), []
    symmetric_part = (mass + mass.swapaxes(1, 2)) / 2
    lowest = [
        float(np.linalg.eigvalsh(scale_mass_matrix(matrix)).min()) for matrix in symmetric_part
    ]
    state = int(np.argmin(lowest))
    if lowest[state] <= 0:
        note = f"not positive definite at state {state + 1} of {len(mass)}: {lowest[state]:.3g}"
        return make_failed_check(about, note), []
    return make_check(about, measured=0.0, tolerance=0.0, basis="every eigenvalue is positive"), []


def _quadratic_errors(sizes: NaturalSizes, bias: np.ndarray, at_speeds: np.ndarray) -> np.ndarray:
    """Deviation from h(x, s u) = s^2 h(x, u) for s = -1 and 2, and h(x, 0) = 0, shape (n,).

    bias (count, n); at_speeds (count, speeds + 1, n): h(x, s u) / s^2, then h(x, 0).
    """
    expected = np.repeat(bias[:, None], at_speeds.shape[1], axis=1)
    expected[:, -1] = 0.0
    return (np.abs(at_speeds - expected) / sizes.bias).max(axis=(0, 1))


def _torque_linearity_errors(sizes: NaturalSizes, answers: np.ndarray) -> np.ndarray:
    """Deviation of forces (n,) from sums of what each torque does, proportional to it.

    answers (count, 2 m + 2, n): at no torque, each alone, twice each alone, all together.
    """
    joints = (answers.shape[1] - 2) // 2
    none, each = answers[:, :1], answers[:, 1 : 1 + joints]
    twice, together = answers[:, 1 + joints : -1], answers[:, -1:]
    doubled = twice - none - 2 * (each - none)
    summed = together - none - (each - none).sum(axis=1, keepdims=True)
    differences: np.ndarray = np.abs(np.concatenate([doubled, summed], axis=1)).max(axis=(0, 1))
    return differences / sizes.force


def _second_law_errors(sizes: NaturalSizes, *answers: np.ndarray) -> np.ndarray:
    """Deviation from M a + h = f, with the acceleration that was supplied beside them, (n,).

    answers: M (count, n, n); bias, gravity if it is apart, force and acceleration (count, n).
    """
    mass, *held, force, acceleration = answers
    left = np.einsum("kij,kj->ki", mass, acceleration) + sum(held)
    return entries.deviations(left, force, sizes.force)


def _inverse_dynamics_errors(sizes: NaturalSizes, answers: np.ndarray) -> np.ndarray:
    """Deviation of inverse dynamics from M a + h, for any a and u together, shape (n,).

    answers (count, 3, n): as supplied; M a + h; a.
    """
    torques, expected, a = answers.swapaxes(0, 1)
    size = sizes.bias + sizes.mass @ np.abs(a).max(axis=0)
    return entries.deviations(torques, expected, size)


def plan_balance_checks(problem: VerificationProblem) -> Iterator[Comparison]:
    """Checks of power and momentum, for geared equations that have everything.

    There are none if the map is a function: it need not reach every pose that these checks draw.
    """
    rigid = problem.gearing == "rigid"
    if rigid or problem.frame.matrix is None or not problem.has >= WHOLE:
        return
    name, case = problem.name, problem.case
    reference = sample_model(
        case.arm.name, problem.reference(""), case, problem.count, problem.seed
    )
    sampled = replace(reference, model=name, evaluate=partial(Evaluation, name))
    for balance in plan_balances(sampled):
        judge = partial(_judge_balance, problem, balance)
        yield Comparison(balance.about, (*balance.needs, *make_size_questions(problem, "")), judge)


def _judge_balance(
    problem: VerificationProblem, balance: Comparison, about: Subject, results: Results
) -> Finding:
    """The finding of a balance, its tolerance widened by the rounding of the coordinates' map."""
    finding, sizes = balance.judge(about, results), compute_natural_sizes(problem, results, "")
    if finding.measured is None or finding.tolerance is None:
        return finding
    looser = sizes.tolerance("acceleration") / LOOSEST
    return make_check(
        about,
        measured=finding.measured,
        tolerance=finding.tolerance * looser,
        basis=f"{finding.basis}; times {looser:.3g}: {sizes.basis('acceleration')}",
        relative=finding.relative,
    )


def plan_engine_comparisons(
    problem: VerificationProblem, level: str, *, binding: bool
) -> Iterator[Comparison]:
    """Compare every part with every engine.

    binding: whether they must agree; if not, as at a level that is not claimed, they are measured.
    """
    for part in COMPARED:
        for engine in problem.engines(level) if part in problem.has else ():
            yield _compare_with_engine(problem, engine, part, level, binding)


def _compare_with_engine(
    problem: VerificationProblem, engine: str, part: str, level: str, binding: bool
) -> Comparison:
    user_question, engine_question = problem.ask_equations(part), problem.ask(engine, part)
    reference = problem.ask(problem.reference(level), part)
    key = ComparisonKey("trial-states", problem.case.arm.name, part, problem.name, engine)
    metric = f"largest relative difference of an entry over {problem.states_in_words}"

    def judge(about: Subject, results: Results) -> Finding:
        user_values, engine_values = results.need(user_question), results.need(engine_question)
        sizes = compute_natural_sizes(problem, results, level)
        measured = float(
            entries.deviations(user_values, engine_values, sizes.entry_sizes(part)).max()
        )
        if not binding:
            return make_measurement(about, measured=measured)
        wrong = [
            each.place
            for each in entries.find_wrong_entries(part, user_values, engine_values, sizes)
        ]
        among = float(
            entries.deviations(
                results.need(reference), engine_values, sizes.entry_sizes(part)
            ).max()
        )
        return make_check(
            about,
            measured=measured,
            tolerance=sizes.tolerance(part) + among,
            basis=f"{sizes.basis(part)}; engines among themselves {among:.2g}",
            resolved=among <= MEANINGFUL,
            relative=measured,
            note=entries.format_wrong_entries(wrong, problem.frame.names),
        )

    needs = dict.fromkeys(
        (user_question, engine_question, reference, *make_size_questions(problem, level))
    )
    return Comparison(Subject(key, "1", metric), tuple(needs), judge)


def plan_run_comparisons(
    problem: VerificationProblem, scenario: Scenario, level: str
) -> Iterator[Comparison]:
    """Compare a scenario's run by the equations with each engine that takes the same steps."""
    engines = find_same_integrator_models()
    if level:
        engines = tuple(name for name in problem.engines(level) if MODELS[name].order == 4)
    meshes = () if level or not problem.frame.layout.mesh_joints else MESH
    for engine in engines:
        for quantity in (*RIGID, *meshes):
            yield _compare_same_steps(problem, scenario, engine, quantity)


def _compare_same_steps(
    problem: VerificationProblem, scenario: Scenario, engine: str, quantity: str
) -> Comparison:
    case, name = problem.case._replace(scenario=scenario), scenario.name
    user_run = Simulation(RunKey(name, problem.name), case)
    engine_run = Simulation(RunKey(name, engine), case)
    repeated = Simulation(RunKey(name, engine, "nudged"), perturb_start_by_one_ulp(case))

    def judge(
        about: Subject, user_trajectory: Any, engine_trajectory: Any, nudged_trajectory: Any
    ) -> Finding:
        widest = acceptance_limit(quantity, case.arm, scenario, size(engine_trajectory, quantity))
        return check_same_step(
            about,
            user_trajectory,
            engine_trajectory,
            Pair(engine_trajectory, nudged_trajectory),
            widest,
        )

    key = ComparisonKey(RUN, name, quantity, problem.name, engine)
    about = Subject(key, UNITS[quantity], "largest absolute difference")
    return make_comparison(about, (user_run, engine_run, repeated), judge)
